"""Sets between sets, and the clouds that they become."""

from ifs.medians.condensation import coverage
from ifs.medians.median_sets import hausdorff_distance, left_median, median, right_median, turned_median

__all__ = [
    "coverage",
    "hausdorff_distance",
    "left_median",
    "median",
    "right_median",
    "turned_median",
]
