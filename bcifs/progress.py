"""How far a command is, on standard error when that is a terminal."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

Report = Callable[[str, float], None]


@contextmanager
def reporting() -> Iterator[Report]:
    """A function that takes the stage and how much of it is done (0 to 1); silent without a terminal."""
    if not sys.stderr.isatty():
        yield silent
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description:<12}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TextColumn("{task.fields[rate]}"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bars:
        tasks = {}

        def report(stage: str, done: float) -> None:
            if stage not in tasks:
                for task in tasks.values():
                    bars.update(task, completed=1.0)
                tasks[stage] = bars.add_task(stage, total=1.0, rate="")
            bars.update(tasks[stage], completed=min(max(done, 0.0), 1.0))
            speed = bars.tasks[list(tasks).index(stage)].speed
            if speed:
                bars.update(tasks[stage], rate=f"{100 * speed:.3g} %/s")

        yield report


def silent(stage: str, done: float) -> None:
    """Report nothing."""
