"""Measurements: signals, and frequency and damping over amplitude that are identified from them."""
