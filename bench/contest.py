"""Ways to do one task side by side: each in a process of its own, with its time and memory.

A way is a function `prepare(folder, size, *words)` that loads what it works on and gives the action to be
timed; the action gives its result as a function that says something about it. Before that the process does
the same at a small size, so that libraries are loaded and kernels compiled. Time is the least of up to three
runs, on one processor unless said. Memory is the largest resident size after the small run, less what the
process had then: the input in the form that the way wants, the work, and the result.

`python -m bench.contest` is the process of one way; `rows` starts it.
"""

import atexit
import ctypes
import functools
import gc
import importlib
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from bench.sets import _peak_resident, _reset_peak, _resident

Says = Callable[[], str]
Action = Callable[[], Says]

OPENVDB = Path(__file__).parent / "openvdb"
NO_VDB = "it needs g++ and OpenVDB (Debian: apt-get install g++ libopenvdb-dev libboost-dev)"
RUNS, ENOUGH = 3, 20.0  # runs, and the seconds after which there is no other one
MINUTES = 20
MOST = 20 << 30  # bytes
UNITS = {"time": ("s", 1.0), "memory": ("MB", 1e6)}


@dataclass(frozen=True)
class Way:
    """One way to do a task: a function of a module of `bench`, or a C++ program of `bench/openvdb`."""

    name: str
    prepare: Callable[..., Action] | str
    words: tuple[str, ...] = ()
    processors: int = 1


@dataclass(frozen=True)
class Goal:
    """The time or the memory of one way over that of another: at least so much, or at most."""

    figure: str
    over: str
    under: str
    least: float = 0.0
    most: float = float("inf")


@dataclass(frozen=True)
class Contest:
    """A task of some size, what makes its data (`data(folder, size, *words)`), and the ways to do it."""

    title: str
    size: int
    ways: tuple[Way, ...]
    goals: tuple[Goal, ...] = ()
    data: Callable[..., None] | None = None
    words: tuple[str, ...] = ()
    small: int = 32


class LeftOut(Exception):
    """A way that gave no result, with the reason."""


def rows(contest: Contest) -> Iterator[str]:
    """The table of a contest, line by line; ratios are to the first way."""
    width = max(len(way.name) for way in contest.ways) + 2
    yield ""
    yield contest.title
    yield f"  {'':{width}}{'time':>10}{'ratio':>9}{'memory':>13}{'ratio':>9}"
    found: dict[str, dict] = {}
    with tempfile.TemporaryDirectory() as folder:
        _data(contest, Path(folder))
        for way in contest.ways:
            try:
                found[way.name] = _measured(way, (contest.small, contest.size), Path(folder))
            except LeftOut as reason:
                yield f"  {way.name:{width}}left out: {reason}"
                continue
            first = found[contest.ways[0].name] if contest.ways[0].name in found else found[way.name]
            yield f"  {way.name:{width}}{_line(found[way.name], first)}"
    for goal in contest.goals:
        yield f"  {_reached(goal, found)}"


def _line(answer: dict, first: dict) -> str:
    line = ""
    for figure, columns in (("time", 8), ("memory", 10)):
        unit, scale = UNITS[figure]
        line += f"{answer[figure] / scale:>{columns}.{3 if figure == 'time' else 0}f} {unit}"
        line += f"{answer[figure] / max(first[figure], 1e-9):>8.2f}x"
    return f"{line}  {answer['says']}"


def _reached(goal: Goal, found: dict[str, dict]) -> str:
    bound = f"at least {goal.least:g}" if goal.least else f"at most {goal.most:g}"
    words = f"goal: {goal.figure} of {goal.over} over that of {goal.under} {bound}"
    if not {goal.over, goal.under} <= found.keys():
        return f"{words}: not measured"
    ratio = found[goal.over][goal.figure] / max(found[goal.under][goal.figure], 1e-9)
    return f"{words}: {ratio:.2f}, {'reached' if goal.least <= ratio <= goal.most else 'not reached'}"


def _data(contest: Contest, folder: Path) -> None:
    for name, size in (("small", contest.small), ("large", contest.size)):
        (folder / name).mkdir()
        if contest.data is not None:
            subprocess.run(_command("data", contest.data, folder / name, (size,), contest.words), check=True)


def _measured(way: Way, sizes: tuple[int, int], folder: Path) -> dict:
    if isinstance(way.prepare, str):
        command = [str(_compiled(way.prepare)), str(folder / "large")]
    else:
        command = _command("way", way.prepare, folder, sizes, way.words)
    most = min(MOST, _available())

    def confined() -> None:
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
        os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-way.processors :])

    try:
        answer = subprocess.run(
            command, capture_output=True, text=True, timeout=60 * MINUTES, preexec_fn=confined
        )
    except subprocess.TimeoutExpired as error:
        raise LeftOut(f"over {MINUTES} minutes") from error
    if answer.returncode:
        raise LeftOut(_reason(answer, most))
    return json.loads(answer.stdout.splitlines()[-1])


def _reason(answer: subprocess.CompletedProcess[str], most: int) -> str:
    last = (answer.stderr.strip().splitlines() or ["no message"])[-1]
    if any(word in answer.stderr for word in ("MemoryError", "bad_alloc", "Unable to allocate")):
        return f"more than {most / 2**30:.0f} GiB of memory"
    if answer.returncode < 0:
        return f"ended by {signal.Signals(-answer.returncode).name} within {most / 2**30:.0f} GiB ({last})"
    return last


def _command(
    role: str, function: Callable[..., object], folder: Path, sizes: tuple[int, ...], words: tuple[str, ...]
) -> list[str]:
    place = f"{function.__module__}:{function.__qualname__}"
    return [
        sys.executable,
        "-m",
        "bench.contest",
        role,
        place,
        str(folder),
        ",".join(map(str, sizes)),
        *words,
    ]


@functools.cache
def _compiled(source: str) -> Path:
    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    program = Path(folder.name) / Path(source).stem
    flags = ["-O3", "-march=native", "-w"]
    command = ["g++", *flags, str(OPENVDB / source), "-o", str(program), "-lopenvdb", "-ltbb"]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise LeftOut(NO_VDB) from error
    return program


def _available() -> int:
    lines = Path("/proc/meminfo").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith("MemAvailable"))


def _measure(prepare: Callable[..., Action], folder: Path, sizes: list[int], words: tuple[str, ...]) -> dict:
    small, size = sizes
    prepare(folder / "small", small, *words)()()
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    held = _resident()
    action = prepare(folder / "large", size, *words)
    _reset_peak()
    times: list[float] = []
    says: Says = str
    while len(times) < RUNS and sum(times) < ENOUGH:
        says = str
        gc.collect()
        start = time.perf_counter()
        says = action()
        times.append(time.perf_counter() - start)
    memory = max(_peak_resident() - held, 0)
    return {"time": min(times), "memory": memory, "says": says()}


def _main(role: str, place: str, folder: str, sizes: str, *words: str) -> None:
    module, name = place.split(":")
    function = getattr(importlib.import_module(module), name)
    numbers = [int(size) for size in sizes.split(",")]
    if role == "data":
        function(Path(folder), *numbers, *words)
    else:
        print(json.dumps(_measure(function, Path(folder), numbers, words)))


if __name__ == "__main__":
    _main(*sys.argv[1:])
