"""Harmonic balance of a joint, any number of harmonics: equations, motions and energy."""
