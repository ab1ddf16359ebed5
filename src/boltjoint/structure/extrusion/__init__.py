"""Meshes of bodies that are plan views extruded along z: plates and flanges with bolts."""
