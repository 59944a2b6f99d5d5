"""Sponges, tetrahedra, dust and towers of boxes: the numbers of reports against closed forms and counts."""

from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

import ifs
from export import check, make_part, skin, voxelise
from export.meshing.joining import join_contacts
from ifs.maps.maps import affine
from ifs.maps.plain import from_maps
from trees import to_array
from trees.topology import euler_characteristic

HALF = Fraction(1, 2)
TETRAHEDRA = {
    "at the axes": [(0, 0, 0), (HALF, 0, 0), (0, HALF, 0), (0, 0, HALF)],
    "at every other corner": [(0, 0, 0), (0, HALF, HALF), (HALF, 0, HALF), (HALF, HALF, 0)],
}


def boxes(sides, places, control=None) -> ifs.Shape:
    """The maps of the unit cube to boxes of these sides at these places; its corner frame may be another."""
    maps = [
        affine([[side[i] * (i == j) for j in range(3)] for i in range(3)], list(place))
        for side, place in zip(sides, places, strict=True)
    ]
    return ifs.shape(from_maps(maps, control=control))


def cubes(ratio: Fraction, places) -> ifs.Shape:
    return boxes([(ratio,) * 3] * len(places), places)


def euler_of_the_sponge(level: int) -> int:
    """Of 20 copies that share 24 faces, each a carpet with (8^n - 1) / 7 holes.

    At each of its 8 corners, three edges and a point lie in several of these: added as often as taken away.
    """
    if level == 0:
        return 1
    carpet = 1 - (8 ** (level - 1) - 1) // 7
    return 20 * euler_of_the_sponge(level - 1) - 24 * carpet


@pytest.mark.parametrize("level", [1, 2, 3, pytest.param(4, marks=pytest.mark.slow)])
@pytest.mark.parametrize("style", ["exact", "smooth"])
def test_the_sponge(level, style):
    part = make_part(ifs.shape("menger-sponge"), size=1.0, depth=level, style=style)
    report = part.report
    assert report.ok
    assert report.components == 1
    assert report.euler == 2 * euler_of_the_sponge(level)
    assert report.genus == (1 - euler_of_the_sponge(level),) == ({1: 5, 2: 81, 3: 1409, 4: 26433}[level],)
    if style == "exact":
        squares = 2 * 20**level + 4 * 8**level
        assert report.triangles == 2 * squares
        assert report.area == pytest.approx(squares / 9**level, rel=1e-9)
        assert report.volume == pytest.approx((20 / 27) ** level, rel=1e-9)
        assert (report.low, report.high) == (pytest.approx((0, 0, 0)), pytest.approx((1, 1, 1)))


@pytest.mark.parametrize("level", range(1, 7))
@pytest.mark.parametrize("kind", TETRAHEDRA)
def test_tetrahedra_of_cubes(kind, level):
    """The voxels that cover Sierpinski's tetrahedron on its own grid.

    At the axes, cubes that share a face form a tree: 4^n of them and 4^n - 1 shared faces. At every other
    corner no two share a face, but edges.
    """
    shape = cubes(HALF, TETRAHEDRA[kind])
    cover = voxelise(shape, 2**level)
    cell, count = cover.pitch, 4**level
    assert cover.tree == voxelise(shape, 2**level, depth=level).tree
    apart = check(skin(cover.tree, "exact", "separate", gap=0.0), quick=True)
    whole = kind == "at the axes"
    assert cover.tree.count == count
    assert apart.ok
    assert apart.components == (1 if whole else count)
    assert apart.genus == (0,) * apart.components
    assert apart.volume == pytest.approx(count * cell**3, rel=1e-9)
    assert apart.area == pytest.approx((4 * count + 2 if whole else 6 * count) * cell**2, rel=1e-9)
    if not whole:  # four copies that share six edges; at level 1 all of these end in the middle
        assert euler_characteristic(cover.tree, "d-infinity") == 2 - count // 4
    joined = make_part(shape, resolution=2**level).report
    assert joined.ok
    assert joined.components == 1
    # tetrahedra that touch at points have 4^n - 1 independent loops; those of the last two levels are closed
    assert joined.genus == (max(count // 16, 1) - 1,)


THIRDS, FIFTHS = Fraction(1, 3), Fraction(2, 5)


@pytest.mark.parametrize(
    ("ratio", "level"), [*((THIRDS, n) for n in range(1, 5)), *((FIFTHS, n) for n in range(1, 4))]
)
def test_dust(ratio, level):
    dust = cubes(ratio, list(product([0, 1 - ratio], repeat=3)))
    report = make_part(dust, size=1.0, depth=level, resolution=ratio.denominator**level).report
    assert report.ok
    assert report.components == 8**level
    assert report.genus == (0,) * 8**level
    assert report.volume == pytest.approx(float(8 * ratio**3) ** level, rel=1e-9)
    assert report.area == pytest.approx(6 * float(8 * ratio**2) ** level, rel=1e-9)


@st.composite
def towers(draw) -> tuple[tuple[int, int, int], list[tuple[tuple[int, int, int], tuple[int, int, int]]]]:
    """The size of the whole, and the places and sides of boxes, each on the level where the last one ends."""
    size = draw(st.tuples(st.integers(2, 7), st.integers(2, 7)))
    found, height = [], 0
    for number in range(draw(st.integers(2, 6))):
        sides = [draw(st.integers(1, side - 1)) for side in size]
        room = [whole - side for whole, side in zip(size, sides, strict=True)]
        at = [0, 0] if number == 0 else room if number == 1 else [draw(st.integers(0, r)) for r in room]
        tall = draw(st.integers(1, 3))
        found.append(((*at, height), (*sides, tall)))
        height += tall
    return (*size, height), found


def filled(size, boxes_, fine: int) -> np.ndarray:
    black = np.zeros([fine * side for side in size], dtype=bool)
    for place, sides in boxes_:
        black[tuple(slice(fine * p, fine * (p + s)) for p, s in zip(place, sides, strict=True))] = True
    return black


def labels(black: np.ndarray, neighbours: int) -> int:
    found: Any = ndimage.label(black, ndimage.generate_binary_structure(3, neighbours))
    return found[1]


def counts(black: np.ndarray) -> tuple[int, int, int, int]:
    """Cells, squares, shells and Euler characteristic of the boundary; cells that share no face are apart."""
    black = np.pad(black, 1)
    squares = sum(int((black != np.roll(black, 1, axis)).sum()) for axis in range(3))
    outer = labels(black, 1)
    inner = labels(~black, 3) - 1
    euler = 0
    for axes in product((0, 1), repeat=3):  # pairs of cells that share a face, fours an edge, eights a corner
        together = black
        for axis in np.flatnonzero(axes):
            together = together & np.roll(together, 1, axis)
        euler += (-1) ** sum(axes) * int(together.sum())
    return int(black.sum()), squares, outer + inner, 2 * euler


@settings(max_examples=8, deadline=None)
@given(towers(), st.sampled_from([1, 2]), st.sampled_from([1.0, 0.3, 7.7]))
def test_towers_of_boxes(tower, fine, unit):
    size, stacked = tower
    frame = [[0, 0, 0], [unit * size[0], 0, 0], [0, unit * size[1], 0], [0, 0, unit * size[2]]]
    share = [tuple(Fraction(s, n) for s, n in zip(sides, size, strict=True)) for _, sides in stacked]
    place = [tuple(Fraction(p, n) for p, n in zip(at, size, strict=True)) for at, _ in stacked]
    part = make_part(boxes(share, place, frame), depth=1, resolution=fine * max(size))
    black = filled(size, stacked, fine)
    cells = to_array(part.tree)
    assert np.array_equal(cells[tuple(slice(n) for n in black.shape)], black)
    assert cells.sum() == black.sum()
    cell = unit / fine
    for mesh, solid in (
        (part.mesh, to_array(join_contacts(part.tree))),
        (skin(part.tree, "exact", "separate", gap=0.0), black),
    ):
        report = check(mesh, quick=True)
        volume, area, shells, euler = counts(solid)
        assert report.ok
        assert report.volume == pytest.approx(volume * cell**3, rel=1e-9)
        assert report.area == pytest.approx(area * cell**2, rel=1e-9)
        assert (report.components, report.euler) == (shells, euler)
        assert sum(2 - 2 * (genus or 0) for genus in report.genus) == euler
    assert part.report.ok
    assert part.report.volume == check(part.mesh, quick=True).volume


def tetrahedra(level: int) -> ifs.Mesh:
    shape = ifs.shape("sierpinski-tetrahedron")
    return ifs.draw(ifs.refined(ifs.initial(shape.topology, shape.system, shape.control), level))


def test_4096_tetrahedra_that_touch_at_points():
    """All 2 (4^6 - 1) points at which two of them touch are found, and nothing else."""
    mesh = tetrahedra(6)
    assert mesh.to_trimesh().is_watertight
    report = check(mesh)
    assert not report.ok
    assert report.components == 4**6
    assert report.genus == (0,) * 4**6
    assert report.volume == pytest.approx(60**3 / 6 / np.sqrt(2) / 2**6)
    assert [(fault.kind, fault.count) for fault in report.details] == [
        ("nonmanifold_vertices", 2 * (4**6 - 1))
    ]
    corners = np.bincount(mesh.triangles().ravel())  # three triangles of a tetrahedron meet at each corner
    for place in report.details[0].places:
        where = np.linalg.norm(mesh.vertices - place, axis=1).argmin()
        assert np.linalg.norm(mesh.vertices[where] - place) < 1e-6
        assert corners[where] == 6


@pytest.mark.parametrize(("thickness", "resolution"), [(0.0, 360), (1.2, 150)])
def test_4096_tetrahedra_joined_are_one_solid(thickness, resolution):
    import manifold3d

    shape = ifs.shape("sierpinski-tetrahedron")
    part = make_part(shape, size=60, depth=6, resolution=resolution, thickness=thickness)
    assert part.report.ok
    assert part.report.components == 1
    solid = manifold3d.Manifold(manifold3d.Mesh64(part.mesh.vertices, part.mesh.faces.astype(np.uint64)))
    assert solid.status() == manifold3d.Error.NoError
    assert len(solid.decompose()) == 1
    assert solid.genus() == part.report.genus[0]


@pytest.mark.parametrize(("level", "resolution"), [(1, 60), (2, 120), (3, 240)])
def test_joined_tetrahedra_keep_their_loops(level, resolution):
    """4^n solids that touch at 2 (4^n - 1) points have 4^n - 1 loops: with fine voxels none is lost."""
    part = make_part(ifs.shape("sierpinski-tetrahedron"), size=60, depth=level, resolution=resolution)
    assert part.report.ok
    assert part.report.genus == (4**level - 1,)
