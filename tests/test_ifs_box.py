"""The bounding box of shapes whose extremes are known, or sampled without the engine."""

import numpy as np
import pytest

import automata
import ifs

KNOWN = {
    "koch-curve": ([0, 0], [90, 90 / np.sqrt(12)]),
    "takagi-curve": ([0, 0], [80, 160 / 3]),  # Takagi's function is at most 2/3
    "sierpinski-tetrahedron": ([0, 0, 0], [60, 30 * np.sqrt(3), 20 * np.sqrt(6)]),
    "menger-sponge": ([0, 0, 0], [54, 54, 54]),
    "corner-cutting": ([15, 30], [45, 45]),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_extremes_are_met_within_the_tolerance(name):
    low, high = map(np.array, KNOWN[name])
    size = float((high - low).max())
    for tolerance in (1e-2, 1e-3):
        found_low, found_high = ifs.bounding_box(ifs.shape(name), tolerance)
        assert (found_low <= low + 1e-9 * size).all()
        assert (found_high >= high - 1e-9 * size).all()
        # The tolerance counts in the size of the first, loose box: at most twice the true one here.
        assert (low - found_low).max() <= 2 * tolerance * size
        assert (found_high - high).max() <= 2 * tolerance * size


@pytest.mark.parametrize("name", automata.builtin_names())
def test_every_vertex_of_a_deep_mesh_lies_in_the_box(name):
    shape = ifs.shape(name)
    vertices = ifs.mesh(shape, 3 if name == "menger-sponge" else 5).vertices
    low, high = ifs.bounding_box(shape)
    assert (vertices >= low - 1e-9).all()
    assert (vertices <= high + 1e-9).all()
