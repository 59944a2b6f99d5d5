"""Shapes that are blends of others."""
