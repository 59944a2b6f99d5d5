"""Skins over blocks of several sizes, and merged ones: one solid, closed, manifold, without crossings."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import maximum_filter
from scipy.spatial.transform import Rotation

from export.check import check
from export.checks.crossings import crossings
from export.checks.triangle_tree import triangle_tree
from export.meshing import patched, seams
from export.meshing.bending_kernels import means
from export.meshing.grading import Grading, Region, boxes_of, graded, levels_at
from export.meshing.joining import has_contacts, join_contacts
from export.meshing.patches import graded_patches
from export.meshing.rings import rings_of
from export.meshing.skin import skin
from ifs.mesh import Mesh
from trees import Cube, Tree, from_array, full, to_array, unit_cube
from trees.topology import surface_area

CUBE = Cube((1.0, -2.0, 3.0), 4.0)
SIDE = 16
STYLES = ("exact", "smooth", "field")


@st.composite
def solids(draw) -> np.ndarray:
    """Random cells, with random boxes filled or emptied."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    array = rng.random((SIDE,) * 3) < draw(st.sampled_from([0.02, 0.1, 0.3, 0.6, 0.95]))
    for _ in range(draw(st.integers(0, 3))):
        low = rng.integers(0, SIDE - 1, 3)
        high = low + rng.integers(1, SIDE, 3)
        array[tuple(slice(a, b) for a, b in zip(low, high, strict=True))] = rng.random() < 0.6
    array[tuple(rng.integers(0, SIDE, 3))] = True
    return array


@st.composite
def gradings(draw, most: int = 3) -> tuple[int, list]:
    """What `grading_of` takes: regions are made in the test itself."""
    levels = draw(st.integers(0, most))
    regions = []
    for _ in range(draw(st.integers(0, 3))):
        low = [draw(st.floats(o - 1, o + 4)) for o in CUBE.origin]
        sides = [draw(st.floats(0.01, 3)) for _ in range(3)]
        high = tuple(a + b for a, b in zip(low, sides, strict=True))
        regions.append((tuple(low), high, 2 ** draw(st.integers(0, levels))))
    return levels, regions


def grading_of(wanted: tuple[int, list]) -> Grading:
    levels, regions = wanted
    return Grading(2**levels, tuple(Region(*region) for region in regions))


def field_of(array: np.ndarray, seed: int = 0):
    """Random distances of the right sign at the cells' centres."""
    values = np.random.default_rng(seed).random(array.shape) * np.where(array, -1, 1)

    def function(points: np.ndarray) -> np.ndarray:
        cells = np.floor((points - CUBE.origin) / CUBE.size * len(array)).astype(int)
        inside = ((cells >= 0) & (cells < len(array))).all(axis=1)
        found = np.full(len(points), np.inf)
        found[inside] = values[tuple(cells[inside].T)]
        return found

    return function


def graded_skin(array: np.ndarray, style: str, grading: Grading) -> Mesh:
    field = field_of(array) if style == "field" else None
    style = "exact" if style == "exact" else "smooth"
    return skin(from_array(array, CUBE), style, field=field, grading=grading)


def require_sound(mesh: Mesh) -> None:
    """No fault of edges and fans, no two vertices at one place, no two triangles that meet."""
    report = check(mesh, quick=True)
    assert report.ok, report.faults
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    found = crossings(triangle_tree(mesh.vertices, mesh.faces))
    assert found.complete
    assert found.count == 0


def block_levels(grading: Grading) -> np.ndarray:
    """By the definition, cell by cell: level j near what is finer or in regions, by whole blocks."""
    levels, pitch = min(grading.levels, 4), CUBE.size / SIDE
    result = np.full((SIDE,) * 3, levels)
    fine = np.zeros((SIDE,) * 3, dtype=bool)
    for level in range(levels):
        if level:
            fine = maximum_filter(fine, 4 * 2**level + 1, mode="constant")
        for region in grading.regions:
            if region.block == 2**level:
                low = [int(np.floor((a - o) / pitch)) for a, o in zip(region.low, CUBE.origin, strict=True)]
                high = [int(np.ceil((a - o) / pitch)) for a, o in zip(region.high, CUBE.origin, strict=True)]
                if all(b > 0 and a < SIDE for a, b in zip(low, high, strict=True)):
                    fine[tuple(slice(max(a, 0), b) for a, b in zip(low, high, strict=True))] = True
        fine = blocks_of(fine, 2 ** (level + 1))
        result[fine & (result == levels)] = level
    return result


def blocks_of(array: np.ndarray, edge: int) -> np.ndarray:
    """Black all over the blocks that hold a black cell."""
    count = len(array) // edge
    some = array.reshape(count, edge, count, edge, count, edge).any(axis=(1, 3, 5))
    return some.repeat(edge, 0).repeat(edge, 1).repeat(edge, 2)


@settings(max_examples=30, deadline=None)
@given(wanted=gradings(4))
def test_blocks_that_touch_differ_at_most_twofold(wanted) -> None:
    tree, grading = from_array(np.ones((SIDE,) * 3, dtype=bool), CUBE), grading_of(wanted)
    cells = np.indices((SIDE,) * 3).reshape(3, -1).T
    levels = levels_at(boxes_of(tree, grading), cells).reshape((SIDE,) * 3)
    np.testing.assert_array_equal(levels, block_levels(grading))
    assert (maximum_filter(levels, 3) - levels).max() <= 1
    for level in range(5):
        whole = blocks_of(levels == level, 2**level)
        np.testing.assert_array_equal(whole, levels == level)


@settings(max_examples=40, deadline=None)
@given(array=solids(), wanted=gradings())
def test_blocks_are_black_where_one_of_their_cells_is(array, wanted) -> None:
    grading = grading_of(wanted)
    levels = block_levels(grading)
    black = np.select([levels == j for j in range(4)], [blocks_of(array, 2**j) for j in range(4)])
    tree = from_array(array, CUBE)
    found = graded(tree, grading)
    np.testing.assert_array_equal(to_array(found), black)
    assert not tree - found
    assert graded(found, grading) == found


@pytest.mark.parametrize("style", STYLES)
@settings(max_examples=20, deadline=None)
@given(array=solids(), wanted=gradings())
def test_graded_skins_have_no_fault(style, array, wanted) -> None:
    require_sound(graded_skin(array, style, grading_of(wanted)))


@settings(max_examples=12, deadline=None)
@given(array=solids(), wanted=gradings())
def test_exact_graded_skins_bound_the_blocks(array, wanted) -> None:
    grading = grading_of(wanted)
    tree = graded(from_array(array, CUBE), grading)
    while has_contacts(tree):
        tree = graded(join_contacts(tree), grading)
    report = check(graded_skin(array, "exact", grading), quick=True)
    assert report.volume == pytest.approx(tree.measure, rel=1e-12)
    assert report.area == pytest.approx(surface_area(tree), rel=1e-12)
    assert Counter(report.genus) == Counter(check(skin(tree), quick=True).genus)


@pytest.mark.parametrize("style", STYLES)
@settings(max_examples=12, deadline=None)
@given(array=solids())
def test_blocks_of_one_cell_give_the_plain_skin(style, array) -> None:
    found = graded_skin(array, style, Grading(1))
    field = field_of(array) if style == "field" else None
    plain = skin(from_array(array, CUBE), "exact" if style == "exact" else "smooth", field=field)
    assert len(found.faces) == len(plain.faces)
    order, wanted = np.lexsort(np.round(found.vertices, 9).T), np.lexsort(np.round(plain.vertices, 9).T)
    np.testing.assert_allclose(found.vertices[order], plain.vertices[wanted], atol=1e-9)


@settings(max_examples=12, deadline=None)
@given(array=solids())
def test_merged_skins_bound_the_same_solid(array) -> None:
    tree = from_array(array, CUBE)
    found, plain = skin(tree, merge=True), check(skin(tree), quick=True)
    require_sound(found)
    report = check(found, quick=True)
    assert report.triangles <= plain.triangles
    assert report.volume == pytest.approx(plain.volume, rel=1e-12)
    assert report.area == pytest.approx(plain.area, rel=1e-12)
    assert Counter(report.genus) == Counter(plain.genus)


def test_merged_boxes() -> None:
    assert skin(full(unit_cube(3), bits=4), merge=True).faces.shape == (12, 3)
    ell = np.zeros((4, 4, 4), dtype=bool)
    ell[:3, :, :3] = True
    ell[1:3, :, 1:3] = False
    assert (
        len(skin(from_array(ell), merge=True).faces) == 2 * (12 + 2) - 4
    )  # 12 corners, and a cut at either end


def ball(side: int) -> Tree:
    squares = ((np.indices((side,) * 3) + 0.5 - side / 2) ** 2).sum(axis=0)
    return from_array(squares <= (0.42 * side) ** 2, CUBE)


def to_sphere(points: np.ndarray) -> np.ndarray:
    return np.linalg.norm(points - (np.array(CUBE.origin) + 2.0), axis=1) - 0.42 * CUBE.size


def test_smooth_errors_follow_the_blocks() -> None:
    """Vertices lie near the sphere to the order of their blocks: fine in the region, coarse out of it."""
    tree, pitch = ball(32), CUBE.size / 32
    region = Region((1.0, -2.0, 3.0), (3.0, 2.0, 7.0))
    grading = Grading(4, (region,))
    mesh = skin(tree, "smooth", field=to_sphere, grading=grading)
    off = np.abs(to_sphere(mesh.vertices)) / pitch
    fine = mesh.vertices[:, 0] < 3.0 - 2 * pitch
    assert off[fine].max() < 0.3
    assert 1 < off.max() < 6
    assert len(mesh.faces) < 0.7 * len(skin(tree, "smooth").faces)


def to_torus(points: np.ndarray) -> np.ndarray:
    """In cells: a tilted torus."""
    x, y, z = (points - [32.3, 31.6, 32.1]).T
    y, z = 0.88 * y - 0.475 * z, 0.475 * y + 0.88 * z
    return np.hypot(np.hypot(x, y) - 19, z) - 8.2


def to_plate(points: np.ndarray) -> np.ndarray:
    """In cells: what is near a tilted disc."""
    off = points - [31.7, 32.2, 32.4]
    height = off @ (np.array([0.31, 0.25, 1.0]) / np.linalg.norm([0.31, 0.25, 1.0]))
    aside = np.sqrt(np.maximum((off**2).sum(axis=1) - height**2, 0))
    return np.hypot(np.maximum(aside - 16, 0), height) - 8.3


def seam_vertices(tree: Tree, grading: Grading) -> np.ndarray:
    """Which vertices are beside blocks of unequal size: those of squares come first in a skin."""
    while has_contacts(tree):
        tree = graded(join_contacts(tree), grading)
    patches, _ = graded_patches(tree, grading)
    assert patches.inner is not None
    assert patches.outer is not None
    rings = rings_of(patches, tree.bits)
    count = len(rings.corners)
    least, largest = np.zeros(count, dtype=np.int64), np.zeros(count, dtype=np.int64)
    crossings, places = np.zeros((len(patches.axis), 3)), np.zeros((count, 3))
    means(rings.starts, rings.ring, crossings, patches.inner.size, patches.outer.size, places, least, largest)
    return least < largest


@pytest.mark.parametrize("field", [to_torus, to_plate])
@pytest.mark.parametrize("block", [2, 4])
@pytest.mark.parametrize("low", [(0.0, 0.0, 0.0), (20.0, 22.0, 24.0)])
def test_seams_lie_on_the_surface(field, block, low) -> None:
    """As near as vertices elsewhere do, with triangles that face the right way."""
    cells = np.indices((64,) * 3).reshape(3, -1).T + 0.5
    tree = from_array((field(cells) <= 0).reshape((64,) * 3), Cube((0.0,) * 3, 64.0))
    grading = Grading(block, (Region(low, (31.0 if low[0] == 0 else 64.0, 64.0, 64.0)),))
    tree = graded(tree, grading, field)
    mesh, seam = skin(tree, "smooth", field=field, grading=grading), seam_vertices(tree, grading)
    require_sound(mesh)
    off = np.abs(field(mesh.vertices))[: len(seam)]
    assert seam.sum() > 100
    assert off[seam].max() < 0.2 * block
    assert off[seam].mean() < 0.02 * block
    beside = np.append(seam, np.zeros(len(mesh.vertices) - len(seam), dtype=bool))[mesh.faces].any(axis=1)
    corners = mesh.vertices[mesh.faces[beside]]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle, step = corners.mean(axis=1), 1e-4 * np.eye(3)
    normals = np.stack([field(middle + one) - field(middle - one) for one in step], axis=1) / 2e-4
    cosines = (across * normals).sum(axis=1) / np.linalg.norm(across, axis=1)
    assert cosines.min() > 0.5
    assert cosines.mean() > 0.99


def to_turned_cube(points: np.ndarray) -> np.ndarray:
    """In cells: a tilted cube of side 34.6."""
    off = points - [31.7, 32.2, 32.4]
    over = np.abs(off @ Rotation.from_rotvec([0.3, 0.5, 0.2]).as_matrix()) - 17.3
    return np.linalg.norm(np.maximum(over, 0), axis=1) + np.minimum(over.max(axis=1), 0)


def test_edges_and_corners_are_kept_across_seams() -> None:
    cells = np.indices((64,) * 3).reshape(3, -1).T + 0.5
    tree = from_array((to_turned_cube(cells) <= 0).reshape((64,) * 3), Cube((0.0,) * 3, 64.0))
    grading = Grading(4, (Region((0.0, 0.0, 0.0), (31.0, 64.0, 64.0)),))
    tree = graded(tree, grading, to_turned_cube)
    mesh = skin(tree, "smooth", field=to_turned_cube, grading=grading, features=30.0)
    require_sound(mesh)
    seam = seam_vertices(tree, grading)
    off = np.abs(to_turned_cube(mesh.vertices[: len(seam)]))[seam]
    assert off.max() < 0.5
    assert off.mean() < 0.01
    assert check(mesh, quick=True).volume == pytest.approx(34.6**3, rel=2e-3)


def test_vertices_whose_triangles_would_cross_go_back(monkeypatch) -> None:
    """With first places of seam vertices anywhere within half their largest block."""
    tree, rng = ball(32), np.random.default_rng(7)
    grading = Grading(4, (Region((1.0, -2.0, 3.0), (3.0, 2.0, 7.0)),))
    tree = graded(tree, grading, to_sphere)
    safe, used = patched._means, []

    def wild(*given):
        steps = safe(*given)
        corners, (last, least), reach = given[0].corners, steps[-1], steps[0][1][:, None]
        first = np.where(reach > least[:, None], corners + reach * rng.uniform(-1, 1, last.shape), last)
        used.append((first, last))
        return [(first, reach[:, 0]), (last, least)]

    monkeypatch.setattr(patched, "_means", wild)
    mesh = skin(tree, "smooth", field=to_sphere, grading=grading)
    require_sound(mesh)
    first, last = used[0]
    cells = (mesh.vertices[: len(first)] - CUBE.origin) / tree.cell_size
    at_first, at_last = np.isclose(cells, first).all(axis=1), np.isclose(cells, last).all(axis=1)
    assert (at_first | at_last).all()
    assert (at_first & ~at_last).sum() > 20
    monkeypatch.setattr(seams, "_wrong", lambda bent, watched, patches, ways: watched & False)
    free = skin(tree, "smooth", field=to_sphere, grading=grading)
    assert crossings(triangle_tree(free.vertices, free.faces)).count > 20


def test_grown_blocks_hold_the_cover_and_no_more_than_a_block_further() -> None:
    tree = ball(16)
    coarse = graded(tree, Grading(4))
    cells = np.argwhere(to_array(coarse - tree))
    black = np.argwhere(to_array(tree))
    nearest = np.abs(cells[:, None] - black[None]).max(axis=2).min(axis=1)
    assert nearest.max() == 3


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Region((0, 0, 0), (1, 0, 1)), "axis 1"),
        (lambda: Region((0, 0, np.nan), (1, 1, 1)), "low corner"),
        (lambda: Region((0, 0, 0), (1, 1, 1), 3), "not 3"),
        (lambda: Grading(0), "not 0"),
        (lambda: Grading(2, (Region((0, 0, 0), (1, 1, 1), 4),)), r"regions\[0\]"),
        (lambda: skin(ball(8), "exact", "separate", merge=True), "joined"),
        (lambda: skin(ball(8), "smooth", merge=True), "exact style"),
    ],
)
def test_wrong_wishes_are_named(make, message) -> None:
    with pytest.raises(ValueError, match=message):
        make()
