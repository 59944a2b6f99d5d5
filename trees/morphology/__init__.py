"""Mathematical morphology of trees: elements, filters, ranks, distances, and convex hulls."""

from trees.morphology.distances import distances, within
from trees.morphology.elements import Ball, Box, Diamond
from trees.morphology.filters import closing, dilation, erosion, opening
from trees.morphology.hull import convex_hull
from trees.morphology.ranks import median, rank

__all__ = [
    "Ball",
    "Box",
    "Diamond",
    "closing",
    "convex_hull",
    "dilation",
    "distances",
    "erosion",
    "median",
    "opening",
    "rank",
    "within",
]
