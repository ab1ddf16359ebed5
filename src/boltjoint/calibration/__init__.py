"""Calibration of joints by measured backbones: parameters, their uncertainty, and residuals."""
