"""Smooth curves and curves of cut corners. Source: Gentil 2010, §4.3.1.

An edge is divided in two, and only the numbers of control points and the coefficients differ. d stands for
the degree, `T_0` and `T_1` for the operators of the edge; those of the vertices follow from them.
"""

from fractions import Fraction
from math import comb

from automata import Automaton
from subdivision.schemes.building import Amount, coefficients, edge, exact, scheme, vertex

MOST_DEGREE = 30


def bezier(degree: int) -> Automaton:
    """The Bezier curve of a degree d >= 1 by de Casteljau's halving: d + 1 points an edge, 1 a vertex.

    Column j of `T_0` is the middle point of the first j + 1 control points,
    `T_0[i,j] = C(j,i) / 2^j`; `T_1` is its mirror image. The constraints and the mirror leave
    `d(d-1) + floor(d/2)` degrees of freedom. Raises `ValueError` for a degree out of range.

    >>> import subdivision
    >>> subdivision.solve(bezier(3)).degrees_of_freedom
    7
    """
    degree = _degree(degree)
    halves = ("edge", "edge")
    columns = {j: [Fraction(comb(j, i), 2**j) for i in range(degree + 1)] for j in range(1, degree + 1)}
    cells = (edge(degree + 1, halves, mirror=True), vertex(1))
    return scheme(f"Bezier curve of degree {degree}", cells, coefficients("edge", "0", columns))


def b_spline(degree: int) -> Automaton:
    """The uniform B-spline of a degree d >= 1: d + 1 points an edge, d a vertex.

    `T_0[i,j] = C(d+1, 2i-j+1) / 2^d` and `T_1[i,j] = T_0[i,j+1]` continued. The constraints and the
    mirror leave `floor(d/2)` degrees of freedom. Neighbouring pieces share d
    control points. Raises `ValueError` for a degree out of range.

    >>> import subdivision
    >>> [[str(x) for x in row] for row in subdivision.solve(b_spline(2)).numbers()["edge"]["0"]]
    [['3/4', '1/4', '0'], ['1/4', '3/4', '3/4'], ['0', '0', '1/4']]
    """
    degree = _degree(degree)
    columns = {
        j: [Fraction(_binomial(degree + 1, 2 * i - j + 1), 2**degree) for i in range(degree + 1)]
        for j in range(degree + 1)
    }
    ends = ("vertex", degree)
    cells = (edge(degree + 1, ("edge", "edge"), ends, ends, mirror=True), vertex(degree, swap=True))
    return scheme(f"B-spline of degree {degree}", cells, coefficients("edge", "0", columns))


def corner_cutting(a: Amount, b: Amount) -> Automaton:
    """Corner cutting: every segment P Q gives the points `(1-a) P + a Q` and `b P + (1-b) Q`.

    3 points an edge, 2 a vertex; the 2 degrees of freedom are a and b. The curve exists where a, b and
    1 - a - b are between -1 and 1 and no product of operators grows; `a = b = 1/4` is Chaikin's.

    >>> from fractions import Fraction
    >>> corner_cutting(Fraction(1, 4), Fraction(1, 4)).values
    {'edge.0[1,0]': Fraction(1, 4), 'edge.0[0,1]': Fraction(1, 4)}
    """
    values = {"edge.0[1,0]": exact(a, "a"), "edge.0[0,1]": exact(b, "b")}
    ends = ("vertex", 2)
    cells = (edge(3, ("edge", "edge"), ends, ends), vertex(2))
    return scheme("Corner cutting", cells, values)


def de_rham(ratio: Amount) -> Automaton:
    """De Rham's curve: corner cutting that is the same from both ends, `a = b = ratio`.

    With the mirror 1 degree of freedom is left. De Rham's own curve has 1/3, Chaikin's 1/4.

    >>> from fractions import Fraction
    >>> import subdivision
    >>> subdivision.solve(de_rham(Fraction(1, 3))).degrees_of_freedom
    1
    """
    ends = ("vertex", 2)
    cells = (edge(3, ("edge", "edge"), ends, ends, mirror=True), vertex(2, swap=True))
    return scheme("De Rham curve", cells, {"edge.0[1,0]": exact(ratio, "the ratio")})


def _degree(degree: int) -> int:
    if not 1 <= degree <= MOST_DEGREE:
        raise ValueError(f"the degree is 1 to {MOST_DEGREE}, found {degree}")
    return degree


def _binomial(n: int, k: int) -> int:
    return comb(n, k) if k >= 0 else 0
