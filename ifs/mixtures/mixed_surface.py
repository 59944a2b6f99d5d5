"""A quadrangular surface between four prescribed curves, each smooth or fractal in its own way.

Source: Gentil 2010, §5.1.4, figures 5.14 to 5.16: the four tensor products of two opposite curves with the
two others are blended by the bilinear functions of (u, v).
"""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float, Real

from automata import Automaton
from ifs.mixtures.parallel import given, times, together
from ifs.shape import Shape
from subdivision.schemes import bezier, tensor

_MEET = 1e-9


class BordersApart(ValueError):
    """Two prescribed borders that do not meet in their corner; `gap` is in mm."""

    def __init__(self, corner: str, ends: tuple[np.ndarray, np.ndarray], gap: float):
        self.corner = corner
        self.ends = ends
        self.gap = gap
        first, second = (end.tolist() for end in ends)
        super().__init__(
            f"the borders do not meet at {corner}: {first} and {second} are {gap:.3g} mm apart. Move the "
            "control points that these curves end in"
        )


def between(
    bottom: Shape,
    top: Shape,
    left: Shape,
    right: Shape,
    blend: Automaton | None = None,
    toward: Real[np.ndarray, "_points"] | None = None,
) -> Shape:
    """The surface whose borders are four curves: `bottom` and `top` run along u, `left` and `right` along v.

    With h(t) from 0 to 1 the share of the far side, c_00 … c_11 the corners, and k, l over the two sides,

        `S(u,v) = sum_kl beta_k(v) beta_l(u) (K(u) + L(v) - c_kl)`,    `beta = (1 - h, h)`,

    the mixture of the four surfaces that move one border along another. Since the weights sum to 1 it is
    Coons' patch, `beta · (bottom, top)(u) + beta · (left, right)(v)` less the blended corners (the source
    does not say so). The blend is `h = sum_j toward_j b_j`, b the basis functions of a curve (linear unless
    given): `bezier(3)` with `toward = [0, 0, 1, 1]` is Hermite's `3t^2 - 2t^3`. The source blends `T^0 = a ⊗
    b` by st where a and b meet in (1, 1); here (0, 0) is where `bottom` and `left` begin.

    Opposite curves, and the blend, must be glued alike, and vertices hold 1 control point. Control points in
    mm. Raises `DifferentGluing`, `BordersApart`, and `ValueError` for curves whose vertices hold more points,
    for over 400 control points and for a blend that does not go from 0 to 1.

    >>> import ifs, numpy as np
    >>> from subdivision.schemes import bezier, takagi
    >>> def side(curve, *points): return ifs.shape(curve, control=np.array(points))
    >>> surface = between(
    ...     side(bezier(2), (0, 0, 0), (20, 0, 20), (40, 0, 0)),
    ...     side(takagi(), (0, 40, 0), (20, 40, 20), (40, 40, 0)),
    ...     side(bezier(1), (0, 0, 0), (0, 40, 0)),
    ...     side(takagi(), (40, 0, 0), (40, 20, 9), (40, 40, 0)),
    ... )
    >>> ifs.mesh(surface, 3).vertices.shape
    (81, 3)
    """
    curve = bezier(1) if blend is None else blend
    share = _share(curve, toward)
    pairs = ((bottom, top), (left, right))
    for one in (bottom, top, left, right):
        _require_ends(one.automaton, "a border")
    _require_ends(curve, "a blend")
    _require_corners(bottom, top, left, right)
    sides = [together(first.automaton, second.automaton) for first, second in pairs]
    axes = [times(curve, side.automaton) for side in sides]
    surface = tensor(axes[0].automaton, axes[1].automaton)
    u, v = (
        _along(pair, side.points, axis.points, share)
        for pair, side, axis in zip(pairs, sides, axes, strict=True)
    )
    corners = np.stack([np.stack([one.control[0], one.control[-1]]) for one in pairs[0]])
    inner = np.einsum("kv,lu,kld->uvd", v[1], u[1], corners)
    control = np.einsum("kud,kv->uvd", u[0], v[1]) + np.einsum("lvd,lu->uvd", v[0], u[1]) - inner
    return given(surface, control.reshape(-1, control.shape[2]))


def _along(
    pair: tuple[Shape, Shape],
    numbers: Sequence[tuple[int, ...]],
    points: Sequence[tuple[int, ...]],
    share: Float[np.ndarray, "blend"],
) -> tuple[Float[np.ndarray, "2 points dim"], Float[np.ndarray, "2 points"]]:
    """Both curves, and both weights, at every control point of an axis."""
    chosen, stairs = np.array(points).T
    table = np.array(numbers)[stairs]
    curves = np.stack([one.control[table[:, k]] for k, one in enumerate(pair)])
    return curves, np.stack([1 - share[chosen], share[chosen]])


def _share(blend: Automaton, toward: np.ndarray | None) -> np.ndarray:
    points = blend.cells[blend.shape].points
    share = np.linspace(0, 1, points) if toward is None else np.array(toward, dtype=float)
    if share.shape != (points,) or share[0] != 0 or share[-1] != 1:
        raise ValueError(f"expected {points} shares from 0 to 1, found {share.tolist()}")
    return share


def _require_ends(automaton: Automaton, what: str) -> None:
    ends = automaton.cells[automaton.shape].boundary
    held = {label: automaton.cells[end.cell].points for label, end in ends.items()}
    if held != {"left": 1, "right": 1}:
        raise ValueError(f"{what} runs from a vertex 'left' of 1 control point to such a one 'right'; "
                         f"{automaton.name!r} has {held}")  # fmt: skip


def _require_corners(bottom: Shape, top: Shape, left: Shape, right: Shape) -> None:
    size = max(float(np.abs(one.control).max()) for one in (bottom, top, left, right))
    for name, end, other in (
        ("(0, 0), the first points of bottom and left", bottom.control[0], left.control[0]),
        ("(1, 0), the last point of bottom and the first of right", bottom.control[-1], right.control[0]),
        ("(0, 1), the first point of top and the last of left", top.control[0], left.control[-1]),
        ("(1, 1), the last points of top and right", top.control[-1], right.control[-1]),
    ):
        if end.shape != other.shape:
            raise ValueError(
                f"the borders have different dimensions at {name}: {end.shape} and {other.shape}"
            )
        gap = float(np.linalg.norm(end - other))
        if not gap <= _MEET * size:
            raise BordersApart(name, (end, other), gap)
