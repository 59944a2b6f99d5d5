"""Sizes of pieces: dimensions, parametrisations, and systems with the same gluing."""
