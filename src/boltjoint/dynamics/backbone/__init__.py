"""Nonlinear modes, their backbones, and responses that are synthesised from these."""
