"""Nonlinear vibration of bolted lap joints, from dimensions to frequency responses."""

from importlib.metadata import version

__version__ = version("boltjoint")
