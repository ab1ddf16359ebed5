"""Makers: what turns descriptions into structures, one folder each."""
