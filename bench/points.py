"""Points of plane attractors per second: the chaos game and the pieces, beside the plainest loops.

The peers know affine maps of the plane only: a loop compiled by numba, which draws its labels by comparing
with cumulated probabilities, a loop of NumPy over steps for many walkers at once, and plain Python. One run
each, after one that compiles; what compiling and preparing takes is told apart. The pieces of bcifs come with
boxes certain to contain them.
"""

import time
from bisect import bisect
from collections.abc import Callable, Iterator
from itertools import accumulate
from random import Random

import numpy as np

FERN = """fern {
  0    0    0    .16 0 0    .01
  .85  .04 -.04  .85 0 1.6  .85
  .2  -.26  .23  .22 0 1.6  .07
 -.15  .28  .26  .24 0 .44  .07
}"""
WALKERS = 1000


def compiled() -> Callable[[np.ndarray, np.ndarray, int], np.ndarray]:
    """The plain chaos game, compiled: maps `(n, 2, 3)` and cumulated probabilities to points."""
    import numba

    @numba.njit
    def game(maps, upto, count):
        out = np.empty((count, 2))
        x = y = 0.0
        np.random.seed(1)
        for k in range(count):
            label = np.searchsorted(upto, np.random.random(), side="right")
            a = maps[label]
            x, y = a[0, 0] * x + a[0, 1] * y + a[0, 2], a[1, 0] * x + a[1, 1] * y + a[1, 2]
            out[k, 0] = x
            out[k, 1] = y
        return out

    return game


def vectorised(maps: np.ndarray, upto: np.ndarray, count: int) -> np.ndarray:
    """The chaos game of a thousand walkers at once, in NumPy."""
    rng = np.random.default_rng(1)
    places = np.zeros((WALKERS, 2))
    out = np.empty((count // WALKERS, WALKERS, 2))
    for k in range(len(out)):
        chosen = maps[np.searchsorted(upto, rng.random(WALKERS), side="right")]
        places = np.einsum("nij,nj->ni", chosen[:, :, :2], places) + chosen[:, :, 2]
        out[k] = places
    return out.reshape(-1, 2)


def plain(maps: np.ndarray, upto: np.ndarray, count: int) -> list[tuple[float, float]]:
    """The chaos game in plain Python."""
    random, rows, bars = Random(1), maps.tolist(), upto.tolist()
    x = y = 0.0
    found = []
    for _ in range(count):
        (a, b, e), (c, d, f) = rows[bisect(bars, random.random())]
        x, y = a * x + b * y + e, c * x + d * y + f
        found.append((x, y))
    return found


def seconds(action: Callable[[], object]) -> float:
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def report(count: int = 10_000_000) -> Iterator[str]:
    """Lines for the fern by the chaos game, a curve of two cells, and the pieces of the fern at a depth."""
    from automata.fractint import fractint_ifs
    from automata.turtle import lsystem_automaton
    from ifs.maps.plain import maps_of
    from ifs.orbits.attractor import points_in_chunks
    from ifs.orbits.chaos import points
    from ifs.shape import shape

    fern = fractint_ifs(FERN)
    leaf = shape(fern.automaton)
    chances = fern.probabilities
    maps = np.array([each.matrix[:2] for each in maps_of(leaf)])
    upto = np.array(list(accumulate(float(p) for p in chances.values())))
    upto[-1] = 1.0
    drawn = 0

    def game(of, number: int, given=None) -> None:
        nonlocal drawn
        for part in points(of, number, 1, probabilities=given):
            drawn += len(part)

    first = seconds(lambda: game(leaf, 1, chances))
    own = count / seconds(lambda: game(leaf, count, chances))
    peer = compiled()
    compiling = seconds(lambda: peer(maps, upto, 1))
    yield f"points: Barnsley's fern, {count:,} points by the chaos game"
    yield _line("bcifs, streamed in chunks", own, own, f"{first:.2f} s to prepare and compile or load")
    rate = count / seconds(lambda: peer(maps, upto, count))
    yield _line("a compiled loop (numba)", rate, own, f"{compiling:.2f} s to compile")
    few = count // 10
    yield _line("NumPy, 1000 walkers", few / seconds(lambda: vectorised(maps, upto, few)), own)
    few = count // 20
    yield _line("plain Python", few / seconds(lambda: plain(maps, upto, few)), own)
    dragon = shape(lsystem_automaton("Dragon { Angle 8\n Axiom F\n F=-F++G-\n G=+F--G+ }"))
    game(dragon, 1)
    rate = few / seconds(lambda: game(dragon, few))
    yield _line("bcifs, a dragon of two cells", rate, own)
    depth, found = 10, 0

    def pieces() -> None:
        nonlocal found
        found = sum(len(part) for part in points_in_chunks(leaf, depth=depth))

    took = seconds(pieces)
    yield f"points: all {found:,} pieces of the fern after {depth} subdivisions, a point in each"
    yield _line("bcifs, in chunks", found / took, found / took)
    took = found / seconds(lambda: expanded(maps, depth))
    yield _line("NumPy, all levels whole", took, found / seconds(pieces))


def expanded(maps: np.ndarray, depth: int) -> np.ndarray:
    """All images of the origin after a number of generations, in NumPy."""
    places = np.zeros((1, 2))
    for _ in range(depth):
        places = np.concatenate([places @ each[:, :2].T + each[:, 2] for each in maps])
    return places


def _line(label: str, rate: float, own: float, more: str = "") -> str:
    return f"  {label:32} {rate / 1e6:8.2f} million a second   {rate / own:6.2f} x bcifs   {more}".rstrip()


if __name__ == "__main__":
    for line in report():
        print(line, flush=True)
