"""Surfaces: how tensor products and patches leave their points, with quarter planes, normals and orders."""

from fld.surfaces.corners import PatchCorner
from fld.surfaces.directional import Directional, directional
from fld.surfaces.leaving import Leaving
from fld.surfaces.products import Product, ProductPoint, Section, product, product_point
from fld.surfaces.quarters import Quarter, Quarters, quarters
from fld.surfaces.vertices import Patches, Vertex, along_edge, patches, vertex

__all__ = [
    "Directional",
    "Leaving",
    "PatchCorner",
    "Patches",
    "Product",
    "ProductPoint",
    "Quarter",
    "Quarters",
    "Section",
    "Vertex",
    "along_edge",
    "directional",
    "patches",
    "product",
    "product_point",
    "quarters",
    "vertex",
]
