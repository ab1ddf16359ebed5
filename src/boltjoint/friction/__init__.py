"""Friction element laws: force, tangent and contact state over one period of motion."""
