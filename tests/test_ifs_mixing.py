"""Mixed shapes against the weighted means of their parts, exact equations and prescribed borders."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import automata
import ifs
import subdivision
from automata.topology import Topology
from ifs.dimensions.alike import DifferentGluing, alike, factor, same_partition
from ifs.mixtures.basis import basis
from ifs.mixtures.mixed_surface import BordersApart, between
from ifs.mixtures.mixing import mixed, projected, rational
from ifs.mixtures.modulation import combined, modulated
from ifs.mixtures.parallel import times, together
from subdivision.schemes import (
    b_spline,
    bezier,
    bezier_triangle,
    koch,
    sierpinski_triangle,
    takagi,
    tensor,
)

T = np.linspace(0, 1, 17)[:, None]
ARCH = np.array([[0.0, 0], [40, 60], [80, 0]])


def side(curve, *points):
    return ifs.shape(curve, control=np.array(points, dtype=float))


def at(shape, t=T):
    return basis(shape, t) @ shape.control


def drawn(shape, depth):
    return ifs.draw(ifs.refined(ifs.initial(shape.topology, shape.system, shape.control), depth))


def over(u, v):
    """Parameters of a quadrangle, which count from the first corner drawn, for (u, v) of a tensor product."""
    square = ifs.shape(tensor(bezier(1), bezier(1)), control=np.array([[0, 0], [0, 1], [1, 0], [1, 1]]))
    origin, first, second = at(square, np.array([[0, 0], [1, 0], [0, 1]]))
    return np.linalg.solve(
        np.column_stack([first - origin, second - origin]), (np.hstack([u, v]) - origin).T
    ).T


def takagi_series(w, t):
    return sum(w**n * np.abs(2**n * t - np.round(2**n * t)) for n in range(60))


PAIRS = [
    (bezier(2), takagi()),
    (bezier(3), takagi(Fraction(2, 3))),
    (b_spline(2), takagi()),
    (b_spline(3), b_spline(2)),
    (sierpinski_triangle(takagi()), sierpinski_triangle(bezier(2))),
    (bezier_triangle(1), bezier_triangle(2)),
    (tensor(bezier(1), bezier(2)), tensor(takagi(), bezier(1))),
]


@pytest.mark.parametrize("parts", PAIRS, ids=lambda parts: parts[0].name)
def test_products_meet_all_constraints_exactly_and_are_glued_as_their_parts(parts):
    for found in (together(*parts), times(*parts)):
        assert subdivision.solve(found.automaton).degrees_of_freedom == 0
        for cells in alike([factor(found.automaton), factor(parts[0])]):
            ours, theirs = (
                Topology(a).subdivided(c).place
                for a, c in zip((found.automaton, parts[0]), cells, strict=True)
            )
            assert same_partition(ours, theirs)
    sizes = [part.cells[part.shape].points for part in parts]
    assert len(times(*parts).points) == np.prod(sizes)
    assert len(together(*parts).points) >= 1 + sum(size - 1 for size in sizes)


def test_a_product_contracts_as_slowly_as_its_slowest_part():
    parts = [bezier(2), takagi(Fraction(3, 4))]
    for found in (together(*parts), times(*parts)):
        points = len(found.points)
        bound = ifs.convergence(ifs.shape(found.automaton, control=np.zeros((points, 2))).system)
        assert bound.verdict == "contracts"
        assert bound.lower == pytest.approx(0.75, abs=1e-9)
        assert bound.upper < 0.85  # the search for a proof ends there


def test_a_symmetry_that_the_gluing_needs_is_kept():
    joined = together(bezier_triangle(1), bezier_triangle(2)).automaton
    assert set(joined.cells["triangle"].symmetry) == {"rotate", "mirror"}
    parts = [ifs.shape(bezier_triangle(d)) for d in (1, 2)]
    blended = mixed(parts, bezier_triangle(1), np.array([[1, 0, 0], [0, 1, 1]]))
    found = drawn(blended, 3)
    assert found.vertices.shape == drawn(parts[0], 3).vertices.shape == (45, 3)
    u, v = np.array([[0.25, 0.5], [0.125, 0.125], [0.5, 0.375]]).T
    t = np.column_stack([u, v])
    expected = (1 - u - v)[:, None] * at(parts[0], t) + (u + v)[:, None] * at(parts[1], t)
    assert np.allclose(at(blended, t), expected, atol=1e-11)


def test_mixing_a_shape_with_itself_gives_it_back():
    for curve in (bezier(2), takagi(), b_spline(3), sierpinski_triangle(takagi())):
        shape = ifs.shape(curve)
        count = 3 if "triangle" in curve.cells else 2
        blend = sierpinski_triangle() if count == 3 else bezier(1)
        whole = mixed([shape] * count, blend)
        assert np.abs(drawn(whole, 4).vertices - drawn(shape, 4).vertices).max() < 1e-12 * 100
        own = ifs.shape(blend, control=np.eye(count))
        assert (
            np.abs(modulated([shape] * count, own, 4).vertices - drawn(shape, 4).vertices).max() < 1e-12 * 100
        )


@pytest.mark.parametrize("blend", [bezier(2), b_spline(2), takagi(), takagi(Fraction(-1, 2))])
def test_a_mixed_curve_is_the_weighted_mean_at_every_parameter(blend):
    parts = [
        side(bezier(3), (0, 0), (9, 30), (60, 30), (80, 0)),
        side(takagi(), *ARCH),
        side(bezier(1), (0, 9), (80, 9)),
    ]
    whole = mixed(parts, blend)
    beta = basis(ifs.shape(blend), T)
    expected = sum(beta[:, k, None] * at(part) for k, part in enumerate(parts))
    assert np.abs(at(whole) - expected).max() < 1e-12 * 100


def test_a_mixed_curve_by_its_closed_forms():
    whole = mixed([side(bezier(2), *ARCH), side(takagi(), *ARCH)], bezier(1))
    t = T[:, 0]
    height = (1 - t) * 120 * t * (1 - t) + t * 120 * takagi_series(0.5, t)
    assert np.abs(at(whole) - np.column_stack([80 * t, height])).max() < 1e-11


def test_a_mixed_curve_is_smooth_at_one_end_and_rough_at_the_other():
    whole = mixed([side(bezier(2), *ARCH), side(takagi(), *ARCH)], bezier(1))
    smooth, rough = side(bezier(2), *ARCH), side(takagi(), *ARCH)
    for n in (4, 8, 12):
        near = T * 2.0**-n
        # b_1 <= 2^-n there, and the parts are 2 max(height) apart at the most.
        assert (
            np.abs(at(whole, near) - at(smooth, near)).max()
            <= 2.0**-n * np.abs(at(rough, near) - at(smooth, near)).max() + 1e-12
        )
        far = 1 - near
        assert (
            np.abs(at(whole, far) - at(rough, far)).max()
            <= 2.0**-n * np.abs(at(rough, far) - at(smooth, far)).max() + 1e-12
        )
    # Takagi's curve has second differences of order h, the parabola of order h^2.
    h = 2.0**-10
    at_end = [
        np.abs(np.diff(at(whole, end + np.array([[0], [1], [2]]) * h)[:, 1], 2)[0])
        for end in (0.0, 1 - 2 * h)
    ]
    assert at_end[1] > 50 * at_end[0]


def test_rational_weights():
    parts = [side(bezier(2), *ARCH), side(bezier(1), (0, 5), (80, 5)), side(takagi(), *ARCH)]
    for weights in ([4, 1, 1], [1, 4, 1], [1, 1, 4]):
        found = projected(drawn(rational(parts, bezier(2), weights), 5))
        t = np.arange(33) / 32
        bernstein = np.array([(1 - t) ** 2, 2 * t * (1 - t), t**2]) * np.array(weights)[:, None]
        beta = bernstein / bernstein.sum(axis=0)
        expected = sum(beta[k][:, None] * at(part, t[:, None]) for k, part in enumerate(parts))
        order = np.argsort(found.vertices[:, 0])
        assert np.abs(found.vertices[order] - expected[np.argsort(expected[:, 0])]).max() < 1e-11
    with pytest.raises(ValueError, match="3 positive weights"):
        rational(parts, bezier(2), [1, 0, 1])
    with pytest.raises(ValueError, match="vertex 1 has the denominator 0"):
        projected(ifs.Mesh(np.array([[1.0, 1], [2, 0]]), np.array([[0, 1]])))


def test_mixed_wires_have_the_topology_of_sierpinskis_triangle():
    parts = [ifs.shape(sierpinski_triangle(curve)) for curve in (bezier(2), takagi(), takagi(Fraction(1, 3)))]
    whole = mixed(parts, sierpinski_triangle())
    for depth in (0, 1, 3):
        found, one = drawn(whole, depth), drawn(parts[0], depth)
        assert (found.faces == one.faces).all()
        assert len(found.vertices) == len(one.vertices) == 3 * (3**depth + 1) // 2
    corners = drawn(ifs.shape(sierpinski_triangle(), control=np.eye(3)), 3).vertices
    expected = sum(corners[:, k, None] * drawn(part, 3).vertices for k, part in enumerate(parts))
    assert np.abs(drawn(whole, 3).vertices - expected).max() < 1e-12 * 100


def test_the_borders_of_a_mixed_surface_are_the_prescribed_curves():
    corners = [np.array(c, dtype=float) for c in ((0, 0, 0), (80, 0, 5), (0, 80, 9), (80, 80, 0))]
    bottom = side(bezier(2), corners[0], (40, 0, 40), corners[1])
    top = side(takagi(), corners[2], (40, 80, 30), corners[3])
    left = side(takagi(Fraction(5, 8)), corners[0], (0, 40, 20), corners[2])
    right = side(bezier(1), corners[1], corners[3])
    for blend, toward, h in (
        (None, None, T[:, 0]),
        (bezier(2), np.array([0, 0, 1]), T[:, 0] ** 2),
    ):
        some = (bottom, top, left, right)
        if blend is not None:  # to stay small
            some = (bottom, straight(top), straight(left), right)
        surface = between(some[0], some[1], some[2], some[3], blend, toward)
        zero, one = 0 * T, 0 * T + 1
        places = [over(*t) for t in ((T, zero), (T, one), (zero, T), (one, T), (T, T))]
        *borders, diagonal = np.split(at(surface, np.vstack(places)), 5)
        for curve, border in zip(some, borders, strict=True):
            assert np.abs(border - at(curve)).max() < 1e-12 * 100
        # Coons' patch on the diagonal.
        curves = [at(curve) for curve in some]
        ends = [some[0].control[0], some[0].control[-1], some[1].control[0], some[1].control[-1]]
        shares = [(1 - h) ** 2, h * (1 - h), (1 - h) * h, h**2]
        coons = (1 - h)[:, None] * (curves[0] + curves[2]) + h[:, None] * (curves[1] + curves[3])
        coons -= sum(share[:, None] * end for share, end in zip(shares, ends, strict=True))
        assert np.abs(diagonal - coons).max() < 1e-12 * 100


def straight(curve):
    """A straight line with the same ends."""
    return side(bezier(1), curve.control[0], curve.control[-1])


def test_borders_that_do_not_meet_are_refused():
    line = [
        side(bezier(1), *ends)
        for ends in ([(0, 0), (9, 0)], [(0, 9), (9, 9)], [(0, 0), (0, 9)], [(9, 0), (9, 8)])
    ]
    with pytest.raises(BordersApart, match=r"last points of top and right.* 1 mm apart") as error:
        between(*line)
    assert error.value.gap == 1
    with pytest.raises(ValueError, match="a border runs from a vertex 'left' of 1 control point"):
        between(ifs.shape(b_spline(2)), *line[1:])
    with pytest.raises(ValueError, match="a blend runs"):
        between(*line, b_spline(2))


def test_a_surface_that_joins_a_smooth_patch_to_a_rough_one():
    grid = np.array(
        [(40 * i, 40 * j, 30 * (i == 1) * (j == 1)) for i in range(3) for j in range(3)], dtype=float
    )
    smooth, rough = (ifs.shape(tensor(curve, curve), control=grid) for curve in (bezier(2), takagi()))
    along_u = np.array([[1, 1, 0, 0], [0, 0, 1, 1]])
    joint = mixed([smooth, rough], tensor(bezier(1), bezier(1)), along_u)
    zero, one = 0 * T, 0 * T + 1
    for share, part in ((zero, smooth), (one, rough)):
        assert np.abs(at(joint, over(share, T)) - at(part, over(share, T))).max() < 1e-10
    found = drawn(joint, 3)
    assert found.vertices.shape == (81, 3)
    assert found.faces.shape == (64, 4)
    expected = (1 - T) * at(smooth, over(T, T**2)) + T * at(rough, over(T, T**2))
    assert np.allclose(at(joint, over(T, T**2)), expected, atol=1e-10)


def between_parabola_and_takagi(share, t):
    """The height where Takagi's operators have a share: the bump of 60 mm is halved where a Bezier curve
    is and kept where Takagi's is, and each half has 1/4 of it there and 1/2 of it here."""
    return 60 * (1 + share) * takagi_series((1 + share) / 4, t)


def test_mixed_operators_of_one_weight_keep_the_gluing():
    parts = [side(bezier(2), *ARCH), side(takagi(), *ARCH)]
    half = combined(parts, [Fraction(1, 2)] * 2)
    assert np.abs(at(half)[:, 1] - between_parabola_and_takagi(0.5, T[:, 0])).max() < 1e-11
    constant = ifs.shape(bezier(1), control=np.array([[0.5, 0.5], [0.5, 0.5]]))
    assert np.abs(modulated(parts, constant, 5).vertices - drawn(half, 5).vertices).max() < 1e-11


def test_the_mixture_of_the_source_freezes_the_weights_of_each_point():
    parts = [side(bezier(2), *ARCH), side(takagi(), *ARCH)]
    found = modulated(parts, ifs.shape(bezier(1), control=np.eye(2)), 6)
    t = found.vertices[:, 0] / 80
    expected = between_parabola_and_takagi(t, t)
    assert np.abs(found.vertices[:, 1] - expected).max() < 1e-11
    assert (found.faces == drawn(parts[0], 6).faces).all()


def test_the_mixture_of_the_source_where_vertices_hold_several_points():
    wide = ifs.shape(b_spline(3))
    parts = [wide, replace(wide, control=wide.control + np.array([0.0, 10.0]))]
    found = modulated(parts, ifs.shape(bezier(1), control=np.eye(2)), 4)
    t = np.arange(17)[:, None] / 16
    expected = at(wide, t) + 10 * t * [0.0, 1.0]
    assert np.abs(found.vertices[np.argsort(found.vertices[:, 0])] - expected).max() < 1e-11


def test_the_mean_of_contracting_systems_may_grow():
    """Two maps of radius 0 whose mean has radius 2, which the source overlooks."""
    text = """
format = "bcifs/1"
name = "shear"
shape = "x"
[cells.x]
points = 3
subdivision = {{ 0 = "x" }}
matrices = {{ 0 = [{0}] }}
[control]
points = [[0, 0], [1, 0], [0, 1]]
"""
    rows = ("[1, 1, 1], [0, 0, 4], [0, 0, -4]", "[1, 1, 1], [0, 0, 0], [0, 4, 0]")
    rows = ("[1, 1, -3], [0, 0, 4], [0, 0, 0]", "[1, -3, 1], [0, 0, 0], [0, 4, 0]")
    parts = [ifs.shape(automata.parse_text(text.format(row))) for row in rows]
    assert [ifs.convergence(part.system).verdict for part in parts] == ["contracts"] * 2
    assert ifs.convergence(combined(parts, [0.5, 0.5]).system).lower == pytest.approx(2)


def test_different_gluings_are_refused_with_what_differs():
    cases = [
        (bezier(2), koch(), "sub-cell '2'", ("edge", "edge")),
        (sierpinski_triangle(), bezier_triangle(1), "sub-cell '3'", ("triangle", "triangle")),
    ]
    for one, other, said, cells in cases:
        with pytest.raises(DifferentGluing, match=said) as error:
            together(one, other)
        assert error.value.cells == cells
    loose = bezier(2)
    edge = replace(loose.cells["edge"], adjacency=(), symmetry={}, matrices={})
    apart = replace(loose, name="apart", cells={**loose.cells, "edge": edge})
    values = {
        "edge.1[0,0]": Fraction(1, 2),
        "edge.1[1,0]": Fraction(0),
        "edge.1[0,1]": Fraction(0),
        "edge.1[1,1]": Fraction(1, 2),
    }
    with pytest.raises(DifferentGluing, match=r"'.*' holds in .* and not in 'apart'"):
        together(loose, replace(apart, values={**loose.values, **values}))
    with pytest.raises(DifferentGluing, match="3 and 4 control points"):
        combined([ifs.shape(bezier(2)), ifs.shape(bezier(3))], [0.5, 0.5])


def test_wrong_weights_are_named():
    parts = [side(bezier(2), *ARCH), side(takagi(), *ARCH)]
    with pytest.raises(ValueError, match="column 1 of the weights sums to 2"):
        mixed(parts, bezier(1), np.array([[1, 1], [0, 1]]))
    with pytest.raises(ValueError, match="3 control points for 2 shapes"):
        mixed(parts, bezier(2))
    with pytest.raises(ValueError, match="2 weights that sum to 1"):
        combined(parts, [0.5, 0.6])
    with pytest.raises(ValueError, match="control point 1 of the blend sum to 2"):
        modulated(parts, ifs.shape(bezier(1), control=np.array([[1, 0], [1, 1]])), 2)
    with pytest.raises(ValueError, match="over 400"):
        times(*[bezier(4)] * 4)
