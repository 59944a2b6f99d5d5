"""Shapes that are blends of others."""

from ifs.mixtures.mixed_surface import BordersApart, between
from ifs.mixtures.mixing import mixed, projected, rational
from ifs.mixtures.modulation import combined, modulated

__all__ = [
    "BordersApart",
    "between",
    "combined",
    "mixed",
    "modulated",
    "projected",
    "rational",
]
