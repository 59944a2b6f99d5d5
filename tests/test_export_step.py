"""Surfaces as STEP: exact faces against scipy's splines, solids against fine meshes and their own files."""

import os
import signal
import threading
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

import ifs
from export.step import step_report, to_build123d, write_step
from export.step.error import InsideOut, NotPolynomial, TooManyFaces, WrongEnding, WrongShell
from export.step.fit import surfaces
from export.step.joints import joined
from export.step.leaves import leaves
from export.step.loading import undisturbed
from export.step.polynomial import Limits, bernstein, elevation, polynomial_edges, polynomial_faces
from subdivision.schemes import b_spline, bezier
from subdivision.schemes.tensor import tensor

CUBE = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
CORNERS = 40.0 * np.array([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)])


def torus(rows: int, columns: int) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    u, v = 2 * np.pi * i / rows, 2 * np.pi * j / columns
    radius = 30 + 10 * np.cos(u)
    points = np.stack([radius * np.cos(v), radius * np.sin(v), 10 * np.sin(u)], axis=2)

    def number(i, j):
        return (i % rows) * columns + j % columns

    corners = ((0, 0), (0, 1), (1, 1), (1, 0))
    faces = [tuple(number(i + a, j + b) for a, b in corners) for i in range(rows) for j in range(columns)]
    return points.reshape(-1, 3), faces


def trapezohedron(n: int) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """2n quadrangles around two vertices of valence n, all other vertices of valence 3."""
    angle = np.pi * np.arange(2 * n) / n
    ring = np.stack([20 * np.cos(angle), 20 * np.sin(angle), 6 * (-1.0) ** np.arange(2 * n)], axis=1)
    number = range(2, 2 * n + 2)
    top = [(0, number[2 * i], number[2 * i + 1], number[(2 * i + 2) % (2 * n)]) for i in range(n)]
    low = [(1, number[2 * i + 1], number[2 * i], number[2 * i - 1]) for i in range(n)]
    return np.vstack([[0, 0, 30], [0, 0, -30], ring]), top + low


def corner_of_cubes() -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Four cubes of 20 mm around a corner: vertices of valences 3 to 6."""
    cells = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    numbers: dict[tuple, int] = {}
    faces = []
    for cell in cells:
        for axis in range(3):
            for side in (0, 1):
                if tuple(c + (2 * side - 1) * (a == axis) for a, c in enumerate(cell)) in cells:
                    continue
                face = []
                for s, t in ((0, 0), (1, 0), (1, 1), (0, 1))[:: 1 if side else -1]:
                    corner = list(cell)
                    for a, step in ((axis, side), ((axis + 1) % 3, s), ((axis + 2) % 3, t)):
                        corner[a] += step
                    face.append(numbers.setdefault(tuple(corner), len(numbers)))
                faces.append(tuple(face))
    return 20.0 * np.array(list(numbers)), faces


MESHES = {"cube": (CORNERS, CUBE), "valence 5": trapezohedron(5), "corner of cubes": corner_of_cubes()}


def read_back(path):
    import build123d

    return build123d.import_step(path)


def spline_torus(
    points: np.ndarray, degree: int, u: np.ndarray, v: np.ndarray, derivatives=(0, 0)
) -> np.ndarray:
    """The periodic B-spline surface of a grid of control points by scipy, at knots that are whole numbers."""
    from scipy.interpolate import BSpline

    def along(values, t, order):
        values = np.concatenate([values, values[:degree]])
        spline = BSpline(np.arange(len(values) + degree + 1), values, degree)
        return spline.derivative(order)(t + degree) if order else spline(t + degree)

    first = along(points, u, derivatives[0])
    return along(first.swapaxes(0, 1), v, derivatives[1]).swapaxes(0, 1)


# ---- which cells are polynomial ----------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "degree"), [("doo-sabin-patch", 2), ("catmull-clark-patch", 3)])
def test_regular_patches_are_splines(name, degree):
    """The Bernstein points of a patch give the uniform B-spline of its control points, by scipy."""
    from scipy.interpolate import BSpline

    patch = ifs.shape(name)
    limits = Limits(patch.topology, patch.system)
    (control,) = (np.einsum("nij,nd->ijd", m, patch.control) for m in polynomial_faces(limits).values())
    assert control.shape == (degree + 1, degree + 1, 3)
    t = np.linspace(0, 1, 7)
    found = np.einsum("ui,vj,ijd->uvd", bernstein(degree, t), bernstein(degree, t), control)
    knots = np.arange(-degree, degree + 2)
    grid = patch.control.reshape(degree + 1, degree + 1, 3)
    wanted = BSpline(knots, BSpline(knots, grid, degree)(t).swapaxes(0, 1), degree)(t)
    assert min(np.abs(found - turned).max() for turned in (wanted, wanted.swapaxes(0, 1))) < 1e-12


def test_tensor_products_are_polynomial_of_their_degree():
    for curve, degree in ((bezier(1), 1), (bezier(3), 3), (b_spline(2), 2), (bezier(4), 4)):
        patch = ifs.shape(tensor(curve, curve))
        limits = Limits(patch.topology, patch.system)
        found = polynomial_faces(limits, highest=5)
        assert {m.shape[1] for m in found.values()} == {degree + 1}
        assert bool(polynomial_faces(limits)) == (degree <= 3)
        assert polynomial_edges(limits, highest=5)


def test_bezier_patch_keeps_its_control_points():
    patch = ifs.shape(tensor(bezier(3), bezier(3)))
    found = polynomial_faces(Limits(patch.topology, patch.system))
    control = np.einsum("nij,nd->ijd", next(iter(found.values())), patch.control)
    ours = {tuple(point) for point in control.reshape(-1, 3).round(9).tolist()}
    assert ours == {tuple(point) for point in patch.control.round(9).tolist()}


def test_fractal_coefficients_are_refused():
    patch = ifs.shape("fractal-patch")
    limits = Limits(patch.topology, patch.system)
    assert list(limits.quads) == ["face"]
    assert not polynomial_faces(limits, highest=5)
    assert not polynomial_edges(limits, highest=5)
    near = ifs.shape("catmull-clark-patch", {"vertex.s[1,1]": Fraction(3, 8) + Fraction(1, 10**6)})
    assert not polynomial_faces(Limits(near.topology, near.system))


@pytest.mark.parametrize("scheme", ["catmull-clark", "doo-sabin"])
def test_extraordinary_cells_are_told_from_regular_ones(scheme):
    complex_ = ifs.surface(*MESHES["cube"], scheme).complex()
    limits = Limits(complex_.topology, complex_.system)
    found = surfaces(limits, complex_.control)
    assert len(found.exact) == 1
    assert not set(found.exact) & set(complex_.control)
    for cell in found.fitted:
        targets = limits.system.states[cell].targets
        assert sum(t in found.fitted for t in targets) in (1, 4)


def test_elevation_keeps_the_polynomial():
    control = np.random.default_rng(0).normal(size=3)
    t = np.linspace(0, 1, 9)
    np.testing.assert_allclose(
        bernstein(5, t) @ elevation(2, 5) @ control, bernstein(2, t) @ control, atol=1e-14
    )


# ---- exact solids ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("scheme", "degree"), [("catmull-clark", 3), ("doo-sabin", 2)])
def test_torus_is_exact(tmp_path, scheme, degree):
    """Its volume is that of the divergence theorem on scipy's spline, by Gauss quadrature that is exact."""
    points, faces = torus(6, 8)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    u = (np.arange(6)[:, None] + (nodes + 1) / 2).ravel()
    v = (np.arange(8)[:, None] + (nodes + 1) / 2).ravel()
    grid = points.reshape(6, 8, 3)
    place, along, across = (spline_torus(grid, degree, u, v, d) for d in ((0, 0), (1, 0), (0, 1)))
    area = np.outer(np.tile(weights / 2, 6), np.tile(weights / 2, 8))
    wanted = abs((area * np.einsum("uvd,uvd->uv", place, np.cross(along, across))).sum() / 3)

    path = tmp_path / "torus.step"
    report = write_step(ifs.surface(points, faces, scheme), path)
    assert (report.faces, report.exact, report.closed, report.valid) == (48, 48, True, True)
    assert report.volume == pytest.approx(wanted, rel=1e-10)
    assert report.gap < 1e-12
    assert report.angle < 1e-9
    solid = read_back(path)
    assert solid.is_valid
    assert len(solid.faces()) == 48
    assert solid.volume == pytest.approx(wanted, rel=1e-10)


def test_open_patch_is_a_shell(tmp_path):
    path = tmp_path / "patch.step"
    source = ifs.shape("catmull-clark-patch")
    report = write_step(source, path)
    assert (report.faces, report.exact, report.closed, report.valid, report.volume) == (
        1,
        1,
        False,
        True,
        0.0,
    )
    shell = to_build123d(source)
    assert read_back(path).area == pytest.approx(shell.area, rel=1e-10)
    centre = np.einsum("i,j,ijd->d", *2 * [np.array([1, 23, 23, 1]) / 48], source.control.reshape(4, 4, 3))
    import build123d

    assert shell.distance_to(build123d.Vertex(*centre)) < 1e-9


def test_closed_tube_of_one_patch_is_cut():
    """A Bezier patch whose ends coincide borders itself: it leaves as more faces, still exact."""
    patch = ifs.shape(tensor(bezier(3), bezier(1)))
    ring = np.array([[0.0, 0, 0], [40, 0, 0], [0, 40, 0]])
    control = np.concatenate([ring, ring + np.array([0, 0, 30])])
    rows = np.array([[0, 3, 1, 4, 2, 5, 0, 3]])
    tube = ifs.patchwork(patch.topology, patch.system, control, {patch.topology.automaton.shape: rows})
    report = step_report(tube)
    assert report.faces == report.exact > 1
    assert report.valid
    assert not report.closed


# ---- extraordinary points ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "scheme", "tolerance"),
    [
        ("cube", "catmull-clark", 0.05),
        ("valence 5", "catmull-clark", 0.1),
        ("corner of cubes", "doo-sabin", 0.1),
    ],
)
def test_solids_of_extraordinary_meshes(tmp_path, name, scheme, tolerance):
    """Valid after a round trip; the volume is the limit of fine meshes, whose error falls as 4^-depth."""
    points, faces = MESHES[name]
    path = tmp_path / "solid.step"
    report = write_step(ifs.surface(points, faces, scheme), path, tolerance)
    assert report.closed
    assert report.valid
    assert report.exact + report.fitted == report.faces
    assert 0 < report.fit_error <= tolerance
    assert report.gap < 1e-12
    assert report.angle < 6
    coarse, fine = (ifs.smooth(points, faces, depth, scheme).to_trimesh().volume for depth in (4, 5))
    wanted = (4 * fine - coarse) / 3
    assert report.volume == pytest.approx(wanted, rel=5e-5)
    solid = read_back(path)
    assert solid.is_valid
    assert solid.volume == pytest.approx(report.volume, rel=1e-10)
    assert len(solid.faces()) == report.faces


def test_limit_points_lie_within_the_tolerance():
    import build123d

    solid = to_build123d(ifs.surface(CORNERS, CUBE), tolerance=0.05)
    points = ifs.smooth(CORNERS, CUBE, 5).vertices
    corner = points[np.argmin(points.sum(axis=1))]
    near = points[np.argsort(np.linalg.norm(points - corner, axis=1))[:25]]
    shell = solid.shells()[0]
    away = [shell.distance_to(build123d.Vertex(*point)) for point in near]
    assert max(away) <= 0.05
    assert away[0] < 1e-9
    assert max(away) > 1e-6


def test_smaller_tolerances_give_smaller_defects():
    complex_ = ifs.surface(CORNERS, CUBE).complex()
    found = surfaces(Limits(complex_.topology, complex_.system), complex_.control)
    results = [leaves(complex_, found, tolerance) for tolerance in (0.04, 0.02, 0.01)]
    for (rough, far, level), (good, near, next_level) in pairwise(results):
        assert near < far / 2
        assert joined(good).angle_fitted < joined(rough).angle_fitted / 2
        assert next_level == level + 1
        assert len(good) == len(rough) + 3 * 24


def test_rings_meet_larger_faces_at_shared_edges():
    """Edges next to smaller faces are cut: every edge of a closed surface is used exactly twice."""
    complex_ = ifs.surface(CORNERS, CUBE).complex()
    found = surfaces(Limits(complex_.topology, complex_.system), complex_.control)
    parts, _, _ = leaves(complex_, found, 0.02)
    uses = [use for leaf in parts for use in leaf.uses]
    _, times = np.unique([use.edge for use in uses], return_counts=True)
    assert (times == 2).all()
    assert {len(leaf.uses) for leaf in parts} > {4}
    sheet = joined(parts)
    assert len(sheet.points) - len(times) + len(parts) == 2
    assert sheet.closed == (True,)


def test_creases_stay_sharp(tmp_path):
    """The cube with all edges sharp is the cube; its faces are exact and its volume is that of the cube."""
    edges = {(a, b): 10 for face in CUBE for a, b in zip(face, (*face[1:], face[0]), strict=True) if a < b}
    report = write_step(ifs.surface(CORNERS, CUBE, creases=edges), tmp_path / "cube.step")
    assert report.valid
    assert report.angle == pytest.approx(90, abs=1e-6)
    assert report.volume == pytest.approx(40**3, rel=1e-9)


@pytest.mark.parametrize("boundary", ["smooth", "corners"])
def test_open_meshes_are_exact_next_to_their_boundary(tmp_path, boundary):
    points = np.array([(10.0 * i, 10.0 * j, 3.0 * ((i * j) % 3)) for i in range(4) for j in range(4)])
    faces = [(4 * i + j, 4 * i + j + 4, 4 * i + j + 5, 4 * i + j + 1) for i in range(3) for j in range(3)]
    report = write_step(ifs.surface(points, faces, boundary=boundary), tmp_path / "open.step")
    assert report.valid
    assert not report.closed
    assert report.exact > report.fitted
    assert report.gap < 1e-12


# ---- what is refused, and facets ---------------------------------------------------------------------------


def test_fractal_surfaces_leave_as_facets_only(tmp_path):
    fractal = ifs.shape("fractal-patch")
    with pytest.raises(NotPolynomial, match=r"'face'.*not smooth.*3MF or STL.*facets=True") as caught:
        step_report(fractal)
    assert caught.value.cell == "face"
    report = write_step(fractal, tmp_path / "facets.step", facets=True, depth=2)
    assert (report.faces, report.facets, report.valid, report.closed) == (32, 32, True, False)
    area = ifs.mesh(fractal, 2).to_trimesh().area
    assert read_back(tmp_path / "facets.step").area == pytest.approx(area, rel=1e-9)
    with pytest.raises(TooManyFaces, match="16384") as caught:
        step_report(fractal, facets=True, depth=8)
    assert caught.value.most == 5000


def test_facets_of_a_closed_surface_are_a_solid():
    report = step_report(ifs.surface(CORNERS, CUBE), facets=True, depth=1)
    assert report.valid
    assert report.volume == pytest.approx(ifs.smooth(CORNERS, CUBE, 1).to_trimesh().volume, rel=1e-9)


def test_curves_are_refused():
    with pytest.raises(NotPolynomial, match="no quadrangle"):
        step_report(ifs.shape("corner-cutting"))
    with pytest.raises(NotPolynomial, match="draws no faces"):
        step_report(ifs.shape("corner-cutting"), facets=True)


def test_surfaces_inside_out_are_named():
    points, faces = torus(4, 4)
    with pytest.raises(InsideOut, match="clockwise") as caught:
        step_report(ifs.surface(points, [face[::-1] for face in faces]))
    assert caught.value.volume == pytest.approx(-step_report(ifs.surface(points, faces)).volume, rel=1e-9)


@pytest.mark.parametrize(("copies", "reason"), [(2, "same direction"), (3, "3 faces share an edge")])
def test_faces_that_form_no_surface_are_named(copies, reason):
    patch = ifs.shape("doo-sabin-patch")
    rows = np.arange(9)[None].repeat(copies, axis=0)
    shape = ifs.patchwork(patch.topology, patch.system, patch.control, {"face": rows})
    with pytest.raises(WrongShell, match=reason):
        step_report(shape)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, float("nan")])
def test_tolerances_are_positive(tolerance):
    with pytest.raises(ValueError, match="positive number of millimetres"):
        step_report(ifs.surface(CORNERS, CUBE), tolerance)


def test_tolerances_that_need_too_many_faces_are_refused():
    complex_ = ifs.surface(CORNERS, CUBE).complex()
    found = surfaces(Limits(complex_.topology, complex_.system), complex_.control)
    with pytest.raises(TooManyFaces, match="larger tolerance") as caught:
        leaves(complex_, found, 1e-30, most=500)
    assert caught.value.count > 500


def test_same_input_gives_same_bytes(tmp_path):
    for name in ("a.step", "b.step"):
        write_step(ifs.surface(CORNERS, CUBE), tmp_path / name, tolerance=0.1)
    assert (tmp_path / "a.step").read_bytes() == (tmp_path / "b.step").read_bytes()
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["a.step", "b.step"]


@pytest.mark.parametrize("name", ["part.stl", "part", "part.step.3mf", ".step"])
def test_other_endings_are_refused_before_the_work(tmp_path, name):
    with pytest.raises(WrongEnding, match=r"end in \.step or \.stp"):
        write_step(ifs.surface(CORNERS, CUBE), tmp_path / name, tolerance=-1.0)
    assert not list(tmp_path.iterdir())
    with pytest.raises(ValueError, match="the tolerance"):
        write_step(ifs.surface(CORNERS, CUBE), tmp_path / "part.STP", tolerance=-1.0)


def test_an_interrupt_waits_for_the_end_of_the_block():
    done = []

    def work():
        with undisturbed():
            os.kill(os.getpid(), signal.SIGINT)
            done.extend(range(1000))
        done.append("never")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done == list(range(1000))
    assert signal.getsignal(signal.SIGINT) == signal.default_int_handler


def test_other_threads_and_handlers_are_left_alone():
    def inside():
        with undisturbed():
            found.append(signal.getsignal(signal.SIGINT))

    found = []
    thread = threading.Thread(target=inside)
    thread.start()
    thread.join()
    assert found == [signal.default_int_handler]
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        inside()
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    assert found[1] == signal.SIG_IGN
