"""Voxels to surface: closed, manifold, the right volume and genus, no two triangles crossing."""

import itertools

import numpy as np
import pytest
from dense.contacts import has_contacts, join_contacts
from dense.surface import find_sheets, surface
from dense.voxels import EmptySolid, Solid, Voxels
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from jaxtyping import TypeCheckError

from export.check import check
from export.files import weld
from export.meshing.contacts import CONTACT, FAN_COUNT, REPAIR
from ifs.mesh import Mesh

FLAVOURS = list(itertools.product(("exact", "smooth"), ("join", "separate")))
blocks = hnp.arrays(bool, hnp.array_shapes(min_dims=3, max_dims=3, max_side=4)).filter(np.any)
seeds = st.integers(0, 2**32 - 1)


def menger(level: int) -> Voxels:
    """Filled where no digit of base 3 is 1 in two coordinates at once."""
    size = 3**level
    places = np.arange(size)
    filled = np.ones((size, size, size), dtype=bool)
    for digit in range(level):
        ones = places // 3**digit % 3 == 1
        filled &= (ones[:, None, None].astype(int) + ones[None, :, None] + ones[None, None, :]) < 2
    return Voxels(filled, np.array([1.0, -2.0, 3.0]), 1 / size)


def unit(filled: np.ndarray) -> Voxels:
    return Voxels(np.asarray(filled, dtype=bool), np.zeros(3), 1.0)


def random_field(filled: np.ndarray, seed: int) -> np.ndarray:
    """Values of the right sign, some of them close to zero."""
    rng = np.random.default_rng(seed)
    size = rng.random(filled.shape) * rng.choice([1.0, 1e-3], filled.shape)
    return np.where(filled, -size, size + 1e-6).astype(np.float32)


def assert_manifold(mesh: Mesh) -> None:
    """Each directed edge once and its reverse once; around each vertex one ring of triangles."""
    faces = mesh.faces.tolist()
    edges = {}
    for a, b, c in faces:
        for start, end, far in ((a, b, c), (b, c, a), (c, a, b)):
            assert (start, end) not in edges
            edges[start, end] = far
    assert all((end, start) in edges for start, end in edges)
    degree, one = {}, {}
    for start, end in edges:
        degree[start] = degree.get(start, 0) + 1
        one[start] = end
    assert set(degree) == set(range(len(mesh.vertices)))
    for vertex, first in one.items():
        steps, here = 1, edges[vertex, first]
        while here != first:
            here, steps = edges[vertex, here], steps + 1
        assert steps == degree[vertex]


def crossings(mesh: Mesh) -> int:
    """Brute force: how many edges pass through a triangle they share no vertex with."""
    points, faces = mesh.vertices, mesh.faces
    ends = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    a, b, c = np.moveaxis(points[faces], 1, 0)
    normal = np.cross(b - a, c - a)
    start, end = points[ends[:, 0], None], points[ends[:, 1], None]
    from_start, from_end = ((start - a) * normal).sum(-1), ((end - a) * normal).sum(-1)
    shared = (ends[:, None, :, None] == faces[None, :, None, :]).any(axis=(2, 3))
    flat = np.maximum(np.abs(from_start), np.abs(from_end)) < 1e-9
    edge, face = np.nonzero((from_start * from_end <= 0) & ~shared & ~flat)
    low, high = from_start[edge, face], from_end[edge, face]
    share = (low / (low - high))[:, None]
    place = start[edge, 0] + share * (end[edge, 0] - start[edge, 0])
    inside = np.ones(len(edge), dtype=bool)
    for p, q in ((a, b), (b, c), (c, a)):
        turn = np.cross(q[face] - p[face], place - p[face])
        inside &= (turn * normal[face]).sum(-1) >= -1e-9
    return int(inside.sum())


def pinches(filled: np.ndarray) -> int:
    """Corners at which two empty voxels, and these alone, lie opposite each other."""
    padded = np.pad(filled, 1)
    around = np.lib.stride_tricks.sliding_window_view(padded, (2, 2, 2)).reshape(-1, 8)
    opposite = ~around[:, :4] & ~around[:, :3:-1]
    return int((opposite.any(axis=1) & (around.sum(axis=1) == 6)).sum())


def test_the_crossing_finder_finds_crossings() -> None:
    near = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    across = np.array([[0.2, 0.2, -1], [0.2, 0.2, 1], [2, 2, 0]])
    assert crossings(Mesh(np.vstack([near, across]), np.arange(6).reshape(2, 3))) > 0


@pytest.mark.parametrize(("level", "genus"), [(1, 5), (2, 81), (3, 1409)])
@pytest.mark.parametrize(("style", "contacts"), FLAVOURS)
def test_menger_levels_have_their_genus_and_volume(level, genus, style, contacts) -> None:
    voxels = menger(level)
    assert not has_contacts(voxels)
    assert (voxels.components(), voxels.holes, voxels.cavities) == (1, genus, 0)
    mesh = surface(voxels, style, contacts)
    report = check(mesh, quick=True)
    assert report.ok
    assert report.genus == (genus,)
    if style == "exact":
        assert report.volume == pytest.approx((20 / 27) ** level, rel=1e-12)
        np.testing.assert_allclose(report.low, voxels.origin, atol=1e-12)
        np.testing.assert_allclose(report.high, voxels.origin + 1, atol=1e-12)
    else:
        moved = np.abs(mesh.vertices - surface(voxels, "exact").vertices)
        assert moved.max() <= 0.5 * voxels.pitch


def test_without_contacts_both_rules_agree() -> None:
    voxels = menger(2)
    for style in ("exact", "smooth"):
        one, other = (surface(voxels, style, rule) for rule in ("join", "separate"))
        assert np.array_equal(one.vertices, other.vertices)
        assert np.array_equal(one.faces, other.faces)


@pytest.mark.parametrize(("style", "contacts"), FLAVOURS)
@settings(max_examples=20, deadline=None)
@given(filled=blocks, seed=seeds)
def test_any_voxels_give_a_manifold(style, contacts, filled, seed) -> None:
    solid = Solid(unit(filled), random_field(filled, seed))
    mesh = surface(solid, style, contacts)
    assert np.isfinite(mesh.vertices).all()
    assert_manifold(mesh)
    joined = join_contacts(unit(filled)) if contacts == "join" else unit(filled)
    characteristic = len(mesh.vertices) - len(mesh.faces) // 2
    assert characteristic == 2 * (joined.euler + pinches(joined.filled))
    assert_manifold(weld(mesh))
    assert len(weld(mesh).vertices) == len(mesh.vertices)


@settings(max_examples=30, deadline=None)
@given(filled=blocks)
def test_exact_volume_and_area(filled) -> None:
    for contacts, voxels in (("separate", unit(filled)), ("join", join_contacts(unit(filled)))):
        report = check(surface(unit(filled), "exact", contacts, gap=0), quick=True)
        assert report.volume == pytest.approx(voxels.volume, rel=1e-12)
        padded = np.pad(voxels.filled, 1)
        squares = sum(np.count_nonzero(np.diff(padded, axis=axis)) for axis in range(3))
        assert report.area == pytest.approx(squares, rel=1e-12)
        assert report.components >= voxels.components()


def corner_classes() -> list[np.ndarray]:
    """One of each kind of 2 x 2 x 2 block, up to the symmetries of the cube."""
    found = {}
    for code in range(1, 256):
        block = np.array([code >> octant & 1 for octant in range(8)], dtype=bool).reshape(2, 2, 2)
        turned = [
            np.flip(block.transpose(axes), [a for a in range(3) if flips >> a & 1]).tobytes()
            for axes in itertools.permutations(range(3))
            for flips in range(8)
        ]
        found.setdefault(min(turned), block)
    return list(found.values())


@pytest.mark.parametrize(("style", "contacts"), FLAVOURS)
def test_no_two_triangles_cross_around_any_kind_of_corner(style, contacts) -> None:
    classes = corner_classes()
    assert len(classes) == 21
    for block in classes:
        assert crossings(surface(unit(block), style, contacts)) == 0, block


@pytest.mark.parametrize("contacts", ["join", "separate"])
@settings(max_examples=25, deadline=None)
@given(filled=blocks, seed=seeds)
def test_smooth_triangles_do_not_cross(contacts, filled, seed) -> None:
    solid = Solid(unit(filled), random_field(filled, seed))
    assert crossings(surface(solid, "smooth", contacts)) == 0


@settings(max_examples=30, deadline=None)
@given(filled=blocks)
def test_joining_adds_what_it_must_and_leaves_no_contact(filled) -> None:
    joined = join_contacts(unit(filled))
    assert not has_contacts(joined)
    assert (joined.filled >= filled).all()
    assert joined.filled.shape == filled.shape
    assert has_contacts(unit(filled)) == (joined.count > unit(filled).count)
    assert joined.components(6) == joined.components(26) <= unit(filled).components(26)


def test_the_table_of_corners() -> None:
    assert FAN_COUNT[[0, 255]].tolist() == [0, 0]
    assert FAN_COUNT[0b10000001] == 2  # two voxels at opposite corners
    assert FAN_COUNT[0b01101001] == 4  # every second voxel
    assert FAN_COUNT[0b00001001] == 2  # two voxels at an edge
    assert CONTACT[0b11111001]  # two empty voxels at an edge: one fan with both sheets
    assert FAN_COUNT[0b11111001] == 1
    codes = np.arange(256)
    assert not CONTACT[codes | REPAIR].any()
    assert (REPAIR[~CONTACT] == 0).all()
    assert (REPAIR & codes == 0).all()


@pytest.mark.parametrize("size", [2, 3, 4])
def test_a_checkerboard_parts_into_its_voxels(size) -> None:
    filled = np.indices((size,) * 3).sum(axis=0) % 2 == 0
    report = check(surface(unit(filled), "exact", "separate"))
    assert report.ok
    assert report.components == filled.sum()
    assert set(report.genus) == {0}
    assert check(weld(surface(unit(filled), "exact", "separate"))).ok
    touching = check(weld(surface(unit(filled), "exact", "separate", gap=0)))
    assert touching.nonmanifold_edges > 0
    joined = check(weld(surface(unit(filled), "exact", "join")))
    assert joined.ok
    assert joined.components == 1


def test_a_tunnel_between_contact_edges_is_manifold() -> None:
    """Both sheets of a contact edge run between the same two corners, each of a single fan."""
    middle = np.eye(2, dtype=bool)[:, :, None]
    full = np.ones((2, 2, 1), dtype=bool)
    voxels = unit(np.concatenate([full, middle, full], axis=2))
    sheets = find_sheets(voxels)
    assert sheets.contact.any()
    assert not sheets.split.any()
    for style in ("exact", "smooth"):
        mesh = surface(voxels, style, "separate")
        assert_manifold(mesh)
        assert check(weld(mesh)).genus == (1,)


@pytest.mark.parametrize("style", ["exact", "smooth"])
@settings(max_examples=25, deadline=None)
@given(filled=blocks, seed=seeds)
def test_manifold3d_takes_every_mesh(style, filled, seed) -> None:
    import manifold3d

    for contacts in ("join", "separate"):
        mesh = surface(Solid(unit(filled), random_field(filled, seed)), style, contacts)
        loaded = manifold3d.Manifold(
            manifold3d.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))
        )
        assert loaded.status() == manifold3d.Error.NoError
        assert loaded.volume() == pytest.approx(check(mesh, quick=True).volume, rel=1e-4, abs=1e-4)


def test_same_voxels_same_mesh_wherever_the_array_lies_in_memory() -> None:
    filled = np.random.default_rng(1).random((5, 6, 7)) < 0.5
    one = surface(unit(filled))
    other = surface(unit(np.asfortranarray(filled)))
    assert np.array_equal(one.vertices, other.vertices)
    assert np.array_equal(one.faces, other.faces)


def test_a_solid_moved_and_scaled() -> None:
    filled = np.random.default_rng(2).random((4, 4, 4)) < 0.5
    field = random_field(filled, 3)
    near = surface(Solid(unit(filled), field))
    far = surface(Solid(Voxels(filled, np.array([1.0, 2.0, 3.0]), 0.5), field / 2))
    np.testing.assert_allclose(far.vertices, near.vertices / 2 + [1, 2, 3], atol=1e-9)


def test_refusals() -> None:
    empty = unit(np.zeros((2, 2, 2)))
    with pytest.raises(EmptySolid, match="no voxel"):
        surface(empty)
    one = unit(np.ones((1, 1, 1)))
    with pytest.raises((ValueError, TypeCheckError), match="smooth"):
        surface(one, "round")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="gap"):
        surface(one, gap=0.5)
    with pytest.raises(ValueError, match="pitch"):
        Voxels(one.filled, np.zeros(3), 0.0)
    with pytest.raises(ValueError, match="origin"):
        Voxels(one.filled, np.array([0.0, np.nan, 0]), 1.0)
    with pytest.raises(ValueError, match="three non-empty axes"):
        Voxels(np.zeros((0, 1, 1), dtype=bool), np.zeros(3), 1.0)
    with pytest.raises(ValueError, match="1 places"):
        Solid(one, np.ones((1, 1, 1), dtype=np.float32))


@settings(max_examples=30, deadline=None)
@given(filled=blocks)
def test_euler_of_voxels_is_that_of_their_adjacency_complex(filled) -> None:
    """Voxels, pairs, full 2 x 2 squares and full 2 x 2 x 2 cubes, counted one by one."""
    places = set(map(tuple, np.argwhere(filled).tolist()))
    count = 0
    for corner in places:
        for shape in itertools.product((0, 1), repeat=3):
            block = itertools.product(*((c, c + 1)[: s + 1] for c, s in zip(corner, shape, strict=True)))
            count += (-1) ** sum(shape) * (set(block) <= places)
    voxels = unit(filled)
    assert voxels.euler == count
    assert voxels.holes >= 0
