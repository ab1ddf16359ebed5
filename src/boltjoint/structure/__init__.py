"""The linear structure: mesh, elasticity, bolt preload and modes of a half-lap assembly."""
