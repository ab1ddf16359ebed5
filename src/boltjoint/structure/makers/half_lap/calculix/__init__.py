"""Verification of modes and preload by CalculiX: input decks, results and their comparison."""
