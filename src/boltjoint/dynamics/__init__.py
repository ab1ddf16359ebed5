"""Harmonic balance of a joint, its coordinates, backbones and frequency responses."""
