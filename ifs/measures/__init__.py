"""Invariant measures: moments, areas, densities."""
