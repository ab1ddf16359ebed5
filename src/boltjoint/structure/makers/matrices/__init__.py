"""Structures from stiffness and mass matrices of another program."""
