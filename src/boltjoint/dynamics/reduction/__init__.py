"""Reductions by backbones: contact-adapted bases, and weighted pairs."""
