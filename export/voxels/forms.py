"""The cells of a system in coordinates in which boxes around pieces are tight and cheap.

Points of the attractor of a cell are `z = centre + sum_k y_k direction_k` (z: the barycentric coordinates but
the last). A piece with control points `p_k` is then `g_0 + sum_k y_k g_k` in space, where y runs over the
attractor in these coordinates: over the box `|y_k| <= half_k` (certified), or over a simplex.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from jaxtyping import Float

from ifs.certificates.bounds import Box, extent, sample
from ifs.system import System

_ENTRIES = 1 << 16  # numbers in the operators of the words that a box is worked out with
_ROUNDS = 100
_CLOSED = 1e-12
_SAMPLED = 2000
_NORMALS = 30
_SMALL = 3  # coordinates: cells with as many or fewer are not worth an approximation

Rows = Float[np.ndarray, "_rows _columns"]
Linear = dict[str, list[tuple[str, Rows, Float[np.ndarray, "_rows"]]]]


@dataclass(frozen=True, eq=False)
class Form:
    """Coordinates of a cell: `z = centre + y directions`, `y = (z - centre) functionals`.

    `half` bounds y, None where y runs over the simplex with corners 0 and the unit vectors. The first `slow`
    coordinates of a piece are affine in those of the whole: pieces are nearly what these alone make of them.
    """

    centre: Float[np.ndarray, "coordinates"]
    directions: Float[np.ndarray, "coordinates coordinates"]
    functionals: Float[np.ndarray, "coordinates coordinates"]
    half: Float[np.ndarray, "coordinates"] | None
    slow: int


def forms_of(
    system: System, boxes: Mapping[str, Box], roots: Mapping[str, Float[np.ndarray, "_pieces _points 3"]]
) -> dict[str, Form]:
    """A form for every cell: of several, the one whose boxes are smallest for pieces of these roots."""
    linear = _linear(system)
    words = {name: _words(system, name) for name in system.states}
    asked = _functionals_met(linear, roots)
    slow = _slow(linear)
    forms = {}
    for name, state in system.states.items():
        count = state.points - 1
        if not count:
            forms[name] = Form(np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), 0)
            continue
        points = _points(system, words[name])
        rows = slow.get(name)
        if rows is not None:
            rows = _narrow(points @ rows.T) @ rows
        bases = [_principal(points, rows)]
        if count <= _SMALL:
            bases += [_plain(count, left_out) for left_out in range(count + 1)]
            tight = _narrow(points)
            bases.append((np.linalg.inv(tight.T), tight.T))
        kept = 0 if rows is None else len(rows)
        options = [_boxed(boxes, words[name], basis, kept) for basis in bases]
        if not kept and (boxes[name].lo >= 0).all():
            options.append(Form(np.zeros(count), np.eye(count), np.eye(count), None, 0))
        forms[name] = min(options, key=lambda form: _width(form, asked[name]))
    return forms


def affine_rules(
    system: System, forms: Mapping[str, Form]
) -> dict[str, list[tuple[str, Rows, Float[np.ndarray, "_rows"]]]]:
    """For each cell, for each label: the target, M and t with `y = t + y' M` for y' of the piece."""
    rules = {}
    for name, row in _linear(system).items():
        form, found = forms[name], []
        for target, linear, moved in row:
            below = forms[target]
            shift = (linear @ below.centre + moved - form.centre) @ form.functionals
            found.append((target, (linear @ below.directions.T).T @ form.functionals, shift))
        rules[name] = found
    return rules


def _linear(system: System) -> Linear:
    """Operators on the barycentric coordinates but the last: `z = linear z' + moved`."""
    return {
        name: [
            (target, (operator[:, :-1] - operator[:, -1:])[:-1], operator[:-1, -1])
            for target, operator in zip(state.targets, state.operators, strict=True)
        ]
        for name, state in system.states.items()
    }


def _words(system: System, name: str) -> dict[str, np.ndarray]:
    """The transposed operators of all words of a length, at least one letter, by target."""
    found = {name: np.eye(system.states[name].points)[None]}
    while True:
        longer: dict[str, list[np.ndarray]] = {}
        for middle, words in found.items():
            state = system.states[middle]
            for target, operator in zip(state.targets, state.operators, strict=True):
                longer.setdefault(target, []).append(operator.T @ words)
        entries = sum(words.size for parts in longer.values() for words in parts)
        if entries > _ENTRIES and sum(map(len, found.values())) > 1:
            return found
        found = {target: np.concatenate(parts) for target, parts in longer.items()}
        if max(np.ptp(words, axis=1).max() for words in found.values()) < 1e-3:
            return found


def _points(system: System, words: Mapping[str, np.ndarray]) -> Float[np.ndarray, "_points _coordinates"]:
    """Points of an attractor, in barycentric coordinates but the last."""
    column = sample(system)
    return np.concatenate([np.einsum("p,wpd->wd", column[target], each) for target, each in words.items()])[
        :, :-1
    ]


def _slow(linear: Linear) -> dict[str, Rows]:
    """Functionals that pieces shrink least and that operators map into their own span, by cell.

    Found by repeated application of all operators; two are tried first, as surfaces have, then three, then
    one. A cell is named only if all that lies below it is closed too.
    """
    for count in (2, 3, 1):
        found = _dominant(linear, count)
        closed = {
            name
            for name, rows in found.items()
            if all(
                target in found and _leaves(rows @ matrix, found[target]) <= _CLOSED
                for target, matrix, _ in linear[name]
            )
        }
        while True:
            kept = {name for name in closed if all(target in closed for target, _, _ in linear[name])}
            if kept == closed:
                break
            closed = kept
        closed = {name for name in closed if len(found[name].T) > _SMALL}
        if closed:
            return {name: found[name] for name in closed}
    return {}


def _dominant(linear: Linear, count: int) -> dict[str, Rows]:
    rng = np.random.default_rng(1)
    sizes = {name: len(row[0][1]) for name, row in linear.items()}
    current = {name: np.linalg.qr(rng.normal(size=(n, n)))[0][:count] for name, n in sizes.items()}
    stacks: dict[str, list[np.ndarray]] = {}
    for _ in range(_ROUNDS):
        stacks = {}
        for name, row in linear.items():
            for target, matrix, _ in row:
                stacks.setdefault(target, []).append(current[name] @ matrix)
        current = {
            name: np.linalg.svd(np.concatenate(parts), full_matrices=False)[2][:count]
            for name, parts in stacks.items()
        }
        for name in linear:
            current.setdefault(name, np.eye(sizes[name])[:count])
    return {name: current[name] for name in stacks if sizes[name] > count}


def _leaves(rows: Rows, basis: Rows) -> float:
    return float(np.abs(rows - rows @ basis.T @ basis).max(initial=0))


def _plain(count: int, left_out: int) -> tuple[Rows, Rows]:
    """The barycentric coordinates but one."""
    functionals = np.eye(count)
    if left_out < count:
        functionals[:, left_out] = -1
    return np.linalg.inv(functionals), functionals


def _narrow(points: Rows) -> Rows:
    """Functionals, in rows, whose box around points is small: normals of faces of their hull."""
    axes = points.shape[1]
    directions = np.eye(axes)
    if axes > 1 and np.linalg.matrix_rank(points - points.mean(axis=0), tol=1e-6) == axes:
        from scipy.spatial import ConvexHull

        normals = ConvexHull(points[:_SAMPLED]).equations[:, :-1]
        normals = np.unique((normals * np.sign(normals[:, :1] + 1e-9)).round(12), axis=0)
        normals = np.concatenate([directions, normals[:: max(len(normals) // _NORMALS, 1)]])
        chosen = np.array(list(combinations(range(len(normals)), axes)))
        widths = np.ptp(points @ normals.T, axis=0)[chosen].prod(axis=1)
        areas = np.abs(np.linalg.det(normals[chosen]))
        usable = areas > 0.1
        best = np.argmin(np.where(usable, widths / np.where(usable, areas, 1), np.inf))
        directions = normals[chosen[best]]
    return directions


def _principal(points: Rows, slow: Rows | None) -> tuple[Rows, Rows]:
    """Directions in rows, functionals in columns: the slow ones first, then principal axes of the rest."""
    middle = points - points.mean(axis=0)
    if slow is None:
        axes = _full_axes(middle)
        return axes, axes.T
    values = middle @ slow.T
    along = np.linalg.lstsq(values, middle, rcond=None)[0]
    along += (np.eye(len(slow)) - along @ slow.T) @ np.linalg.pinv(slow.T)
    across = np.linalg.svd(slow)[2][len(slow) :]
    rest = (middle - values @ along) @ across.T
    axes = _full_axes(rest) @ across
    directions = np.concatenate([along, axes])
    return directions, np.linalg.inv(directions)


def _full_axes(rows: Rows) -> Rows:
    return np.linalg.eigh(rows.T @ rows)[1].T[::-1]


def _boxed(
    boxes: Mapping[str, Box], words: Mapping[str, np.ndarray], basis: tuple[Rows, Rows], slow: int
) -> Form:
    """The box of an attractor in given coordinates: that of the boxes of all its pieces."""
    directions, functionals = basis
    values = np.concatenate([functionals, np.zeros((1, functionals.shape[1]))])
    ends = [extent(boxes[target], each @ values) for target, each in words.items()]
    low = np.min([lo.min(axis=0) for lo, _ in ends], axis=0)
    high = np.max([hi.max(axis=0) for _, hi in ends], axis=0)
    return Form((low + high) / 2 @ directions, directions, functionals, (high - low) / 2, slow)


def _functionals_met(linear: Linear, roots) -> dict[str, Rows]:
    """Coordinates along the axes of some pieces of each cell, as functionals."""
    rng = np.random.default_rng(2)
    met: dict[str, list[np.ndarray]] = {name: [] for name in linear}
    for cell, pieces in roots.items():
        for piece in pieces[:8]:
            for _ in range(8):
                name, rows = cell, (piece[:-1] - piece[-1]).T
                for level in range(12):
                    if level >= 4:
                        met[name].append(rows / max(float(np.abs(rows).max(initial=0)), 1e-300))
                    target, matrix, _ = linear[name][rng.integers(len(linear[name]))]
                    name, rows = target, rows @ matrix
    return {
        name: np.concatenate(rows) if rows else np.eye(len(linear[name][0][1])) for name, rows in met.items()
    }


def _width(form: Form, asked: Rows) -> float:
    """The mean width of boxes along functionals."""
    values = asked @ form.directions.T
    if form.half is None:
        return float((values.max(axis=1, initial=0) - values.min(axis=1, initial=0)).mean())
    return float(2 * (np.abs(values) @ form.half).mean()) * (1 + 1e-9)
