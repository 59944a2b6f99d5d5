"""The voxel cover of an attractor, and the part made from it."""

import numpy as np
import pytest

import automata
import ifs
from export import Voxels, cover, make_part, surface
from export.cover import TOLERANCE, TooManyVoxels, lattice_resolution

SHAPES = [name for name in automata.builtin_names() if name != "menger-sponge"]


def chaos_game(shape: ifs.Shape, count: int) -> np.ndarray:
    """Points of the attractor in mm, by random infinite addresses: independent of pieces and boxes."""
    rng = np.random.default_rng(7)
    pieces = {shape.system.shape: np.repeat(shape.control[None], count, axis=0)}
    for _ in range(60):
        smaller: dict[str, list[np.ndarray]] = {}
        for cell, controls in pieces.items():
            state = shape.system.states[cell]
            chosen = rng.integers(len(state.labels), size=len(controls))
            for label, (operator, target) in enumerate(zip(state.operators, state.targets, strict=True)):
                moved = np.einsum("jk,cjd->ckd", operator, controls[chosen == label])
                smaller.setdefault(target, []).append(moved)
        pieces = {cell: np.concatenate(parts) for cell, parts in smaller.items()}
    places = np.concatenate([controls[:, 0] for controls in pieces.values()])
    return np.pad(places, ((0, 0), (0, 3 - places.shape[1])))


def inside(voxels: Voxels, points: np.ndarray) -> np.ndarray:
    """Whether points lie in closed filled voxels, widened by the stated tolerance."""
    places = (points - voxels.origin) / voxels.pitch
    found = np.zeros(len(points), dtype=bool)
    top = np.array(voxels.filled.shape) - 1
    for slack in np.stack(np.meshgrid(*[(-TOLERANCE, TOLERANCE)] * 3), axis=-1).reshape(-1, 3):
        index = np.clip(np.floor(places + slack).astype(int), 0, top)
        within = (places >= index - TOLERANCE) & (places <= index + 1 + TOLERANCE)
        found |= within.all(axis=1) & voxels.filled[tuple(index.T)]
    return found


@pytest.mark.parametrize("name", automata.builtin_names())
@pytest.mark.parametrize("resolution", [17, 64])
def test_every_point_of_the_attractor_lies_in_a_filled_voxel(name, resolution):
    shape = ifs.shape(name)
    assert inside(cover(shape, resolution).voxels, chaos_game(shape, 10_000)).all()


@pytest.mark.parametrize("name", SHAPES)
def test_no_filled_voxel_is_far_from_the_attractor(name):
    from scipy.spatial import KDTree

    shape = ifs.shape(name)
    found = cover(shape, 20)
    points = chaos_game(shape, 40_000)
    distance, _ = KDTree(points).query(found.voxels.centres())
    # The sample itself is no finer than about a pitch here; the bound holds for the far corner of a voxel.
    assert distance.max() <= found.distance
    assert found.distance <= 2 * np.sqrt(3) * found.voxels.pitch * (1 + 1e-9)


@pytest.mark.parametrize(("level", "genus"), [(1, 5), (2, 81), (3, 1409)])
def test_menger_levels_are_exact(level, genus):
    part = make_part(ifs.shape("menger-sponge"), size=1.0, depth=level)
    assert part.voxels.filled.shape == (3**level,) * 3
    assert part.report.ok
    assert part.report.genus == (genus,)
    assert part.report.volume == pytest.approx((20 / 27) ** level, rel=1e-9)
    assert part.voxels.count == 20**level


def test_the_limit_of_the_sponge_on_its_own_grid_is_the_sponge_of_that_level():
    shape = ifs.shape("menger-sponge")
    assert np.array_equal(cover(shape, 27).voxels.filled, cover(shape, 27, depth=3).voxels.filled)


def test_a_lattice_is_found_only_where_there_is_one():
    assert lattice_resolution(ifs.shape("menger-sponge"), 3) == 27
    assert lattice_resolution(ifs.shape("koch-curve"), 3) is None
    assert lattice_resolution(ifs.shape("sierpinski-tetrahedron"), 2) is None


def test_a_thickened_curve_is_a_ball_swept_over_it():
    from scipy.spatial import KDTree

    shape = ifs.shape("koch-curve")
    radius = 3.0
    part = make_part(shape, size=60, thickness=2 * radius, resolution=120)
    pitch = part.voxels.pitch
    points = chaos_game(shape, 20_000) * (60 / 90)
    directions = np.random.default_rng(3).normal(size=points.shape)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # A mesh with edges of a voxel stands for the curve, and each voxel of the part for its centre.
    reach = radius - 1.5 * np.sqrt(3) * pitch
    assert part.report.ok
    assert inside(part.voxels, points + reach * directions).all()
    distance, _ = KDTree(points).query(part.voxels.centres())
    assert distance.max() <= radius + np.sqrt(3) * pitch


def test_smooth_and_exact_surfaces_share_their_triangles():
    shape = ifs.shape("doo-sabin-patch")
    solid = make_part(shape, thickness=3.0, resolution=40)
    exact = make_part(shape, thickness=3.0, resolution=40, style="exact")
    assert len(solid.voxels.filled) == len(exact.voxels.filled)
    assert exact.report.volume == pytest.approx(surface_volume(surface(exact.voxels, "exact")), rel=1e-12)
    assert solid.report.genus == exact.report.genus == (0,)
    assert solid.report.volume == pytest.approx(exact.report.volume, rel=0.15)


def surface_volume(mesh: ifs.Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.einsum("td,td->", a, np.cross(b, c)) / 6)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"size": -1.0}, "size is above 0"),
        ({"thickness": float("nan")}, "thickness is 0 mm or more"),
        ({"resolution": 0}, "resolutions go from 1"),
        ({"depth": -1}, "depth is 0 or more"),
    ],
)
def test_senseless_numbers_are_refused(options, words):
    with pytest.raises(ValueError, match=words):
        make_part(ifs.shape("koch-curve"), **options)


def test_a_grid_that_cannot_fit_is_refused_before_any_work():
    with pytest.raises(TooManyVoxels, match="Lower the resolution"):
        make_part(ifs.shape("menger-sponge"), resolution=5000)
    with pytest.raises(TooManyVoxels):
        make_part(ifs.shape("menger-sponge"), resolution=1100, thickness=1.0)


def test_progress_rises_to_one():
    told: list[tuple[str, float]] = []
    make_part(ifs.shape("menger-sponge"), resolution=40, progress=lambda *step: told.append(step))
    shares = [share for stage, share in told if stage == "voxels"]
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)
    assert [*dict.fromkeys(stage for stage, _ in told)] == ["voxels", "thickness", "surface", "check"]
