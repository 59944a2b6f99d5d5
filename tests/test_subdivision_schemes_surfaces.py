"""Products of curves, triangles and walls: exact solutions, closed forms, and gluing that loses nothing."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, permutations, product
from math import factorial, log

import numpy as np
import pytest
from scipy.interpolate import NdBSpline

import automata
import ifs
import subdivision
from automata.consistency import require_consistency
from automata.topology import Topology
from ifs.dimensions.dimension import similarity_dimension
from ifs.shape import system
from subdivision.schemes import (
    b_spline,
    bezier,
    chain,
    corner_cutting,
    de_rham,
    interpolation,
    koch,
    nonuniform_b_spline,
    takagi,
)
from subdivision.schemes.loop import loop
from subdivision.schemes.tensor import tensor
from subdivision.schemes.triangles import bezier_triangle, sierpinski_triangle
from subdivision.schemes.wall import menger_wall, wall

PAIRS = [
    (b_spline(4), de_rham(Fraction(1, 3))),
    (koch(), corner_cutting(Fraction(1, 5), Fraction(2, 7))),
    (interpolation([(0, 0), (1, 2), (3, 1), (4, 0)], [0.3, -0.2, 0.5]), takagi()),
    (nonuniform_b_spline(2, [0, 1, 1]), nonuniform_b_spline(3, [1, 1, 1, 1, 2])),
    (automata.read("nonuniform-quadratic-spline"), bezier(1)),
]


def sides_of(mesh: ifs.Mesh) -> dict[tuple[int, int], int]:
    """How many faces use each edge."""
    found: dict[tuple[int, int], int] = {}
    for face in mesh.faces.tolist():
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            found[min(a, b), max(a, b)] = found.get((min(a, b), max(a, b)), 0) + 1
    return found


def euler(mesh: ifs.Mesh) -> int:
    return len(mesh.vertices) - len(sides_of(mesh)) + len(mesh.faces)


def rims(mesh: ifs.Mesh) -> int:
    """How many closed lines the edges of one face form."""
    groups: list[set[int]] = []
    for pair in (pair for pair, count in sides_of(mesh).items() if count == 1):
        met = [group for group in groups if group & set(pair)]
        groups = [group for group in groups if group not in met] + [set(pair).union(*met)]
    return len(groups)


def glued(shape: ifs.Shape, control: np.ndarray, rows, depth: int) -> ifs.Mesh:
    patches = {shape.automaton.shape: np.array(rows)}
    return ifs.draw(ifs.refined(ifs.patchwork(shape.topology, shape.system, control, patches), depth))


def exact(automaton: automata.Automaton, freedom: int | None = None):
    """The operators in exact numbers, each column of which sums to 1."""
    solution = subdivision.solve(automaton)
    assert freedom is None or solution.degrees_of_freedom == freedom
    numbers = solution.numbers()
    for table in numbers.values():
        for rows in table.values():
            assert {sum(column) for column in zip(*rows, strict=True)} == {1}
    return numbers


def solved(automaton: automata.Automaton, numbers, control=None) -> ifs.Shape:
    """The shape with operators that are known already."""
    points = np.array(automaton.control if control is None else control, dtype=float)
    return ifs.Shape(automaton.name, Topology(automaton), system(automaton, numbers), points)


def assert_close(found, expected, size: float = 1.0) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * size)


def grid(across: np.ndarray, along: np.ndarray, heights: np.ndarray) -> np.ndarray:
    x, y = np.meshgrid(across, along, indexing="ij")
    return np.stack([x, y, heights], axis=2).reshape(-1, 3)


@pytest.mark.parametrize(("first", "second"), PAIRS, ids=lambda curve: curve.name)
def test_products_are_solved_exactly_and_their_meshes_are_lattices(first, second):
    surface = tensor(first, second)
    require_consistency(surface)
    numbers = exact(surface, 0)
    assert len(surface.control or ()) == surface.cells[surface.shape].points
    steps = [len(curve.cells[curve.shape].subdivision) for curve in (first, second)]
    mesh = ifs.mesh(solved(surface, numbers), 2)
    across, along = (n**2 for n in steps)
    assert len(mesh.faces) == across * along
    assert len(mesh.vertices) == (across + 1) * (along + 1)
    assert euler(mesh) == 1
    assert list(sides_of(mesh).values()).count(1) == 2 * (across + along)


def test_operators_are_kronecker_products():
    one, other = exact(b_spline(2)), exact(takagi())
    found = exact(tensor(b_spline(2), takagi()))["edge*edge"]
    for s, t in product("01", "01"):
        expected = np.kron(np.array(one["edge"][s], float), np.array(other["edge"][t], float))
        assert np.array_equal(np.array(found[f"{s}*{t}"], float), expected)


def knots(degree: int, intervals) -> np.ndarray:
    inner = np.concatenate([[0.0], np.cumsum(np.array(intervals, dtype=float))])
    return np.concatenate([inner[:1] - 1, inner, inner[-1:] + 1])


def greville(degree: int, t: np.ndarray) -> np.ndarray:
    return np.array([t[i + 1 : i + degree + 1].mean() for i in range(len(t) - degree - 1)])


@pytest.mark.parametrize(
    ("degrees", "intervals"),
    [
        ((2, 3), ([1, 2, 4], [1, 1, 1, 1, 1])),
        ((3, 2), ([1, 1, 1, 1, 0.3], [5, 1, 1])),
    ],
)
def test_products_of_splines_are_scipys(degrees, intervals):
    t = tuple(knots(d, v) for d, v in zip(degrees, intervals, strict=True))
    heights = np.random.default_rng(1).normal(size=tuple(d + 1 for d in degrees))
    control = grid(greville(degrees[0], t[0]), greville(degrees[1], t[1]), heights)
    surface = tensor(*(nonuniform_b_spline(d, v) for d, v in zip(degrees, intervals, strict=True)))
    found = ifs.mesh(ifs.shape(surface, control=control), 2).vertices
    assert len(found) == 25
    assert_close(found[:, 2], NdBSpline(t, heights, degrees)(found[:, :2]), 10)


@pytest.mark.parametrize("degrees", [(3, 3), (1, 6)])
def test_products_of_bezier_curves_are_bernsteins(degrees):
    heights = np.random.default_rng(2).normal(size=tuple(d + 1 for d in degrees))
    control = grid(*(np.arange(d + 1) / d for d in degrees), heights=heights)
    found = ifs.mesh(ifs.shape(tensor(*map(bezier, degrees)), control=control), 2).vertices
    weights = [
        [factorial(d) / factorial(i) / factorial(d - i) * t**i * (1 - t) ** (d - i) for i in range(d + 1)]
        for d, t in zip(degrees, found[:, :2].T, strict=True)
    ]
    assert_close(np.einsum("in,jn,ij->n", *map(np.array, weights), heights), found[:, 2])


def test_products_of_takagi_curves_are_products_of_sums():
    w, depth = (Fraction(1, 2), Fraction(2, 3)), 4
    bump = np.array([0, 0.5, 0])
    places = np.array([0, 0.5, 1])
    control = grid(places, places, np.outer(bump, bump))
    found = ifs.mesh(ifs.shape(tensor(*map(takagi, w)), control=control), depth).vertices
    assert len(np.unique(found[:, :2], axis=0)) == (2**depth + 1) ** 2
    sums = [
        sum(float(r) ** n * np.abs(2**n * x - np.round(2**n * x)) for n in range(depth + 1))
        for r, x in zip(w, found[:, :2].T, strict=True)
    ]
    assert_close(found[:, 2], sums[0] * sums[1])


def test_the_default_surface_moves_one_curve_along_the_other():
    surface = tensor(takagi(), koch())
    found = ifs.mesh(ifs.shape(surface), 2).vertices
    first, second = (ifs.mesh(ifs.shape(curve), 2).vertices for curve in (takagi(), koch()))
    expected = [(x, y, z + h) for x, z in first for y, h in second]
    order = lambda rows: rows[np.lexsort(np.round(rows, 9).T)]  # noqa: E731
    assert_close(order(found), order(np.array(expected)), 90)


def ring(count: int, width: int, reverse: bool) -> np.ndarray:
    """Rows of control points around a ring, each of them closing it through the reversed ones if asked."""
    number = np.arange(count * width).reshape(count, width)
    around = np.concatenate([number, number[:, ::-1] if reverse else number])
    return np.stack([around[i : i + 3].ravel() for i in range(count)])


@pytest.mark.parametrize("across", [takagi(), b_spline(3)])
def test_patches_close_into_tubes_and_moebius_bands(across):
    surface, width = ifs.shape(tensor(b_spline(2), across)), across.cells[across.shape].points
    control = np.random.default_rng(3).normal(size=(5 * width, 3))
    for reverse, lines in ((False, 2), (True, 1)):
        mesh = glued(surface, control, ring(5, width, reverse), 1)
        assert len(mesh.vertices) == 5 * 2 * 3
        assert (euler(mesh), rims(mesh)) == (0, lines)
        assert max(sides_of(mesh).values()) == 2


def test_patches_close_into_a_torus():
    m, n = 4, 5
    one, other = (chain(b_spline(d), count, closed=True).patches["edge"] for d, count in ((3, m), (2, n)))
    rows = [(a[:, None] * n + b).ravel() for a in one for b in other]
    surface = ifs.shape(tensor(b_spline(3), b_spline(2)))
    mesh = glued(surface, np.random.default_rng(4).normal(size=(m * n, 3)), rows, 1)
    assert len(mesh.vertices) == len(mesh.faces) == 4 * m * n
    assert set(sides_of(mesh).values()) == {2}


@pytest.mark.parametrize(
    ("first", "words"),
    [
        ("sierpinski-triangle", "is no curve.*'triangle' has 3 pieces"),
        ("catmull-clark-patch", "is no curve"),
        ("menger-sponge", "is no curve"),
        (b_spline(20), "at most 400 control points, found 21 by 21"),
        (replace(koch(), shape="vertex"), "'vertex' has 1 pieces and the boundaries none"),
    ],
)
def test_what_is_no_curve_has_no_product(first, words):
    first = automata.read(first) if isinstance(first, str) else first
    with pytest.raises(ValueError, match=words):
        tensor(first, b_spline(20))


def test_products_need_values():
    with pytest.raises(subdivision.Undetermined):
        tensor(koch(), replace(koch(), values={}))


def orbits(elements, items) -> int:
    """How many classes a group makes of some items; each element is a function of an item."""
    return len({min(element(item) for element in elements) for item in items})


def equivariant(elements, points, places) -> int:
    """The freedom of columns summing to 1, a column for each point, that commute with a group."""
    pairs = list(product(points, places))
    both = [lambda pair, g=g: (g(pair[0]), g(pair[1])) for g in elements]
    return orbits(both, pairs) - orbits(elements, list(points)) if pairs else 0


GROUP = [lambda p, order=order: tuple(p[i] for i in order) for order in permutations(range(3))]
MIRROR = [lambda p: p, lambda p: (p[0], p[2], p[1])]


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_bezier_triangles_have_the_freedom_that_their_symmetries_leave(degree):
    automaton = bezier_triangle(degree)
    require_consistency(automaton)
    places = [p for p in product(range(degree + 1), repeat=3) if sum(p) == degree]
    corner = [p for p in places if p[1] and p[2]]
    middle = [p for p in places if min(p)]
    expected = equivariant(MIRROR, corner, places) + equivariant(GROUP, middle, places)
    expected += degree * (degree - 1) + degree // 2
    exact(automaton, expected)


@pytest.mark.parametrize("degree", [2, 5])
def test_bezier_triangles_are_polynomials_in_bernsteins_form(degree):
    automaton = bezier_triangle(degree)
    control = np.array(automaton.control)
    places = [(degree - j - k, j, k) for k in range(degree + 1) for j in range(degree + 1 - k)]
    control[:, :2] = np.array(places)[:, :2] / degree
    control[:, 2] = np.random.default_rng(degree).normal(size=len(places))
    mesh = ifs.mesh(ifs.shape(automaton, control=control), 2)
    assert (len(mesh.vertices), len(mesh.faces), euler(mesh)) == (15, 16, 1)
    a, b, z = mesh.vertices.T
    weights = [
        factorial(degree)
        * np.prod([x**n / factorial(n) for x, n in zip((a, b, 1 - a - b), place, strict=True)], 0)
        for place in places
    ]
    assert_close(z, control[:, 2] @ np.array(weights))


def test_bezier_triangles_close_into_an_octahedron_however_they_turn():
    corners = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    names = {frozenset([i]): i for i in range(6)}
    rows = []
    for n, (a, b, c) in enumerate(product((0, 1), (2, 3), (4, 5))):
        a, b, c = [(a, b, c), (b, a, c), (c, b, a), (b, c, a)][n % 4]
        row = [(a,), (a, b), (b,), (a, c), (b, c), (c,)]
        rows.append([names.setdefault(frozenset(pair), len(names)) for pair in row])
    control = np.array([np.mean([corners[i] for i in pair], axis=0) for pair in names])
    mesh = glued(ifs.shape(bezier_triangle(2)), control, rows, 2)
    assert (len(mesh.vertices), euler(mesh), set(sides_of(mesh).values())) == (4 * 16 + 2, 2, {2})


STEPS = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)]
PATCH = [(0, -1), (1, -1), (2, -1), (-1, 0), (0, 0), (1, 0), (2, 0), (-1, 1), (0, 1), (1, 1), (-1, 2), (0, 2)]


UNKNOWN = Fraction(10**9)


def loops_refinement(heights: dict) -> dict:
    """One step of Loop's scheme on points of a lattice, wherever all that it needs is known."""
    found = {}
    for x, y in heights:
        near = [heights.get((x + dx, y + dy), UNKNOWN) for dx, dy in STEPS]
        if UNKNOWN not in near:
            found[2 * x, 2 * y] = Fraction(5, 8) * heights[x, y] + Fraction(1, 16) * sum(near)
        for n in range(3):
            end, one, other = near[n], near[(n + 1) % 6], near[n - 1]
            if UNKNOWN not in (end, one, other):
                at = (2 * x + STEPS[n][0], 2 * y + STEPS[n][1])
                found[at] = Fraction(3, 8) * (heights[x, y] + end) + Fraction(1, 8) * (one + other)
    return found


def test_loop_is_its_plain_refinement_and_limit():
    automaton = loop()
    require_consistency(automaton)
    numbers = exact(automaton, 2)
    limit = [Fraction(1, 2), *[Fraction(1, 12)] * 6]
    for row, value in zip(numbers["vertex"]["s"], limit, strict=True):
        assert sum(a * b for a, b in zip(row, limit, strict=True)) == value
    heights = dict(zip(PATCH, map(int, np.random.default_rng(5).integers(-99, 99, size=12)), strict=True))
    refined = loops_refinement(loops_refinement(heights))
    expected = {
        (x / 4, y / 4): float(value / 2 + sum(refined[x + dx, y + dy] for dx, dy in STEPS) / 12)
        for (x, y), value in refined.items()
        if min(x, y) >= 0 and x + y <= 4
    }
    control = np.array([(x, y, heights[x, y]) for x, y in PATCH], dtype=float)
    mesh = ifs.mesh(solved(automaton, numbers, control), 2)
    assert len(mesh.vertices) == len(expected) == 15
    found = {(round(x, 9), round(y, 9)): z for x, y, z in mesh.vertices}
    for at, value in expected.items():
        assert found[at] == pytest.approx(value, abs=1e-10)


def test_loop_is_a_polynomial_of_degree_4_and_no_less():
    heights = np.random.default_rng(6).normal(size=12)
    control = np.column_stack([np.array(PATCH, dtype=float), heights])
    x, y, z = ifs.mesh(ifs.shape(loop(), control=control), 3).vertices.T
    assert len(z) == 45
    for degree, fits in ((4, True), (3, False)):
        basis = np.array([x**i * y**j for i, j in product(range(5), repeat=2) if i + j <= degree]).T
        error = np.abs(basis @ np.linalg.lstsq(basis, z, rcond=None)[0] - z).max()
        assert (error < 1e-12) if fits else (error > 1e-4)


@pytest.mark.parametrize("turned", [False, True])
def test_loop_patches_close_into_a_torus_however_they_turn(turned):
    n = 4
    rows = []
    for x, y in product(range(n), repeat=2):
        rows.append([(x + i) % n * n + (y + j) % n for i, j in PATCH])
        mirrored = [(1 - j, 1 - i) if turned else (1 - i, 1 - j) for i, j in PATCH]
        rows.append([(x + i) % n * n + (y + j) % n for i, j in mirrored])
    mesh = glued(ifs.shape(loop()), np.random.default_rng(7).normal(size=(n * n, 3)), rows, 1)
    assert len(mesh.vertices) == 4 * n * n
    assert (euler(mesh), set(sides_of(mesh).values())) == (0, {2})


@pytest.mark.parametrize("curve", [bezier(1), takagi(), bezier(3)], ids=lambda c: c.name)
def test_sierpinskis_triangle_has_the_freedom_of_its_sides(curve):
    automaton = sierpinski_triangle(curve)
    require_consistency(automaton)
    numbers = exact(automaton)
    last = curve.cells[curve.shape].points - 1
    count = 3 * last
    mirror = [lambda n: n, lambda n: (3 * last - n) % count]
    inner = equivariant(mirror, range(last + 1, 2 * last), range(count))
    own = subdivision.solve(replace(curve, values={})).degrees_of_freedom
    assert subdivision.solve(replace(automaton, values={})).degrees_of_freedom == own + inner
    mesh = ifs.mesh(solved(automaton, numbers), 3)
    assert (len(mesh.faces), len(mesh.vertices)) == (27, 42)
    assert set(sides_of(mesh).values()) == {1}


def test_sierpinskis_triangle_with_straight_sides_is_the_built_in_one():
    plain, known = (
        exact(a)["triangle"] for a in (sierpinski_triangle(), automata.read("sierpinski-triangle"))
    )
    assert {label: plain[label] for label in "012"} == {label: known[label] for label in "012"}
    assert similarity_dimension(ifs.shape(sierpinski_triangle())) == pytest.approx(log(3) / log(2))


def test_the_sides_of_sierpinskis_triangle_are_the_curve_and_its_inner_ones_are_smaller():
    shape = ifs.shape(sierpinski_triangle(takagi(), Fraction(1, 3)))
    mesh = ifs.mesh(shape, 4).vertices
    for turn in range(3):
        ends = [shape.control[(2 * turn + n) % 6] for n in range(3)]
        side = ifs.mesh(ifs.shape(takagi(), control=np.array(ends)), 4).vertices
        assert len(side) == 17
        for point in side:
            assert np.abs(mesh - point).max(axis=1).min() < 1e-12 * 90
    column = [row[3] for row in exact(sierpinski_triangle(takagi(), Fraction(1, 3)))["triangle"]["0"]]
    half, third, sixth = Fraction(1, 2), Fraction(1, 3), Fraction(1, 6)
    assert column == [0, half, -sixth, third, -sixth, half]


def test_a_triangle_may_lean_on_a_curve_without_mirror():
    curve = interpolation([(0, 0), (40, 30), (90, 0)], [0.25, -0.5])
    automaton = sierpinski_triangle(curve)
    require_consistency(automaton)
    assert subdivision.solve(replace(automaton, values={})).degrees_of_freedom == 6 + 5
    assert len(ifs.mesh(ifs.shape(automaton), 3).vertices) == 42


@pytest.mark.parametrize("backward", [False, True])
def test_two_of_sierpinskis_triangles_share_a_side(backward):
    control = np.random.default_rng(8).normal(size=(9, 2))
    other = [0, 1, 2, 6, 7, 8] if backward else [2, 1, 0, 6, 7, 8]
    mesh = glued(ifs.shape(sierpinski_triangle(takagi())), control, [[0, 1, 2, 3, 4, 5], other], 3)
    assert len(mesh.faces) == 2 * 27
    assert len(mesh.vertices) == 2 * 42 - 9


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: bezier_triangle(0), "degree is 1 to 10, found 0"),
        (lambda: sierpinski_triangle(koch()), "found the pieces .* 'edge', 'edge', 'edge'"),
        (lambda: sierpinski_triangle(b_spline(2)), "cannot be a side"),
        (lambda: sierpinski_triangle(nonuniform_b_spline(3, [0, 0, 1, 0, 0])), "cannot be a side"),
        (lambda: sierpinski_triangle(takagi(), float("inf")), "inner is a finite number"),
        (lambda: wall([(0, 0), (1, 0)]), "3 or more points"),
        (lambda: wall([(0, 0), (1, 1), (2, 0)]), "from .0, 0. to .1, 0."),
        (lambda: wall([(0, 0), (0.5, 0), (0.5, 0), (1, 0)]), "segment 1 .* found 0"),
        (lambda: wall([(0, 0), (0.5, 1), (1, 0)]), "segment 0 .* found 1.118"),
        (lambda: wall([(0, 0), (0.5, float("nan")), (1, 0)]), "y of point 1 is a finite"),
        (lambda: wall([(0, 0), (0.5,), (1, 0)]), "point 1 has x and y"),
    ],
)
def test_wrong_input_is_refused_with_its_numbers(make, words):
    with pytest.raises(ValueError, match=words):
        make()


def times(a, b):
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


WALLS = {
    "menger": [(0, 0), (1, 0), (1, 1), (2, 1), (2, 0), (3, 0)],
    "steps": [(0, 0), (6, 0), (6, 3), (12, 3), (12, 0)],
    "leaning": [(0, 0), (1, 4), (5, -2), (6, 1), (10, 0)],
    "arrow": [(0, 0), (3, 3), (6, 0)],
}


def exact_wall(name: str) -> list[tuple[Fraction, Fraction]]:
    length = WALLS[name][-1][0]
    return [(Fraction(x, length), Fraction(y, length)) for x, y in WALLS[name]]


@pytest.mark.parametrize("name", WALLS)
def test_walls_repeat_the_line_on_its_segments_exactly(name):
    line = exact_wall(name)
    automaton = menger_wall() if name == "menger" else wall(line)
    pieces, half = len(line) - 1, Fraction(1, 2)
    symmetric = all((1 - x, y) == back for (x, y), back in zip(line, reversed(line), strict=True))
    freedom = (2 * pieces - 1) * (1 if symmetric else 2)
    control = [(Fraction(0), Fraction(0)), (half, half), (Fraction(1), Fraction(0))]
    numbers = exact(automaton, freedom)["edge"]
    for k in range(pieces):
        step = (line[k + 1][0] - line[k][0], line[k + 1][1] - line[k][1])
        for j, point in enumerate(control):
            moved = times(step, point)
            found = [
                sum(row[j] * p[axis] for row, p in zip(numbers[str(k)], control, strict=True))
                for axis in (0, 1)
            ]
            assert found == [line[k][0] + moved[0], line[k][1] + moved[1]]
    for _ in range(2):
        line = [*replaced(line, exact_wall(name)), line[-1]]
    mesh = ifs.mesh(ifs.shape(automaton, control=np.array(control, dtype=float)), 3)
    assert len(mesh.vertices) == len(line) == pieces**3 + 1
    following = dict(mesh.faces.tolist())
    walk = [next(iter(set(following) - set(following.values())))]
    while walk[-1] in following:
        walk.append(following[walk[-1]])
    assert_close(mesh.vertices[walk], np.array(line, dtype=float))


def replaced(line, generator):
    """The points of a line, each segment replaced by the generator, but the last one."""
    for (x, y), (end_x, end_y) in pairwise(line):
        for point in generator[:-1]:
            dx, dy = times((end_x - x, end_y - y), point)
            yield x + dx, y + dy


def test_mengers_wall_has_its_dimension_and_touches_itself():
    assert similarity_dimension(ifs.shape(menger_wall())) == pytest.approx(log(5) / log(3))
    line = exact_wall("menger")
    second = [*replaced(line, line), line[-1]]
    assert (len(second), len(set(second))) == (26, 24)
