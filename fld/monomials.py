"""Powers of the parameter as coordinates of a curve: where a curve is polynomial, exactly."""

from collections.abc import Mapping
from math import comb

import numpy as np
from jaxtyping import Float

from fld.curve import Curve, fixed_point
from fld.directions import spanned
from fld.parts import starts
from fld.pieces import Pieces

_EXACT = 1e-9

Frame = Float[np.ndarray, "points coordinates"]


def frame(curve: Curve) -> Frame:
    """A point of the attractor and the directions that the attractor spans, as columns.

    A row x is known on the attractor by `x @ frame`.
    """
    return np.column_stack([fixed_point(curve.operators[0]), spanned(curve).T])


def monomials(
    curve: Curve, parts: Mapping[str, float], degree: int
) -> Float[np.ndarray, "powers coordinates"]:
    """Rows e_m, on the frame, with `e_m p(t) = t^m` on the curve, for m = 0, 1, … as far as they exist.

    They exist when the points `p(t)` of the attractor, `p(tau_j t) = T_j p(t)`, tell t^m, so when
    `e_m T_j = (r_j e + t_j)^m` with e^b read as e_b: linear equations in e_m, one solution at most. A
    Bezier curve of degree d has those up to d. Solved by least squares; a relative residual above 1e-9 says
    no.

    >>> import ifs
    >>> from fld.curve import curve
    >>> len(monomials(curve(ifs.shape("corner-cutting")), {"0": 0.5, "1": 0.5}, 3))
    3
    """
    own = frame(curve)
    start, basis = own[:, 0], own[:, 1:].T
    begin = starts(parts)
    found = [np.concatenate([[1.0], np.zeros(len(basis))])]
    images = [np.column_stack([operator @ start - start, operator @ basis.T]) for operator in curve.operators]
    maps = [basis @ image for image in images]
    for power in range(1, degree + 1):
        left, right = [], []
        for label, image in zip(curve.labels, maps, strict=True):
            ratio, shift = parts[label], begin[label]
            known = sum(comb(power, b) * ratio**b * shift ** (power - b) * found[b] for b in range(power))
            fixed = np.column_stack([np.zeros(len(basis)), np.eye(len(basis))])
            left.append((image - ratio**power * fixed).T)
            right.append(known)
        system, wanted = np.vstack(left), np.concatenate(right)
        row = np.linalg.lstsq(system, wanted, rcond=None)[0]
        if np.linalg.norm(system @ row - wanted) > _EXACT * (np.linalg.norm(wanted) + np.linalg.norm(row)):
            break
        found.append(np.concatenate([[0.0], row]))
    return np.array(found)


def is_power(pieces: Pieces, degree: int, vector: Float[np.ndarray, "dim"]) -> bool:
    """Whether every point of the pieces is `vector * s^degree`, s its distance in parameter."""
    own = frame(pieces.curve)
    powers = monomials(pieces.curve, pieces.parts, degree)
    if len(powers) <= degree:
        return False
    values = pieces.matrices @ own
    wanted = np.zeros(values.shape)
    for b in range(degree + 1):
        factors = comb(degree, b) * pieces.offsets ** (degree - b) * pieces.sizes**b
        wanted += factors[:, None, None] * vector[None, :, None] * powers[b]
    return bool(np.linalg.norm(values - wanted) <= _EXACT * np.linalg.norm(values))
