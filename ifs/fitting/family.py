"""Coefficients of a family from samples: the free parameters that make a shape pass nearest to them.

The operators are functions of the parameters x, `T_i(x)`, affine in those that the constraints leave free
and rational in those that the description names. A sample with a known parameter t has the address s(t), and
`r(x, P) = P T_s1(x) T_s2(x) … c - y` is differentiable: Levenberg-Marquardt, by optimistix on JAX.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from jaxtyping import Float, Int, Real

import subdivision
from automata import Automaton
from automata.topology import Topology
from ifs.certificates.convergence import Convergence, convergence
from ifs.fitting.control import fit_control
from ifs.mixtures.basis import basis
from ifs.shape import Shape, shape
from ifs.tangency.frames import Frame, frames
from subdivision.coefficients import Scalar, is_number
from subdivision.form import CONSTANT

_STEPS = 120  # subdivisions of an address that are followed: a parameter has some 60 binary digits
_RANK = 1e-9
_MOST = 200
_SLACK = 1e-9
_QUICKLY = {"xla_backend_optimization_level": 0, "xla_llvm_disable_expensive_passes": True}


@dataclass(frozen=True)
class FamilyFit:
    """The member of a family found, and how good it is.

    `values` are the parameters by name, `deviation` their standard deviations by `noise^2 (J^T J)^-1`
    (infinite where the rank is short, NaN where no data are left over). `residuals` are `(n, dim)` in mm,
    computed again by the engine. J is the Jacobian of the residuals over the parameters and the control
    points, both counted in units of the size of the samples; `singular_values` are its, `rank` how many of
    the `unknowns` they determine. `convergence` certifies the member. `ok` is False where the solver did not
    settle, the rank is short, or the member is not known to contract; `why` says it.
    """

    shape: Shape
    values: Mapping[str, float]
    deviation: Mapping[str, float]
    residuals: Float[np.ndarray, "n dim"]
    rank: int
    unknowns: int
    singular_values: Float[np.ndarray, "_"]
    noise: float
    iterations: int
    convergence: Convergence
    ok: bool
    why: str

    @property
    def rms(self) -> float:
        return float(np.sqrt((self.residuals**2).sum(axis=1).mean()))

    @property
    def condition(self) -> float:
        if len(self.singular_values) < self.unknowns or not self.singular_values[-1] > 0:
            return float("inf")
        return float(self.singular_values[0] / self.singular_values[-1])


@dataclass(frozen=True)
class Operators:
    """All operators of a family as one function of its parameters `names`, for JAX to differentiate.

    `at(x)` is `(operators, size, size)`, smaller ones filled up with zeros; `number[cell]` are the places of
    the operators of a cell, `points[cell]` its control points.
    """

    names: tuple[str, ...]
    number: Mapping[str, range]
    points: Mapping[str, int]
    at: Callable[[Any], Any]


def fit_family(
    automaton: Automaton,
    samples: Real[np.ndarray, "n dim"],
    parameters: Real[np.ndarray, "n directions"],
    start: Mapping[str, float],
    control: Real[np.ndarray, "points dim"] | None = None,
) -> FamilyFit:
    """The parameters, and the control points unless given, that make `sum |p(t_i) - y_i|^2` least.

    All parameters that the values of the automaton leave open are fitted; `start` gives each a first value,
    and the control points start from `fit_control` there. `samples` and `control` are in mm. The minimum is
    a local one. Raises `ValueError` for samples that do not fit, or names in `start` that are not the open
    parameters.

    >>> import ifs
    >>> from dataclasses import replace
    >>> from subdivision.schemes import corner_cutting
    >>> true = ifs.shape(corner_cutting(0.25, 0.5), control=np.array([[0, 0], [10, 30], [40, 0]]))
    >>> t = np.linspace(0, 1, 33)[:, None]
    >>> family = replace(true.automaton, values={})
    >>> found = fit_family(family, basis(true, t) @ true.control, t, {"a": 0.3, "b": 0.3}, true.control)
    >>> found.ok, {name: round(value, 6) for name, value in found.values.items()}
    (True, {'a': 0.25, 'b': 0.5})
    """
    samples, parameters = np.asarray(samples, dtype=float), np.asarray(parameters, dtype=float)
    if len(parameters) != len(samples):
        raise ValueError(f"expected a parameter for each of {len(samples)} samples, found {len(parameters)}")
    table = operators(automaton)
    if set(start) != set(table.names):
        raise ValueError(
            f"start gives values for {sorted(start)}; the open parameters are {list(table.names)}"
        )
    first = np.array([float(start[name]) for name in table.names])
    member = _member(automaton, table, first, np.zeros((table.points[automaton.shape], samples.shape[1])))
    if control is None:
        opening = fit_control(member, samples, parameters).shape.control
    else:
        opening = shape(member.automaton, control=control).control
    size = float(np.ptp(samples, axis=0).max()) or 1.0
    problem = _problem(member, table, samples / size, parameters, None if control is None else opening / size)
    y = np.concatenate([first, opening.ravel() / size if control is None else np.zeros(0)])
    y, jacobian, iterations, settled = _minimised(problem, y)
    values = y[: len(first)]
    points = y[len(first) :].reshape(-1, samples.shape[1]) * size if control is None else opening
    return _report(automaton, table, samples, parameters, values, points, jacobian, iterations, settled)


def operators(automaton: Automaton) -> Operators:
    """The operators of an automaton's family as a function of what its values leave open.

    >>> from dataclasses import replace
    >>> from subdivision.schemes import corner_cutting
    >>> table = operators(replace(corner_cutting(0, 0), values={}))
    >>> table.names, np.asarray(table.at(np.array([0.25, 0.5])))[0, 0].tolist()
    (('a', 'b'), [0.75, 0.5, 0.0])
    """
    solution = subdivision.solve(automaton)
    chosen = solution.with_values(automaton.values) if automaton.values else solution
    free = {i: k for k, i in enumerate(i for i in range(len(chosen.parameters)) if i not in chosen.fixed)}
    names = (*(chosen.parameters[i].name for i in free), *chosen.open_parameters)
    cells = Topology(automaton).automaton.cells
    number, places, keys, scalars = {}, [], [], []
    total = 0
    for name, cell in cells.items():
        number[name] = range(total, total + len(cell.subdivision))
        for place, label in zip(number[name], cell.subdivision, strict=True):
            for i, row in enumerate(chosen.operators[name][label]):
                for j, form in enumerate(row):
                    for key, scalar in form.items():
                        places.append((place, i, j))
                        keys.append(0 if key == CONSTANT else 1 + free[key])
                        scalars.append(scalar)
        total += len(cell.subdivision)
    points = {name: cell.points for name, cell in cells.items()}
    size = max(points.values())
    where, which = np.array(places).T, np.array(keys)
    fixed = np.array([float(s) if is_number(s) else 0.0 for s in scalars])
    moving = [(n, s) for n, s in enumerate(scalars) if not is_number(s)]

    def at(x):
        import jax.numpy as jnp

        x = jnp.asarray(x)
        factors = jnp.asarray(fixed)
        if moving:
            own = dict(zip(names[len(free) :], x[len(free) :], strict=True))
            found = jnp.stack([_value(scalar, own) for _, scalar in moving])
            factors = factors.at[np.array([n for n, _ in moving])].set(found)
        values = factors * jnp.concatenate([jnp.ones(1), x])[which]
        return jnp.zeros((total, size, size)).at[where[0], where[1], where[2]].add(values)

    return Operators(names, number, points, at)


def _value(scalar: Scalar, values: Mapping[str, Any]) -> Any:
    """A rational function at values of its parameters."""
    names = [str(symbol) for symbol in scalar.field.symbols]

    def polynomial(terms) -> Any:
        total = 0.0
        for powers, factor in terms.items():
            term = float(factor)
            for name, power in zip(names, powers, strict=True):
                term = term * values[name] ** power if power else term
            total = total + term
        return total

    return polynomial(scalar.numer) / polynomial(scalar.denom)


def _member(automaton: Automaton, table: Operators, x: np.ndarray, control: np.ndarray) -> Shape:
    return shape(automaton, {n: Fraction(float(v)) for n, v in zip(table.names, x, strict=True)}, control)


def _addresses(
    member: Shape, table: Operators, parameters: Float[np.ndarray, "n directions"]
) -> tuple[Int[np.ndarray, "n steps"], Float[np.ndarray, "n size"]]:
    """The operators along the address of each parameter, and a point of the cell that it ends in."""
    found = frames(member.topology, [member.system.shape])
    inverses = {name: [np.linalg.inv(part.axes) for part in frame.parts] for name, frame in found.items()}
    ends = []
    words = np.zeros((len(parameters), _STEPS), dtype=np.int64)
    size = max(table.points.values())
    for row, t in enumerate(parameters):
        cell = member.system.shape
        for step in range(_STEPS):
            part, t = _part(found[cell], inverses[cell], t, row)
            words[row, step] = table.number[cell][part]
            cell = found[cell].parts[part].cell
        points = table.points[cell]
        ends.append(np.pad(np.full(points, 1 / points), (0, size - points)))
    return words, np.array(ends)


def _part(
    frame: Frame,
    inverses: Sequence[Float[np.ndarray, "directions directions"]],
    t: Float[np.ndarray, "directions"],
    row: int,
) -> tuple[int, Float[np.ndarray, "directions"]]:
    """The sub-piece in which a parameter lies, and the parameter there."""
    triangle = len(frame.reference) == 3
    best, where, most = 0, t, -np.inf
    for i, (part, inverse) in enumerate(zip(frame.parts, inverses, strict=True)):
        local = inverse @ (t - part.origin)
        inside = np.append(local, 1 - local.sum()).min() if triangle else np.minimum(local, 1 - local).min()
        if inside > most:
            best, where, most = i, local, inside
    if most < -_SLACK:
        raise ValueError(f"sample {row} has its parameter in a hole of the shape, or outside")
    return best, np.clip(where, 0.0, 1.0)


def _problem(
    member: Shape,
    table: Operators,
    samples: Float[np.ndarray, "n dim"],
    parameters: Float[np.ndarray, "n directions"],
    control: Float[np.ndarray, "points dim"] | None,
) -> Callable[[Any], Any]:
    """The residuals as a function of the parameters and then, unless given, the control points."""
    words, ends = _addresses(member, table, parameters)
    count, points = len(table.names), table.points[member.system.shape]
    dimension = samples.shape[1]

    def residuals(y):
        import jax
        import jax.numpy as jnp

        stack = table.at(y[:count])

        def step(columns, letters):
            return jnp.einsum("nij,nj->ni", stack[letters], columns), None

        columns, _ = jax.lax.scan(step, jnp.asarray(ends), jnp.asarray(words.T[::-1].copy()))
        own = y[count:].reshape(points, dimension) if control is None else jnp.asarray(control)
        return (columns[:, :points] @ own - samples).ravel()

    return residuals


def _minimised(problem: Callable, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, int, bool]:
    import jax
    import optimistix

    def descend(y):
        found = optimistix.least_squares(
            lambda y, _: problem(y),
            optimistix.LevenbergMarquardt(rtol=1e-10, atol=1e-12),
            y,
            max_steps=_MOST,
            throw=False,
        )
        settled = found.result == optimistix.RESULTS.successful
        return found.value, jax.jacfwd(problem)(found.value), found.stats["num_steps"], settled

    with jax.enable_x64(True), jax.default_device(jax.devices("cpu")[0]):
        value, jacobian, steps, settled = jax.jit(descend, compiler_options=_QUICKLY)(y)
        return np.asarray(value), np.asarray(jacobian), int(steps), bool(settled)


def _report(
    automaton: Automaton,
    table: Operators,
    samples: Float[np.ndarray, "n dim"],
    parameters: Float[np.ndarray, "n directions"],
    x: Float[np.ndarray, "_"],
    control: Float[np.ndarray, "points dim"],
    jacobian: Float[np.ndarray, "residuals unknowns"],
    iterations: int,
    settled: bool,
) -> FamilyFit:
    member = _member(automaton, table, x, control)
    residuals = samples - basis(member, parameters) @ control
    _, sizes, right = np.linalg.svd(jacobian, full_matrices=False)
    unknowns = jacobian.shape[1]
    rank = int((sizes > _RANK * sizes.max(initial=0.0)).sum())
    over = jacobian.shape[0] - rank
    noise = float(np.sqrt((residuals**2).sum() / over)) if over else float("nan")
    size = float(np.ptp(samples, axis=0).max()) or 1.0
    spread = np.full(len(x), np.inf)
    if rank == unknowns:
        spread = noise / size * np.sqrt(((right.T / sizes) ** 2).sum(axis=1))[: len(x)]
    certificate = convergence(member.system)
    reasons = []
    if not settled:
        reasons.append(f"the solver had not settled after {iterations} steps: start nearer to the data")
    if rank < unknowns:
        reasons.append(
            f"{len(samples)} samples determine {rank} of {unknowns} unknowns: give more, or control points"
        )
    if certificate.verdict != "contracts":
        reasons.append(f"the member found is not known to contract ({certificate.verdict})")
    values = {name: float(value) for name, value in zip(table.names, x, strict=True)}
    deviation = {name: float(value) for name, value in zip(table.names, spread, strict=True)}
    return FamilyFit(
        member, values, deviation, residuals, rank, unknowns, sizes, noise, iterations, certificate,
        not reasons, "; ".join(reasons),
    )  # fmt: skip
