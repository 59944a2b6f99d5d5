"""The gallery's shapes in numbers: lengths, areas, volumes, counts and gluing, all known beforehand."""

import math
from fractions import Fraction
from importlib import import_module
from pathlib import Path

import networkx as nx
import numpy as np
import pytest

import fld
import gallery


def built(name):
    return import_module(f"gallery.{name}").build()


def graph(mesh):
    """The vertices and the sides of all polygons."""
    result = nx.Graph()
    result.add_nodes_from(range(len(mesh.vertices)))
    for face in mesh.faces:
        corners = [int(c) for c in face if c >= 0]
        sides = zip(corners, corners[1:] + corners[:1], strict=True) if len(corners) > 2 else [tuple(corners)]
        result.add_edges_from(sides)
    return result


def lengths(mesh):
    return np.linalg.norm(np.diff(mesh.vertices[mesh.faces], axis=1)[:, 0], axis=1)


def test_every_script_is_listed_and_short():
    folder = Path(gallery.__file__).parent
    scripts = {path.stem for path in folder.glob("*.py") if "def build()" in path.read_text("utf-8")}
    assert scripts == set(gallery.NAMES)
    for name in scripts:
        assert len((folder / f"{name}.py").read_text("utf-8").splitlines()) < 30


def test_corner_cutting_shows_the_five_behaviours():
    from gallery.corner_cutting import REGIONS, shapes

    mesh = built("corner_cutting")
    assert mesh.faces.shape == (5 * 2**10, 2)
    parts = list(nx.connected_components(graph(mesh)))
    assert [len(part) for part in parts] == [2**10 + 1] * 5
    joints = [fld.behaviour(shape, "1 0").joint for shape in shapes()]
    assert joints[:2] == ["smooth passage", "cusp"]
    assert all(joint.startswith("corner") for joint in joints[2:])
    # The eigenvector of the eigenvalue 1 is (b, a, 0) / (a + b): each curve starts in (30, 60) a / (a + b).
    for (a, b), shape in zip(REGIONS, shapes(), strict=True):
        share = float(Fraction(a) / (Fraction(a) + Fraction(b)))
        assert np.allclose(fld.behaviour(shape, "0").point, [30 * share, 60 * share])


def test_the_first_curve_of_corner_cutting_is_a_parabola_of_known_length():
    mesh = built("corner_cutting")
    first = min(nx.connected_components(graph(mesh)), key=lambda part: mesh.vertices[list(part), 0].min())
    own = np.isin(mesh.faces[:, 0], list(first))
    # From (15, 30) over (30, 45) to (45, 30): y = 45 - (x - 30)^2 / 15, of length 15 (sqrt 5 + asinh(2) / 2).
    assert lengths(mesh)[own].sum() == pytest.approx(15 * (math.sqrt(5) + math.asinh(2) / 2), rel=1e-6)


def test_the_snowflake_is_closed_with_the_length_and_area_of_its_series():
    mesh = built("koch_snowflake")
    assert len(mesh.vertices) == len(mesh.faces) == 3 * 4**6
    turns = graph(mesh)
    assert nx.number_connected_components(turns) == 1
    assert {degree for _, degree in turns.degree} == {2}
    assert lengths(mesh).sum() == pytest.approx(3 * 90 * (4 / 3) ** 6, rel=1e-12)
    loop = mesh.vertices[[edge[0] for edge in nx.find_cycle(turns)]]
    x, y = loop.T
    area = abs((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()) / 2
    triangle = math.sqrt(3) / 4 * 90**2
    assert area == pytest.approx(triangle * (1 + 3 / 5 * (1 - (4 / 9) ** 6)), rel=1e-12)


def test_the_takagi_curves_are_their_series():
    mesh = built("takagi")
    assert mesh.vertices.shape == (3 * (2**11 + 1), 2)
    for k, w in enumerate((1 / 4, 1 / 2, 2 / 3)):
        here = (mesh.vertices[:, 0] >= 90 * k - 1e-6) & (mesh.vertices[:, 0] <= 90 * k + 80 + 1e-6)
        x = (mesh.vertices[here, 0] - 90 * k) / 80
        series = sum(w**n * np.abs(2**n * x - np.round(2**n * x)) for n in range(12))
        assert here.sum() == 2**11 + 1
        assert np.allclose(mesh.vertices[here, 1], 80 * series, atol=1e-3)


def test_the_patches_are_two_discs_and_the_smooth_one_is_the_bicubic_spline():
    mesh = built("patches")
    links = graph(mesh)
    assert mesh.faces.shape == (2 * 4**6, 4)
    assert nx.number_connected_components(links) == 2
    assert len(mesh.vertices) - links.number_of_edges() + len(mesh.faces) == 2
    left = mesh.vertices[mesh.vertices[:, 0] <= 30 + 1e-6]
    assert len(left) == 65**2
    # Heights of the uniform bicubic B-spline over the unit square; x = 30 u, y = 30 + 30 v.
    heights = np.array([[0, 10, 20, 0], [10, 60, -20, 10], [0, -20, 60, 20], [-10, 0, 20, 0]])

    def weights(t):
        return np.array([(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3]) / 6

    u, v = left[:, 0] / 30, left[:, 1] / 30 - 1
    expected = np.einsum("in,ij,jn->n", weights(v), heights, weights(u))
    assert np.allclose(left[:, 2], expected, atol=1e-9)


def test_the_tetrahedra_touch_at_their_corners():
    mesh = built("sierpinski_tetrahedron")
    assert mesh.faces.shape == (4 * 4**5, 3)
    assert len(mesh.vertices) == 2 * 4**5 + 2  # 4^n pieces of 4 corners, all but 4 shared by two
    assert nx.number_connected_components(graph(mesh)) == 1
    solid = mesh.to_trimesh()
    # The area of the regular tetrahedron of 60 mm stays, 4^5 pieces of 1/4^5; the volume halves each time.
    assert solid.area == pytest.approx(math.sqrt(3) * 60**2, rel=1e-9)
    assert solid.volume == pytest.approx(60**3 / (6 * math.sqrt(2)) / 2**5, rel=1e-9)


def test_the_sponge_is_8000_cubes():
    mesh = built("menger_sponge")
    assert mesh.faces.shape == (8000 * 6, 4)
    assert (np.ptp(mesh.faces // 8, axis=1) == 0).all()  # eight vertices a cube, shared with no other
    corners = mesh.vertices.reshape(8000, 8, 3)
    assert np.allclose(np.ptp(corners, axis=1), 2, atol=1e-9)
    # Which cubes of 27^3 are there: those with no two coordinates whose digits to base 3 are 1 in one place.
    digits = np.array([[n // 9, n // 3 % 3, n % 3] for n in range(27)]) == 1
    inner = digits[:, None, None].astype(int) + digits[None, :, None] + digits[None, None, :]
    expected = {tuple(cell) for cell in np.argwhere((inner < 2).all(axis=-1))}
    found = {tuple(cell) for cell in np.rint(corners.min(axis=1) / 2).astype(int)}
    assert found == expected
    assert len(found) == 8000


def test_unknown_pictures_are_refused(capsys):
    from gallery.__main__ import main

    assert main(["mona_lisa"]) == 2
    assert "koch_snowflake" in capsys.readouterr().err


def test_the_ring_is_closed_with_a_smooth_and_a_rough_half():
    from scipy.interpolate import BSpline

    from gallery.half_rough import COLUMNS, DEPTH, ROWS

    mesh = built("half_rough")
    links = graph(mesh)
    assert nx.number_connected_components(links) == 1
    assert mesh.faces.shape == (ROWS * COLUMNS * 4**DEPTH, 4)
    assert len(mesh.vertices) - links.number_of_edges() + len(mesh.faces) == 0
    sides = np.sort(np.concatenate([mesh.faces[:, [i, (i + 1) % 4]] for i in range(4)]), axis=1)
    assert set(np.unique(sides, axis=0, return_counts=True)[1]) == {2}
    # On the smooth side the ring of largest radius lies on a biquadratic spline of the control ring.
    v = 2 * np.pi * np.arange(COLUMNS) / COLUMNS
    section = np.stack([40 + 15 * np.cos(v), 15 * np.sin(v)], axis=1)[[*range(COLUMNS), 0, 1]]
    spline = BSpline(np.arange(COLUMNS + 5), section, 2)(np.linspace(2, COLUMNS + 2, COLUMNS * 2**DEPTH + 1))
    u = 2 * np.pi * np.arange(3) / ROWS
    squeeze = BSpline(np.arange(6), np.stack([np.cos(u), np.sin(u)], axis=1), 2)(2.5)
    here = mesh.vertices[
        np.abs(np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0]) + 2 * np.pi * 6 / ROWS) < 1e-9
    ]
    radius = np.linalg.norm(here[:, :2], axis=1) / np.linalg.norm(squeeze)
    found = np.stack([radius, here[:, 2]], axis=1)
    assert len(found) == COLUMNS * 2**DEPTH
    assert np.abs(found[:, None] - spline[None]).max(axis=2).min(axis=1).max() < 1e-9


def test_the_middle_curve_is_the_mean_of_its_neighbours_by_the_parameter():
    mesh = built("mixed")
    assert mesh.faces.shape == (3 * 2**11, 2)
    assert nx.number_connected_components(graph(mesh)) == 3
    here = (mesh.vertices[:, 0] >= 90 - 1e-6) & (mesh.vertices[:, 0] <= 170 + 1e-6)
    t = (mesh.vertices[here, 0] - 90) / 80
    series = sum(np.abs(2**n * t - np.round(2**n * t)) / 2**n for n in range(12))
    assert here.sum() == 2**11 + 1
    assert np.allclose(mesh.vertices[here, 1], (1 - t) * 120 * t * (1 - t) + t * 120 * series, atol=1e-9)


def test_the_surface_between_four_curves_ends_in_them():
    mesh = built("mixed_surface")
    links = graph(mesh)
    assert mesh.faces.shape == (4**7, 4)
    assert len(mesh.vertices) - links.number_of_edges() + len(mesh.faces) == 1
    x, y, z = mesh.vertices.T
    for rim, expected in (
        (np.abs(y) < 1e-9, 80 * (x / 80) * (1 - x / 80)),
        (np.abs(x) < 1e-9, np.zeros(len(x))),
        (
            np.abs(y - 80) < 1e-9,
            60 * sum(np.abs(2**n * x / 80 - np.round(2**n * x / 80)) / 2**n for n in range(8)),
        ),
    ):
        assert rim.sum() == 2**7 + 1
        assert np.allclose(z[rim], expected[rim], atol=1e-9)
