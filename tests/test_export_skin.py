"""The skin of trees: closed, manifold, of the right volume, area and genus, equal to the dense surface."""

import itertools

import numpy as np
import pytest
from dense.contacts import has_contacts as dense_has_contacts
from dense.contacts import join_contacts as dense_join
from dense.surface import surface
from dense.voxels import EmptySolid, Solid, Voxels
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from export.check import check
from export.meshing.joining import has_contacts, join_contacts
from export.meshing.skin import skin
from ifs.mesh import Mesh
from trees import Cube, Tree, TreeError, empty, from_array, from_points, full, to_array, unit_cube
from trees.bricks import Flat
from trees.errors import TooManyPieces
from trees.runs import tree_of_runs
from trees.topology import betti_numbers, surface_area

FLAVOURS = list(itertools.product(("exact", "smooth"), ("join", "separate")))
CUBE = Cube((1.0, -2.0, 3.0), 4.0)
sides = st.sampled_from([1, 2, 4, 8])
seeds = st.integers(0, 2**32 - 1)


@st.composite
def arrays(draw) -> np.ndarray:
    """Cells of a cube: any at all, or thin or thick random ones, which have all kinds of contacts."""
    side = draw(sides)
    if side < 4:
        return draw(hnp.arrays(bool, (side,) * 3).filter(np.any))
    share = draw(st.sampled_from([0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98]))
    array = np.random.default_rng(draw(seeds)).random((side,) * 3) < share
    array[tuple(draw(st.integers(0, side - 1)) for _ in range(3))] = True
    return array


def voxels_of(tree: Tree) -> Voxels:
    return Voxels(to_array(tree), np.array(tree.origin), tree.cell_size)


def unchecked(voxels: Voxels, field: np.ndarray) -> Solid:
    """A solid whose field has been left as it was when cells were added."""
    solid = object.__new__(Solid)
    object.__setattr__(solid, "voxels", voxels)
    object.__setattr__(solid, "field", field)
    return solid


def random_field(filled: np.ndarray, seed: int) -> np.ndarray:
    """Values of the right sign, some of them close to zero."""
    rng = np.random.default_rng(seed)
    size = rng.random(filled.shape) * rng.choice([1.0, 1e-3], filled.shape)
    return np.where(filled, -size, size + 1e-6).astype(np.float32)


def looked_up(field: np.ndarray, cube: Cube):
    """The field as a function of points, infinite out of the cube."""

    def function(points: np.ndarray) -> np.ndarray:
        cells = np.floor((points - cube.origin) / cube.size * len(field)).astype(int)
        inside = ((cells >= 0) & (cells < len(field))).all(axis=1)
        values = np.full(len(points), np.inf)
        values[inside] = field[tuple(cells[inside].T)]
        return values

    return function


def sorted_mesh(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Vertices in rising order, triangles from their lowest corner on, in rising order."""
    rounded = np.round(mesh.vertices, 7) + 0.0
    order = np.lexsort(rounded.T)
    assert len(np.unique(rounded, axis=0)) == len(rounded)
    names = np.empty(len(order), dtype=np.int64)
    names[order] = np.arange(len(order))
    faces = names[mesh.faces]
    turned = (faces.argmin(axis=1)[:, None] + np.arange(3)) % 3
    faces = np.take_along_axis(faces, turned, 1)
    return mesh.vertices[order], faces[np.lexsort(faces.T)]


def assert_same(one: Mesh, other: Mesh) -> None:
    (points, faces), (wanted, triangles) = sorted_mesh(one), sorted_mesh(other)
    np.testing.assert_allclose(points, wanted, atol=1e-9)
    np.testing.assert_array_equal(faces, triangles)


def assert_manifold(mesh: Mesh) -> None:
    """Each directed edge once and its reverse once; around each vertex one ring of triangles."""
    after, degree = {}, np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices))
    for a, b, c in mesh.faces.tolist():
        for start, end, far in ((a, b, c), (b, c, a), (c, a, b)):
            assert (start, end) not in after
            after[start, end] = far
    assert all((end, start) in after for start, end in after)
    first = dict(after.keys())
    assert set(first) == set(range(len(mesh.vertices)))
    for vertex, begin in first.items():
        steps, here = 1, after[vertex, begin]
        while here != begin:
            here, steps = after[vertex, here], steps + 1
        assert steps == degree[vertex]


def volume(mesh: Mesh) -> float:
    a, b, c = np.moveaxis((mesh.vertices - mesh.vertices[0])[mesh.faces], 1, 0)
    return float((a * np.cross(b, c)).sum() / 6)


def area(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def menger(level: int) -> Tree:
    """Black where no digit of base 3 is 1 in two coordinates at once; white beyond 3^level cells."""
    size = 3**level
    places = np.arange(size)
    filled = np.ones((size, size, size), dtype=bool)
    for digit in range(level):
        middle = (places // 3**digit % 3 == 1).astype(int)
        filled &= (middle[:, None, None] + middle[None, :, None] + middle[None, None, :]) < 2
    side = 1 << (size - 1).bit_length()
    return from_array(np.pad(filled, (0, side - size)), CUBE)


@pytest.mark.parametrize(("style", "contacts"), FLAVOURS)
@settings(max_examples=50, deadline=None)
@given(array=arrays(), seed=seeds, with_field=st.booleans())
def test_any_cells_have_the_skin_of_their_dense_array(style, contacts, array, seed, with_field) -> None:
    tree = from_array(array, CUBE)
    values = random_field(array, seed)
    field = looked_up(values, CUBE) if with_field else None
    mesh = skin(tree, style, contacts, field)
    assert mesh.faces.dtype == np.int32
    voxels = voxels_of(join_contacts(tree) if contacts == "join" else tree)
    solid = unchecked(voxels, values) if with_field else voxels
    assert_same(mesh, surface(solid, style, "separate"))
    assert_manifold(mesh)


@settings(max_examples=30, deadline=None)
@given(array=arrays())
def test_exact_volume_area_and_genus(array) -> None:
    tree = from_array(array, CUBE)
    for contacts, black in (("separate", tree), ("join", join_contacts(tree))):
        mesh = skin(tree, "exact", contacts, gap=0)
        assert volume(mesh) == pytest.approx(black.measure, rel=1e-9)
        assert area(mesh) == pytest.approx(surface_area(black), rel=1e-9)
    parts, tunnels, voids = betti_numbers(black)
    assert len(mesh.vertices) - len(mesh.faces) // 2 == 2 * (parts + voids - tunnels)


@pytest.mark.parametrize(("level", "genus"), [(1, 5), (2, 81), (3, 1409)])
@pytest.mark.parametrize("style", ["exact", "smooth"])
def test_menger_levels_have_their_genus_and_volume(level, genus, style) -> None:
    tree = menger(level)
    assert not has_contacts(tree)
    assert betti_numbers(tree)[1] == genus
    mesh = skin(tree, style)
    report = check(mesh)
    assert report.ok
    assert report.genus == (genus,)
    squares = 2 * 20**level + 4 * 8**level
    exact = skin(tree)
    assert len(exact.faces) == 2 * squares
    if style == "exact":
        assert volume(mesh) == pytest.approx(tree.measure, rel=1e-12)
        assert area(mesh) == pytest.approx(squares * tree.cell_size**2, rel=1e-12)
    else:
        moved = np.abs(mesh.vertices[: len(exact.vertices)] - exact.vertices)
        assert 0 < moved.max() <= 0.5 * tree.cell_size


@settings(max_examples=100, deadline=None)
@given(array=arrays())
def test_joining_adds_what_it_must_and_leaves_no_contact(array) -> None:
    tree = from_array(array)
    joined = join_contacts(tree)
    assert (to_array(joined) >= array).all()
    assert not dense_has_contacts(voxels_of(joined))
    assert not has_contacts(joined)
    dense = Voxels(array, np.zeros(3), 1.0)
    assert has_contacts(tree) == dense_has_contacts(dense) == (joined.count > tree.count)
    assert voxels_of(joined).components(6) == voxels_of(joined).components(26) <= dense.components(26)
    assert (joined is tree) == (not has_contacts(tree))


def test_joining_adds_about_as_many_cells_in_any_order() -> None:
    rng = np.random.default_rng(5)
    for share in (0.1, 0.3, 0.5, 0.8):
        array = rng.random((32, 32, 32)) < share
        dense = dense_join(Voxels(array, np.zeros(3), 1.0)).count
        assert join_contacts(from_array(array)).count == pytest.approx(dense, rel=0.02)


def test_joining_far_from_the_origin_of_a_large_grid() -> None:
    high = 2**20 - 2
    for x, y, z in ((0, 0, 0), (high, high, high), (3, high, 2**19 - 1)):
        for other in ((1, 1, 0), (1, 1, 1), (0, 1, 1)):
            cells = [[x, y, z], [x + other[0], y + other[1], z + other[2]]]
            joined = join_contacts(from_points(cells, bits=20))
            assert joined.count == 2 + sum(other) - 1


@pytest.mark.parametrize("bits", range(6))
def test_a_full_cube_has_six_sides(bits) -> None:
    mesh = skin(full(CUBE, bits))
    side = 2**bits
    assert len(mesh.faces) == 12 * side**2
    assert len(mesh.vertices) == 6 * side**2 + 2
    assert_manifold(mesh)
    assert volume(mesh) == pytest.approx(64.0, rel=1e-12)
    np.testing.assert_array_equal(mesh.vertices.min(axis=0), CUBE.origin)
    np.testing.assert_array_equal(mesh.vertices.max(axis=0), np.array(CUBE.origin) + 4)


@pytest.mark.parametrize("bits", [1, 2, 3, 8, 16, 21])
def test_single_cells_anywhere_in_large_grids(bits) -> None:
    cube = Cube((0.0, 0.0, 0.0), float(2**bits))
    last = 2**bits - 1
    for cell in itertools.product((0, last // 2, last), repeat=3):
        mesh = skin(from_points([cell], bits, cube))
        assert mesh.faces.shape == (12, 3)
        corners = set(map(tuple, mesh.vertices.tolist()))
        assert corners == set(itertools.product(*((float(c), float(c + 1)) for c in cell)))


def test_far_parts_of_a_large_grid_meet_where_large_nodes_do() -> None:
    """Two cubes of 2^5 cells a side with a face in common, across the middle of a grid of 2^20 a side."""
    cube = Cube((0.0, 0.0, 0.0), float(2**20))
    half = 2**19
    low = sum((half - 32) >> bit & 1 and 1 << 3 * bit + 2 for bit in range(20))
    high = sum(half >> bit & 1 and 1 << 3 * bit + 2 for bit in range(20))
    size = 32**3 - 1
    runs = np.array([low, high], np.uint64), np.array([low + size, high + size], np.uint64)
    mesh = skin(tree_of_runs(runs, cube, 20))
    assert len(mesh.faces) == 2 * 10 * 32**2
    assert_manifold(mesh)
    assert volume(mesh) == 2 * 32.0**3


def test_a_field_places_the_surface_of_a_ball() -> None:
    bits, radius = 5, 1.3
    cube = Cube((-2.0, -2.0, -2.0), 4.0)
    centres = (np.arange(2**bits) + 0.5) * 4 / 2**bits - 2
    grid = np.stack(np.meshgrid(centres, centres, centres, indexing="ij"), axis=-1)
    tree = from_array(np.linalg.norm(grid, axis=-1) <= radius, cube)

    def ball(points: np.ndarray) -> np.ndarray:
        return np.linalg.norm(points, axis=1) - radius

    mesh = skin(tree, "smooth", field=ball)
    assert np.abs(ball(mesh.vertices)).max() < 0.1 * tree.cell_size
    assert volume(mesh) == pytest.approx(4 / 3 * np.pi * radius**3, rel=0.02)
    assert_manifold(mesh)


def test_the_gap_parts_sheets() -> None:
    tree = from_points([[0, 0, 0], [1, 1, 0]], bits=2)
    for gap in (0.0, 0.05, 0.25):
        mesh = skin(tree, "exact", "separate", gap=gap)
        assert_manifold(mesh)
        places = len(np.unique(np.round(mesh.vertices, 9), axis=0))
        assert (places == len(mesh.vertices)) == (gap > 0)


def test_same_tree_same_bytes_however_it_was_built() -> None:
    array = np.random.default_rng(1).random((16, 16, 16)) < 0.4
    one, other = from_array(array), from_points(np.argwhere(array)[::-1], bits=4)
    for style, contacts in FLAVOURS:
        a, b = skin(one, style, contacts), skin(other, style, contacts)
        assert a.vertices.tobytes() == b.vertices.tobytes()
        assert a.faces.tobytes() == b.faces.tobytes()


def shell(side: int) -> np.ndarray:
    """A sheet about two cells thick that goes through the whole cube and out of it."""
    x, y, z = np.indices((side,) * 3) * (2 * np.pi / 30)
    wave = np.sin(x) * np.cos(y) + np.sin(y) * np.cos(z) + np.sin(z) * np.cos(x)
    return np.abs(wave) < 0.3


@pytest.mark.parametrize(("style", "contacts"), FLAVOURS)
def test_a_sheet_through_many_blocks_has_the_skin_of_its_dense_array(style, contacts) -> None:
    array = shell(64)
    array[40:56, 20:48, 8:40] ^= True
    tree = from_array(array, CUBE)
    black = join_contacts(tree) if contacts == "join" else tree
    assert_same(skin(tree, style, contacts), surface(voxels_of(black), style, "separate"))


WAYS = [way for way in itertools.product((-1, 0, 1), repeat=3) if way > (0, 0, 0)]
CONTACTS = [way for way in WAYS if np.abs(way).sum() > 1]


@pytest.mark.parametrize("way", CONTACTS)
@pytest.mark.parametrize("style", ["exact", "smooth"])
def test_cells_that_touch_anywhere_in_a_block(way, style) -> None:
    """Pairs of cells, the second one this way on, at every place of a block; then those places are holes."""
    places = np.array(list(itertools.product(range(1, 29, 7), repeat=3)))
    array = np.zeros((32, 32, 32), dtype=bool)
    array[tuple(places.T)] = array[tuple((places + way).T)] = True
    for black in (array, ~array):
        tree = from_array(black, CUBE)
        assert_same(skin(tree, style, "separate"), surface(voxels_of(tree), style, "separate"))


@pytest.mark.parametrize("way", CONTACTS)
@pytest.mark.parametrize("style", ["exact", "smooth"])
def test_cells_that_touch_far_from_the_origin_of_a_large_grid(way, style) -> None:
    far = 2**21 - 4
    near, moved = (
        skin(from_points([cell, cell + way], bits, Cube((0.0, 0.0, 0.0), 2.0**bits)), style, "separate")
        for cell, bits in ((np.array([1, 1, 1]), 2), (np.array([far + 1, far + 1, far + 1]), 21))
    )
    assert_same(Mesh(moved.vertices - far, moved.faces), near)


def test_too_many_triangles_around_contacts(monkeypatch) -> None:
    tree = from_points([[0, 0, 0], [1, 1, 0]], bits=2)
    count = len(skin(tree, contacts="separate").faces)
    monkeypatch.setattr("export.meshing.parted.MAX_TRIANGLES", count - 1)
    with pytest.raises(TooManyPieces) as caught:
        skin(tree, contacts="separate")
    assert (caught.value.count, caught.value.limit) == (count, count - 1)


@pytest.mark.parametrize("bits", [4, 5, 6])
def test_both_forms_of_a_set_have_the_same_skin(bits) -> None:
    flat = from_array(shell(2**bits), CUBE)
    assert isinstance(flat.form, Flat)
    bricks = Tree(flat.cube, flat.bits, flat.as_bricks)
    for style, contacts in FLAVOURS:
        one, other = skin(flat, style, contacts), skin(bricks, style, contacts)
        assert one.vertices.tobytes() == other.vertices.tobytes()
        assert one.faces.tobytes() == other.faces.tobytes()
    assert has_contacts(flat) == has_contacts(bricks)


def test_refusals() -> None:
    one = full(unit_cube(3), bits=0)
    with pytest.raises(EmptySolid, match="no cell"):
        skin(empty(unit_cube(3), bits=4))
    with pytest.raises(TreeError, match="dimension 2"):
        skin(full(unit_cube(2), bits=3))
    with pytest.raises(ValueError, match="'round'"):
        skin(one, "round")
    with pytest.raises(ValueError, match="gap"):
        skin(one, gap=0.3)
    for wrong in (np.nan, -np.inf):
        with pytest.raises(ValueError, match="give a distance"):
            skin(one, "smooth", field=lambda points, wrong=wrong: np.full(len(points), wrong))
    with pytest.raises(ValueError, match="one number each"):
        skin(one, "smooth", field=lambda points: points)
