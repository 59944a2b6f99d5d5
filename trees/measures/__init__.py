"""Measures of sets of cells: moments, frames, normalised trees, counts of nodes, distances."""

from trees.measures.counts import BoxDimension, box_dimension, node_counts
from trees.measures.distances import cell_distance, hausdorff_distance, jaccard_distance, node_distance
from trees.measures.frame import Frame, principal_frame
from trees.measures.moments import Moments, moments
from trees.measures.normal import normalised

__all__ = [
    "BoxDimension",
    "Frame",
    "Moments",
    "box_dimension",
    "cell_distance",
    "hausdorff_distance",
    "jaccard_distance",
    "moments",
    "node_counts",
    "node_distance",
    "normalised",
    "principal_frame",
]
