"""Curves over the interval: the morphism from `tau_i(t) = r_i t + t_i` to the system of a curve."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Float, Real

from ifs.certificates.convergence import require_contraction
from ifs.certificates.differences import spectral_radius
from ifs.dimensions.flats import affine_maps
from ifs.dimensions.order import ratios as ordered_ratios
from ifs.dimensions.spans import spanning_points
from ifs.measures.chains import NoChain, chains
from ifs.measures.operators import Number
from ifs.shape import Shape

_ONE = 1e-12
_STEPS = 2000
_STILL = 1e-15


class WrongRatios(ValueError):
    """Parts of the interval that do not fit a curve: not one a piece, not positive, or a sum other than 1."""


@dataclass(frozen=True)
class Parametrisation:
    """`tau_i(t) = r_i t + t_i` with `t_i = r_0 + … + r_(i-1)`: which part of [0, 1] each sub-piece takes.

    `labels` are in the order along the curve; `ratios[k]` is r of label k. Source: Gentil 2010, 4.2.
    """

    labels: tuple[str, ...]
    ratios: tuple[Number, ...]

    @property
    def starts(self) -> tuple[Number, ...]:
        """The t_i."""
        result: list[Number] = [Fraction(0)]
        for ratio in self.ratios[:-1]:
            result.append(result[-1] + ratio)
        return tuple(result)

    def address(self, t: Number, letters: int = 32) -> tuple[str, ...]:
        """The first letters of the address of a parameter in [0, 1]; at a joint those of the piece behind it.

        Exact when t and the ratios are Fractions. Raises `ValueError` for a parameter outside [0, 1].

        >>> Parametrisation(("0", "1"), (Fraction(1, 2), Fraction(1, 2))).address(Fraction(5, 8), 4)
        ('1', '0', '1', '0')
        """
        if not 0 <= t <= 1:
            raise ValueError(f"a parameter lies in [0, 1]; got {t}")
        starts, word = self.starts, []
        for _ in range(letters):
            k = max(i for i, start in enumerate(starts) if start <= t)
            word.append(self.labels[k])
            t = min(max((t - starts[k]) / self.ratios[k], 0), 1)
        return tuple(word)

    def parameter(self, word: Sequence[str], repeat: Sequence[str] = ()) -> Number:
        """The parameter of the address `word`, then `repeat` for ever; by default the first label for ever.

        `tau_w` is `t -> r t + s`, and the repeated part has the fixed point `s / (1 - r)`. Raises
        `ValueError` for an unknown label.

        >>> halves = Parametrisation(("0", "1"), (Fraction(1, 2), Fraction(1, 2)))
        >>> str(halves.parameter(("0",), ("1",))), str(halves.parameter((), ("0", "1")))
        ('1/2', '1/3')
        """
        scale, shift = self._composed(repeat or self.labels[:1])
        point = shift / (1 - scale)
        scale, shift = self._composed(word)
        return scale * point + shift

    def at(self, shape: Shape, t: Real[np.ndarray, "n"]) -> Float[np.ndarray, "n _dim"]:
        """The points, in mm, of a curve with these labels at parameters in [0, 1].

        The digits of a parameter choose the pieces until these are smaller than 1e-15 of the control points.
        Raises `ValueError` for labels that are not the curve's or parameters outside [0, 1].

        >>> from ifs.shape import shape
        >>> koch = shape("koch-curve")
        >>> parametrisation(koch).at(koch, np.array([0.0, 0.25, 1.0])).round(6).tolist()
        [[0.0, 0.0], [30.0, 0.0], [90.0, 0.0]]
        """
        if _order(shape) != self.labels:
            raise ValueError(
                f"the curve runs through {_order(shape)}, the parametrisation through {self.labels}"
            )
        rest = np.asarray(t, dtype=float)
        if not ((rest >= 0) & (rest <= 1)).all():
            wrong = int(np.flatnonzero(~((rest >= 0) & (rest <= 1)))[0])
            raise ValueError(f"parameter {wrong} must lie in [0, 1]; got {rest[wrong]}")
        state = shape.system.states[shape.system.shape]
        operators = np.stack([state.operators[state.labels.index(label)].T for label in self.labels])
        starts = np.array([float(x) for x in self.starts])
        parts = np.array([float(x) for x in self.ratios])
        column = spanning_points(shape.system)[state.name][:, 0]
        control = np.repeat(shape.control[None], len(rest), axis=0)
        small = _STILL * float(np.ptp(shape.control, axis=0).max())
        for _ in range(_STEPS):
            digits = np.searchsorted(starts, rest, side="right") - 1
            control = operators[digits] @ control
            rest = np.clip((rest - starts[digits]) / parts[digits], 0.0, 1.0)
            if np.ptp(control, axis=1).max(initial=0.0) <= small:
                break
        return np.einsum("p,npd->nd", column, control)

    def _composed(self, word: Sequence[str]) -> tuple[Number, Number]:
        scale: Number = Fraction(1)
        shift: Number = Fraction(0)
        starts = dict(zip(self.labels, self.starts, strict=True))
        parts = dict(zip(self.labels, self.ratios, strict=True))
        for label in word:
            if label not in parts:
                raise ValueError(f"unknown label {label!r}; the labels are {', '.join(self.labels)}")
            shift = shift + scale * starts[label]
            scale = scale * parts[label]
        return scale, shift


def parametrisation(shape: Shape, ratios: Mapping[str, Number] | None = None) -> Parametrisation:
    """The parametrisation of a curve that is cut into copies of itself.

    By default `r_i = |lambda_i|^(1/alpha)`, with lambda_i the eigenvalue of largest modulus of the linear
    part of piece i on the span of the attractor, and alpha the critical order (`order`). With given
    ratios, one for each label, these. Raises `NoChain` for what is no such curve, `WrongRatios`, `ValueError`
    where a default lambda_i is 0, `NotContracting` or `Undecided`. Source: Gentil 2010, theorem 4.2.1.

    >>> from ifs.shape import shape
    >>> [round(float(r), 12) for r in parametrisation(shape("koch-curve")).ratios]
    [0.25, 0.25, 0.25, 0.25]
    """
    require_contraction(shape.system)
    labels = _order(shape)
    if ratios is None:
        ratios = _default(shape, labels)
    odd = sorted(set(ratios) ^ set(labels))
    if odd:
        raise WrongRatios(f"one ratio for each of {', '.join(labels)} is needed; wrong: {', '.join(odd)}")
    for label in labels:
        if not ratios[label] > 0:
            raise WrongRatios(f"the ratio of {label!r} must be above 0; got {ratios[label]}")
    total = sum(ratios[label] for label in labels)
    if abs(total - 1) > _ONE:
        raise WrongRatios(f"the ratios must sum to 1; they sum to {total}")
    return Parametrisation(labels, tuple(ratios[label] for label in labels))


def _order(shape: Shape) -> tuple[str, ...]:
    found = chains(shape)
    links = found[shape.automaton.shape].links
    if len(found) > 1 or not all(forward for _, forward in links):
        raise NoChain(
            f"cell {shape.automaton.shape!r} is not cut into copies of itself that all run forwards"
        )
    return tuple(label for label, _ in links)


def _default(shape: Shape, labels: tuple[str, ...]) -> dict[str, Number]:
    state = shape.system.states[shape.system.shape]
    flats = affine_maps(shape)
    if flats is not None and flats.dimension:
        moduli = {label: spectral_radius(flats.maps[state.name][label].linear) for label in labels}
    else:
        columns = spanning_points(shape.system)[state.name]
        basis = np.linalg.qr(columns[:, 1:] - columns[:, :1])[0]
        moduli = {
            label: spectral_radius(basis.T @ state.operators[state.labels.index(label)] @ basis)
            for label in labels
        }
    for label, modulus in moduli.items():
        if not modulus > 1e-12:
            raise ValueError(
                f"piece {label!r} has no eigenvalue other than 0: give ratios for the parametrisation"
            )
    return dict(ordered_ratios(moduli))
