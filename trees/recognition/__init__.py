"""Recognition of shapes: by attributes in a labelled tree, and by correlation of normalised trees."""

from trees.recognition.attributes import attribute_names, attributes
from trees.recognition.correlating import CorrelatingClassifier
from trees.recognition.labelled import LabelledTree, labelled_tree
from trees.recognition.spectral import SpectralClassifier

__all__ = [
    "CorrelatingClassifier",
    "LabelledTree",
    "SpectralClassifier",
    "attribute_names",
    "attributes",
    "labelled_tree",
]
