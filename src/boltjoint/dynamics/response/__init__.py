"""Frequency responses in any coordinates: branches, peaks with all harmonics, and stability."""
