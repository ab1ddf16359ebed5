"""Calibration of joints by measured backbones and responses: parameters and their uncertainty."""
