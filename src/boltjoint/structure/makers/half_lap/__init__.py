"""Plan and mesh of half-lap assemblies."""
