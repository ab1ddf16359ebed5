"""Solid elements: shape functions, integration, stiffness and mass of elements and of bodies."""
