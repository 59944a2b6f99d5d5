"""C1 joints of curves: the half-tangents of two pieces that meet, for all control points."""

from collections.abc import Iterator
from dataclasses import dataclass
from numbers import Rational
from typing import Any

from automata import Automaton, Cell
from automata.automaton import Word
from subdivision.eigen import left_vector, rest, spectral_radius
from subdivision.error import WrongValue
from subdivision.member import Array, Family, Member, differences


@dataclass(frozen=True)
class End:
    """The limit point `prefix cycle cycle cycle …` of a cell."""

    prefix: Word
    cycle: Word


@dataclass(frozen=True)
class Side:
    """One of the two pieces that meet: its end at the joint, and its other end, as seen from the whole cell.

    The prefix of `far` begins with that of `joint`.
    """

    joint: End
    far: End


@dataclass(frozen=True)
class SmoothJoint:
    """Two pieces of a curve meet with one tangent, whatever the control points.

    At the end `prefix cycle^omega` of a piece, with P the product of the prefix and L the linear part of the
    cycle, the curve leaves along `P u`, u the eigenvector of the dominant eigenvalue of L. The two pieces
    have a common tangent for all control points exactly when these vectors of the barycentric space are
    opposite. The unknowns u, lambda (of each side) and kappa satisfy

        L u = lambda u,  |u| = 1,  P_l u_l + kappa P_r u_r = 0,

    lambda is real, simple and dominant: `margin <= lambda <= 1 - margin` and
    `(1 + margin) |mu| <= lambda` for every other eigenvalue mu; and the direction is kept:
    `kappa s_l s_r >= margin`, where s = w (far - joint) is the component along u of the piece's other end, w
    the left eigenvector with w u = 1. A cusp has kappa s_l s_r < 0.

    This is necessary for C1, at this joint and at all its images. It is written for cells whose dominant
    eigenvalue on all differences of points is simple: curves, not the edges of a surface, whose vertices
    have two tangent directions. Source: Gentil 2010, section 4.3.1; the text of its conclusion has the
    inequalities 1 - 2a - b < 0 and 1 - a - 2b < 0 reversed: 1 - a - b dominates where both are > 0. Besides
    that region the request also admits the lines a = 0, b = 0 and a + b = 1, where an operator is singular
    and the curve a segment: the four points q_0 … q_3 of the source depend on three control points.
    """

    cell: str
    left: Side
    right: Side
    margin: Rational | float = 1e-3

    @property
    def text(self) -> str:
        words = (" ".join(side.joint.prefix) for side in (self.left, self.right))
        return f"smooth joint of {self.cell} between {' and '.join(words)}"

    def check(self, family: Family) -> None:
        """Raises `WrongValue` for words that do not compose or return, or for ends of other pieces."""
        for side in (self.left, self.right):
            for end in (side.joint, side.far):
                family.require_loop(family.end(self.cell, end.prefix), end.cycle)
            if side.far.prefix[: len(side.joint.prefix)] != side.joint.prefix:
                raise WrongValue(f"{self.text}: {side.far} is no end of the piece {side.joint.prefix}")
            if family.points(family.end(self.cell, side.joint.prefix)) < 2:
                raise WrongValue(f"{self.text}: a piece of one point has no tangent")

    def guess(self, member: Member, start: int) -> Array:
        import numpy as np

        parts, vectors = [], []
        for side in (self.left, self.right):
            value, vector = _eigenpair(member.linear(self._piece(member, side), side.joint.cycle), start)
            parts.append(np.array([*vector, value]))
            vectors.append(self._direction(member, side, vector))
        size = vectors[1] @ vectors[1]
        ratio = -(vectors[0] @ vectors[1]) / size if size > 1e-12 else 1.0
        return np.concatenate([*parts, [ratio if abs(ratio) > 1e-3 else 1.0]])

    def equations(self, member: Member, z: Array) -> Array:
        xp = member.xp
        parts, sides = [], self._sides(member, z)
        for side, value, vector in sides:
            linear = member.linear(self._piece(member, side), side.joint.cycle)
            parts += [linear @ vector - value * vector, (vector @ vector - 1).reshape(1)]
        left, right = (self._direction(member, side, vector) for side, _, vector in sides)
        return xp.concatenate([*parts, left + z[-1] * right])

    def margins(self, member: Member, z: Array) -> Array:
        xp, margin = member.xp, float(self.margin)
        found, direction = [], z[-1]
        for side, value, vector in self._sides(member, z):
            piece = self._piece(member, side)
            linear = member.linear(piece, side.joint.cycle)
            others = spectral_radius(rest(linear, vector[:, None], xp), xp)
            found += [value - margin, 1 - margin - value, value - (1 + margin) * others]
            tail = side.far.prefix[len(side.joint.prefix) :]
            far = member.product(piece, tail) @ member.fixed_point(
                member.family.end(piece, tail), side.far.cycle
            )
            here = member.fixed_point(piece, side.joint.cycle)
            along = differences(member.family.points(piece)).T @ (far - here)
            direction = direction * (left_vector(linear, value, vector, xp) @ along)
        return xp.stack([*found, direction - margin])

    def _sides(self, member: Member, z: Array) -> list[tuple[Side, Any, Array]]:
        place, result = 0, []
        for side in (self.left, self.right):
            size = member.family.points(self._piece(member, side)) - 1
            result.append((side, z[place + size], z[place : place + size]))
            place += size + 1
        return result

    def _piece(self, member: Member, side: Side) -> str:
        return member.family.end(self.cell, side.joint.prefix)

    def _direction(self, member: Member, side: Side, vector: Array) -> Array:
        basis = differences(member.family.points(self._piece(member, side)))
        return member.product(self.cell, side.joint.prefix) @ (basis @ vector)


def _eigenpair(matrix: Array, start: int) -> tuple[float, Array]:
    """A real eigenpair: the dominant one for start 0, others in turn for other starts."""
    import numpy as np

    values, vectors = np.linalg.eig(matrix)
    order = [int(k) for k in np.argsort(-np.abs(values), kind="stable")]
    real = [k for k in order if abs(np.imag(values[k])) < 1e-9] or order
    chosen = real[start % len(real)]
    vector = np.real(vectors[:, chosen])
    return float(np.real(values[chosen])), vector / np.linalg.norm(vector)


def smooth_joints(automaton: Automaton, margin: Rational | float = 1e-3) -> tuple[SmoothJoint, ...]:
    """The joints of all curves of an automaton: a `SmoothJoint` for every adjacency between sub-cells.

    A curve is a cell with two boundary cells that each have one sub-cell. The ends of its pieces are read
    from the incidence equations. Raises `WrongValue` where no joint is found.

    >>> import automata
    >>> for joint in smooth_joints(automata.read("corner-cutting")):
    ...     print(joint.text, joint.left.joint)
    smooth joint of edge between 0 and 1 End(prefix=('0',), cycle=('1',))
    """
    found = [
        SmoothJoint(cell.name, sides[0], sides[1], margin)
        for name in automaton.reachable()
        if _is_curve(automaton, cell := automaton.cells[name])
        for equation in cell.adjacency
        if (sides := _sides(automaton, cell, equation.left, equation.right))
    ]
    if not found:
        raise WrongValue(
            "no joints of curves: expected a cell with two boundary cells that have one sub-cell each, "
            "with incidence and adjacency equations"
        )
    return tuple(found)


def _is_curve(automaton: Automaton, cell: Cell) -> bool:
    ends = [automaton.cells[boundary.cell] for boundary in cell.boundary.values()]
    return len(ends) == 2 and all(len(end.subdivision) == 1 for end in ends)


def _sides(automaton: Automaton, cell: Cell, *words: Word) -> list[Side] | None:
    sides = []
    for word in words:
        split = next(
            (k for k, label in enumerate(word) if _is_boundary(automaton, cell.name, word[:k], label)), 0
        )
        piece = automaton.end(cell.name, word[:split])
        others = [label for label in automaton.cells[piece].boundary if label != word[split]]
        joint = _end(automaton, piece, word[split])
        if split == 0 or joint is None or len(others) != 1:
            return None
        prefix = word[:split] + joint.prefix
        inner = automaton.end(cell.name, prefix)
        boundary = _boundary_after(automaton, piece, word[split], len(joint.prefix))
        far = next(
            (_end(automaton, inner, label) for label in automaton.cells[inner].boundary if label != boundary),
            None,
        )
        if far is None:
            return None
        sides.append(Side(End(prefix, joint.cycle), End(prefix + far.prefix, far.cycle)))
    return sides


def _is_boundary(automaton: Automaton, cell: str, word: Word, label: str) -> bool:
    return label in automaton.cells[automaton.end(cell, word)].boundary


def _steps(automaton: Automaton, cell: str, boundary: str) -> Iterator[tuple[str, str, Word]]:
    """From a boundary to the sub-cell that has it as its own boundary, again and again."""
    while True:
        step = _step(automaton, cell, boundary)
        if step is None:
            return
        yield cell, boundary, step[0]
        cell, boundary = automaton.end(cell, step[0]), step[1]


def _step(automaton: Automaton, cell: str, boundary: str) -> tuple[Word, str] | None:
    """The sub-cell at a boundary, by its incidence equation `boundary s = k boundary'`, either way round."""
    for equation in automaton.cells[cell].incidence:
        for outer, inner in ((equation.left, equation.right), (equation.right, equation.left)):
            if outer[0] != boundary or len(outer) != 2:
                continue
            for place in range(1, len(inner)):
                if _is_boundary(automaton, cell, inner[:place], inner[place]):
                    return inner[:place], inner[place]
    return None


def _end(automaton: Automaton, cell: str, boundary: str) -> End | None:
    """The address of the end of a curve at one of its boundaries."""
    seen: list[tuple[str, str]] = []
    words: list[Word] = []
    for here, label, word in _steps(automaton, cell, boundary):
        if (here, label) in seen:
            first = seen.index((here, label))
            return End(_joined(words[:first]), _joined(words[first:]))
        seen.append((here, label))
        words.append(word)
    return None


def _boundary_after(automaton: Automaton, cell: str, boundary: str, length: int) -> str:
    """The boundary of the sub-cell that is reached after words of the given length together."""
    for _, label, word in _steps(automaton, cell, boundary):
        if length <= 0:
            return label
        length -= len(word)
    return boundary


def _joined(words: list[Word]) -> Word:
    return tuple(label for word in words for label in word)
