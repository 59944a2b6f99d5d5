"""Meshes that are fine only where they must be."""
