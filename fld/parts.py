"""Parametrisations of a curve: which part of the interval [0, 1] each sub-cell takes."""

import math
from collections.abc import Mapping
from numbers import Real

from fld.address import Address
from fld.curve import Curve
from fld.order import dominant_moduli, ratios

Chosen = str | Mapping[str, Real]
"""`"natural"`, `"uniform"`, or the part of each label."""

_ONE = 1e-12


class WrongParts(ValueError):
    """Parts of the interval that are no parametrisation: a label without part, a part not above 0, a sum
    other than 1."""


def chosen(curve: Curve, parametrisation: Chosen = "natural") -> dict[str, float]:
    """The parts r_i of [0, 1], by label in the order along the curve; they sum to 1.

    "natural" is `r_i = |lambda_i|^(1/alpha)` with the critical order alpha (equation 4.4), "uniform" is 1/N;
    a mapping gives the part of each label. Raises `WrongParts`, and for "natural" what `critical_order`
    raises.

    >>> import ifs
    >>> from fld.curve import curve
    >>> chosen(curve(ifs.shape("koch-curve")), "uniform")["3"]
    0.25
    """
    if isinstance(parametrisation, str):
        if parametrisation == "natural":
            return ratios(dominant_moduli(curve))
        if parametrisation == "uniform":
            return dict.fromkeys(curve.labels, 1 / len(curve.labels))
        raise WrongParts(
            f"the parametrisation is 'natural', 'uniform', or one part for each of "
            f"{', '.join(curve.labels)}; found {parametrisation!r}"
        )
    odd = sorted(set(parametrisation) ^ set(curve.labels))
    if odd:
        raise WrongParts(f"one part for each of {', '.join(curve.labels)} is needed; wrong: {', '.join(odd)}")
    parts = {label: float(parametrisation[label]) for label in curve.labels}
    for label, part in parts.items():
        if not 0 < part < 1:
            raise WrongParts(f"the part of {label!r} must lie between 0 and 1; found {part}")
    total = math.fsum(parts.values())
    if abs(total - 1) > _ONE:
        raise WrongParts(f"the parts must sum to 1; they sum to {total}")
    return parts


def starts(parts: Mapping[str, float]) -> dict[str, float]:
    """Where each part begins: t_i, the sum of the parts before it."""
    found, start = {}, 0.0
    for label, part in parts.items():
        found[label] = start
        start += part
    return found


def parameter(curve: Curve, parts: Mapping[str, float], address: Address) -> float:
    """The place in [0, 1] of an address under `tau_i(t) = r_i t + t_i`.

    The repeated word u is `t -> r_u t + s` with the fixed point `s / (1 - r_u)`.
    """
    begin = starts(parts)
    scale, shift = 1.0, 0.0
    for label in reversed(address.repeat):
        shift = begin[label] + parts[label] * shift
        scale *= parts[label]
    place = 1.0 if address.repeat == (curve.labels[-1],) else shift / (1 - scale)
    for label in reversed(address.word):
        place = begin[label] + parts[label] * place
    return place
