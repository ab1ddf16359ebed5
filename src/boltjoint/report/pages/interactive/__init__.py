"""Drawings on pages that answer the pointer: responses, backbones and the joint in space."""
