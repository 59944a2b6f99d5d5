"""How long `bcifs solve corner-cutting` takes as a whole process, beside an interpreter that does nothing."""

import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence

COMMANDS = {
    "python -c pass": ["-c", "pass"],
    "bcifs solve corner-cutting": ["-m", "bcifs", "solve", "corner-cutting"],
}


def wall_times(arguments: Sequence[str], runs: int) -> list[float]:
    """Wall times, in seconds, of several runs of the interpreter; one more before them warms the caches."""
    times = []
    for _ in range(runs + 1):
        start = time.perf_counter()
        subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - start)
    return times[1:]


def report(runs: int = 9) -> Iterator[str]:
    """A line for each command: median, least and greatest time in milliseconds."""
    for name, arguments in COMMANDS.items():
        times = [1000 * seconds for seconds in wall_times(arguments, runs)]
        median = statistics.median(times)
        yield f"{name:28} {median:6.0f} ms  ({min(times):.0f} to {max(times):.0f}, {runs} runs)"
