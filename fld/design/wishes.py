"""What can be asked of the behaviour of a member: requests for `subdivision.choose`."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from subdivision.eigen import left_vector, rest, spectral_radius
from subdivision.error import WrongValue
from subdivision.member import Array, Family, Member, differences

_STRICT = 1e-6
_LEAST = 1e-3

Word = tuple[str, ...]


@dataclass(frozen=True)
class CriticalOrder:
    """The critical order of a curve: `sum |lambda_i|^(1/order) = 1`, lambda_i the dominant eigenvalues.

    They are those on all differences of control points; `fld.critical_order` leaves out what the drawn curve
    does not show. Source: Gentil 2010, equation 4.4.
    """

    cell: str
    labels: Word
    order: float

    @property
    def text(self) -> str:
        return f"critical order {self.order:.12g}"

    def check(self, family: Family) -> None:
        for label in self.labels:
            family.require_loop(self.cell, (label,))

    def guess(self, member: Member, start: int) -> Array:
        return np.zeros(0)

    def equations(self, member: Member, z: Array) -> Array:
        xp = member.xp
        moduli = [spectral_radius(member.linear(self.cell, (label,)), xp) for label in self.labels]
        total: Any = sum(modulus ** (1 / self.order) for modulus in moduli)
        return xp.reshape(total - 1, (1,))

    def margins(self, member: Member, z: Array) -> Array:
        return member.xp.zeros(0)


@dataclass(frozen=True)
class Leaves:
    """A half-tangent: on one side of the point `word repeat^omega` the curve leaves in a direction.

    The unknowns are the eigenvalue mu and the eigenvector v of the linear part of T_u, v as coordinates on
    `subdivision.member.differences` D:

        L_u v = mu v,   P T_w D v = direction,

    with the control points P. Margins: mu is above 0 and above the moduli of all other eigenvalues, and the
    far end of the curve, `far`, has a component above 0 along v. That all the curve has one is for
    `fld.behaviour` to prove. Source: Gentil 2010, equations 4.5, 4.7 and 4.8, theorem 4.2.3.
    """

    cell: str
    word: Word
    repeat: Word
    far: str
    direction: tuple[float, ...]
    control: tuple[tuple[float, ...], ...]
    side: str

    @property
    def text(self) -> str:
        vector = ", ".join(f"{x:.6g}" for x in self.direction)
        return f"half-tangent ({vector}) on the {self.side}"

    def check(self, family: Family) -> None:
        family.require_loop(self.cell, self.repeat)
        if len(self.direction) != len(self.control[0]):
            raise WrongValue(
                f"{self.text}: the control points have {len(self.control[0])} coordinates, the direction "
                f"{len(self.direction)}"
            )

    def guess(self, member: Member, start: int) -> Array:
        found = np.linalg.eig(member.linear(self.cell, self.repeat))
        values, vectors = np.asarray(found[0], complex), np.asarray(found[1], complex)
        real = np.flatnonzero(np.abs(np.imag(values)) <= 1e-9 * np.abs(values).max(initial=1e-300))
        if not len(real):
            vector = np.real(vectors[:, np.abs(values).argmax()])
            value = float(np.abs(values).max())
        else:
            order = real[np.argsort(-np.real(values[real]))]
            chosen = order[start // 4 % len(order)]
            value, vector = float(np.real(values[chosen])), np.real(vectors[:, chosen])
        drawn = self._drawn(member) @ vector
        along = float(drawn @ np.array(self.direction))
        size = np.copysign(max(abs(along), 0.1 * float(np.linalg.norm(drawn)), 1e-9), along or 1.0)
        return np.concatenate([[value], vector / size])

    def equations(self, member: Member, z: Array) -> Array:
        linear = member.linear(self.cell, self.repeat)
        drawn = self._drawn(member) @ z[1:]
        return member.xp.concatenate([linear @ z[1:] - z[0] * z[1:], drawn - np.array(self.direction)])

    def margins(self, member: Member, z: Array) -> Array:
        xp = member.xp
        linear = member.linear(self.cell, self.repeat)
        size = xp.sqrt(z[1:] @ z[1:])
        unit = z[1:] / size
        others = spectral_radius(rest(linear, unit[:, None], xp), xp)
        away = member.fixed_point(self.cell, (self.far,)) - member.fixed_point(self.cell, self.repeat)
        dual = left_vector(linear, z[0], unit, xp)
        along = dual @ differences(member.family.points(self.cell)).T @ away
        return xp.stack([z[0] - _LEAST, z[0] - others - _STRICT, along - _LEAST])

    def _drawn(self, member: Member) -> Float[np.ndarray, "dim directions"] | Any:
        """P T_w D: what coordinates of a difference draw, in mm."""
        size = member.family.points(self.cell)
        return np.array(self.control).T @ member.product(self.cell, self.word) @ differences(size)
