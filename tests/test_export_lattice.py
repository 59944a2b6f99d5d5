"""Voxels of systems on a lattice, by the states of boxes: equal to a walk over all pieces, and far beyond."""

from contextlib import suppress
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import ifs
from export.voxels import lattice
from export.voxels.lattice import NotOnLattice
from export.voxels.voxelise import voxelise
from ifs.maps.maps import Map, affine
from ifs.maps.plain import from_maps
from trees import from_substitution, to_points
from trees.shared import Shared

HALF = Fraction(1, 2)


def shrunk(ratio: Fraction, places, turns=None) -> list[Map]:
    """Maps `x -> ratio (turn x) + place`, each turn a signed permutation about the middle of the unit box."""
    maps = []
    for number, place in enumerate(places):
        axes = len(place)
        turn = np.eye(axes, dtype=int) if turns is None else turns[number]
        middle = np.full(axes, HALF)
        shift = middle - turn.astype(object) @ middle
        linear = [[ratio * int(x) for x in row] for row in turn]
        maps.append(affine(linear, [ratio * s + Fraction(p) for s, p in zip(shift, place, strict=True)]))
    return maps


def same_both_ways(shape: ifs.Shape, resolution: int, **options) -> int:
    exact = voxelise(shape, resolution, way="lattice", **options)
    assert exact.tree == voxelise(shape, resolution, way="walk", **options).tree
    assert exact.way == "lattice"
    return exact.tree.count


def corner_tetrahedron() -> ifs.Shape:
    corners = [[0, 0, 0], [HALF, 0, 0], [0, HALF, 0], [0, 0, HALF]]
    return ifs.shape(from_maps(shrunk(HALF, corners)))


def test_the_tetrahedron_at_a_million_a_side():
    found = voxelise(corner_tetrahedron(), 2**20)
    assert found.way == "lattice"
    assert found.tree.count == 4**20
    assert found.outer == 0
    assert isinstance(found.tree.form, Shared)
    rules = {"t": ["t", "t", "t", False, "t", False, False, False]}
    assert found.tree == from_substitution(rules, "t", 20, found.tree.cube)


@pytest.mark.parametrize("resolution", [4, 32, 12, 20, 48])
def test_the_tetrahedron_on_grids_it_fits_or_not(resolution):
    same_both_ways(corner_tetrahedron(), resolution)


@pytest.mark.parametrize(("resolution", "count"), [(3, 20), (9, 400), (27, 8000)])
def test_the_sponge_on_its_own_grids(resolution, count):
    assert same_both_ways(ifs.shape("menger-sponge"), resolution) == count


@pytest.mark.parametrize("resolution", [10, 16, 24])
def test_the_sponge_on_other_grids(resolution):
    same_both_ways(ifs.shape("menger-sponge"), resolution)


@pytest.mark.parametrize("depth", [0, 1, 2])
@pytest.mark.parametrize("resolution", [9, 18, 12])
def test_levels_of_the_sponge_as_solids(depth, resolution):
    found = same_both_ways(ifs.shape("menger-sponge"), resolution, depth=depth)
    if resolution % 3**depth == 0:
        assert found == 20**depth * (resolution // 3**depth) ** 3


def test_dust_and_plane_shapes():
    dust = ifs.shape(from_maps(shrunk(Fraction(1, 4), list(product([0, Fraction(3, 4)], repeat=3)))))
    assert same_both_ways(dust, 64) == 8**3
    carpet = ifs.shape(
        from_maps(
            shrunk(
                Fraction(1, 3),
                [
                    (Fraction(i, 3), Fraction(j, 3))
                    for i, j in product(range(3), repeat=2)
                    if (i, j) != (1, 1)
                ],
            )
        )
    )
    assert same_both_ways(carpet, 27) == 8**3
    line = ifs.shape(from_maps(shrunk(HALF, [[0], [HALF]])))
    assert same_both_ways(line, 100) == 100


TURNS = [
    np.diag(signs)[list(order)]
    for signs in product((1, -1), repeat=3)
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (1, 0, 2), (0, 2, 1), (2, 1, 0))
]


@settings(max_examples=8, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(0, 7), st.integers(0, 47)), min_size=2, max_size=6, unique_by=lambda x: x[0]
    )
)
def test_turned_halves_of_a_cube(parts):
    places = [[HALF * (octant >> bit & 1) for bit in (2, 1, 0)] for octant, _ in parts]
    shape = ifs.shape(from_maps(shrunk(HALF, places, [TURNS[turn] for _, turn in parts])))
    with suppress(NotOnLattice):  # its box has no simple corners
        assert same_both_ways(shape, 8) > 0


def test_a_system_with_several_cells():
    """A corner of the cube, and a face, that hold each other: rules of the substitution say the same."""
    corner = ["corner", "face", False, False, "face", False, False, False]
    face = ["face", "face", "corner", False, "face", "face", False, "corner"]
    automaton = ifs.shape("menger-sponge").automaton
    assert automaton is not None
    states = {}
    for name, rule in (("corner", corner), ("face", face)):
        kept = [(octant, target) for octant, target in enumerate(rule) if target]
        operators = []
        for octant, _ in kept:
            place = np.array([octant >> 2 & 1, octant >> 1 & 1, octant & 1]) / 2
            affine_part = np.column_stack([np.zeros(3), np.eye(3)]) / 2 + place[:, None]
            operators.append(np.vstack([1 - affine_part.sum(axis=0), affine_part]))
        labels = tuple(str(octant) for octant, _ in kept)
        states[name] = ifs.State(name, 4, labels, tuple(t for _, t in kept), tuple(operators))
    menger = ifs.shape("menger-sponge")
    shape = ifs.Shape("two", menger.topology, ifs.System("face", states), menger.control)
    found = voxelise(shape, 64, way="lattice")
    assert found.tree == voxelise(shape, 64, way="walk").tree
    cells = to_points(found.tree)
    low, high = cells.min(axis=0), cells.max(axis=0)
    if (high - low == 63).all():
        assert found.tree == from_substitution({"corner": corner, "face": face}, "face", 6, found.tree.cube)


def test_what_keeps_to_no_lattice_is_walked():
    for name in ("koch-curve", "sierpinski-tetrahedron"):
        with pytest.raises(NotOnLattice):
            voxelise(ifs.shape(name), 64, way="lattice")
        assert voxelise(ifs.shape(name), 64).way == "walk"


def test_too_many_states_are_refused(monkeypatch):
    monkeypatch.setattr(lattice, "MOST_STATES", 50)
    with pytest.raises(NotOnLattice, match="are different"):
        voxelise(ifs.shape("menger-sponge"), 64, way="lattice")
