"""In which direction, and how fast, curves on a surface and edges of patches leave a point."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from fld.surfaces.modes import Control, Mode, apart, slowest, ways
from fld.surfaces.proofs import sign
from fld.surfaces.rings import Ring
from fld.wording import Status, canonical, number, power, written


@dataclass(frozen=True)
class Leaving:
    """How a curve leaves a point on one side; the words of `fld.HalfTangent`, for curves of any automaton.

    `status` is as in `fld.HalfTangent`. `direction` is a unit vector into the curve,
    `order` is `log|lambda| / log r` (None when constant, or when the parameter shrinks unequally),
    `eigenvalues` those of visible directions, largest modulus first, `block` the size m of the dominant
    Jordan block: distances shrink like `h^order log(1/h)^(m-1)`. `vector` is the limit of `difference /
    h^order` along the ends of the pieces, in mm per parameter^order, where there is a half-tangent and m = 1.
    """

    status: Status
    direction: Float[np.ndarray, "dim"] | None
    order: float | None
    eigenvalues: tuple[complex, ...]
    block: int
    vector: Float[np.ndarray, "dim"] | None
    words: str

    @property
    def size(self) -> float | None:
        """The length of `vector`: the limit in mm of `distance / h^order` along the ends of the pieces."""
        return None if self.vector is None else float(np.linalg.norm(self.vector))

    def as_data(self) -> dict[str, Any]:
        """The same as plain lists and numbers, ready for JSON; eigenvalues are `[real, imaginary]`."""
        return {
            "status": self.status,
            "direction": None if self.direction is None else [float(x) for x in self.direction],
            "order": self.order,
            "eigenvalues": [[value.real, value.imag] for value in self.eigenvalues],
            "block": self.block,
            "size": self.size,
            "words": self.words,
        }


def leaving(ring: Ring, control: Control, size: float | None = None) -> Leaving:
    """How the curve of a ring, drawn by some control points, leaves the ring's point.

    With a simple dominant eigenvalue lambda > 0, `p_k = c + M^k (p - c)` tends to c in the direction of its
    eigenvector, seen through the control points, on the side of the component of `p - c`. It is the
    half-tangent of the whole curve where that component has one sign on the whole ring, which is proven by
    boxes. `size` is that of the control points, in mm, where they are what is left of larger ones.
    Source: Gentil 2010, equation 4.5 and theorem 4.2.3; §4.4.2 for cells that become others.
    """
    mode = slowest(ring, control, size)
    if mode is None:
        return Leaving("constant", None, None, (), 0, None, "stays in this point: nothing visible moves it")
    status, vector, along = _verdict(ring, mode)
    spectrum = mode.spectrum
    order = order_of(ring, mode)
    direction = None if vector is None else vector / np.linalg.norm(vector)
    limit = None
    if vector is not None and status == "half-tangent" and spectrum.block == 1 and order is not None:
        limit = vector * abs(along) * math.exp(mode.scale - order * math.log(ring.reach))
    words = _words(ring, status, direction, order, mode, limit)
    return Leaving(status, direction, order, spectrum.eigenvalues, spectrum.block, limit, words)


def order_of(ring: Ring, mode: Mode) -> float | None:
    """`log|lambda| / log r`; None where the parameter shrinks unequally."""
    if not ring.ratio < 1:
        return None
    return math.log(mode.spectrum.modulus) / math.log(ring.ratio)


def _verdict(ring: Ring, mode: Mode) -> tuple[Status, Float[np.ndarray, "dim"] | None, float]:
    """The status, a vector in its direction, and the component of the far end along that vector."""
    values, ranks = mode.spectrum.values, mode.spectrum.ranks
    value = values[0]
    if sum(ranks) > 1 and len(values) == 1:
        return "several directions", None, 0.0
    if len(values) == 2 and ranks == (1, 1) and value.imag != 0 and mode.spanning == 2:
        return "spiral", None, 0.0
    if len(values) > 1:
        return "oscillates", None, 0.0
    vector, row = mode.vectors[0], mode.rows[0]
    along = float(row @ (ring.far - ring.point))
    if value.real < 0:
        return "unoriented", canonical(vector), along
    found = sign(ring, row)
    if found == 0:
        return "oscillates", canonical(vector), along
    if found is None:
        return "undecided", vector * (1 if along >= 0 else -1), along
    return "half-tangent", vector * found, along


def rate(order: float | None, mode: Mode) -> str:
    """How distances shrink, to read: `h^1.2 log(1/h)`, or by which factor where no order is known."""
    if order is None:
        return f"shrinking by {mode.spectrum.modulus:.6g} a step"
    return power(order, mode.spectrum.block - 1)


def turning(mode: Mode) -> str:
    """What a complex pair does at each step, to read."""
    value = mode.spectrum.values[0]
    turn = math.degrees(abs(math.atan2(value.imag, value.real)))
    return f"turning by {turn:.6g} degrees and shrinking by {abs(value):.6g} at each step"


def _words(
    ring: Ring,
    status: Status,
    direction: Float[np.ndarray, "dim"] | None,
    order: float | None,
    mode: Mode,
    limit: Float[np.ndarray, "dim"] | None,
) -> str:
    spectrum = mode.spectrum
    vector = "" if direction is None else written(direction)
    distance = rate(order, mode)
    if limit is not None:
        distance = f"{np.linalg.norm(limit):.6g} mm {distance}"
    if status == "half-tangent":
        said = f"leaves in the direction {vector}"
    elif status == "undecided":
        said = f"leaves in the direction {vector} along the ends of its pieces; the rest is undecided"
    elif status == "oscillates" and vector:
        said = f"oscillates between {vector} and its opposite: it has points on both sides"
    elif status == "oscillates":
        values = ", ".join(map(number, spectrum.values))
        said = f"oscillates and keeps no direction (eigenvalues {values} of equal modulus)"
        turns = np.linalg.norm(mode.matrix @ mode.matrix - spectrum.modulus**2 * np.eye(len(mode.matrix)))
        if turns <= 1e-9 * spectrum.modulus**2:
            part = mode.rows @ (ring.far - ring.point)
            ends = [part @ mode.vectors, mode.matrix @ part @ mode.vectors]
            said = (
                "oscillates between "
                + " and ".join(written(end / max(float(np.linalg.norm(end)), 1e-300)) for end in ends)
                + f" along the ends of the pieces (eigenvalues {values} of equal modulus)"
            )
    elif status == "unoriented":
        said = f"swings between {vector} and its opposite (eigenvalue {spectrum.values[0].real:.6g})"
    elif status == "spiral":
        said = f"spirals, {turning(mode)}"
    else:
        said = (
            f"has no half-tangent: the eigenvalue {spectrum.values[0].real:.6g} has {sum(spectrum.ranks)} "
            f"independent directions, and each part keeps its own"
        )
        found = ways(ring, mode)
        if found is not None:
            i, j, angle = apart(found)
            said += f", such as {written(found[i])} and {written(found[j])}, {angle:.6g} degrees apart"
    return f"{said}; its distance is like {distance}"
