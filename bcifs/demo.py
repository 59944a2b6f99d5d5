"""The demonstration: example automata become printable parts and pictures in `out/`."""

import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bcifs.failure import CHECK_FAILED, exit_code, explain
from bcifs.progress import reporting

FOLDER = Path("out")

PARTS: Mapping[str, Mapping[str, Any]] = {
    "koch-curve": {"size": 90.0, "thickness": 1.2, "resolution": 450},
    "takagi-curve": {"size": 80.0, "thickness": 1.6, "resolution": 400},
    "catmull-clark-patch": {"size": 80.0, "thickness": 1.6, "resolution": 200},
    "fractal-patch": {"size": 80.0, "thickness": 2.4, "resolution": 120},
    "menger-sponge": {"size": 54.0, "depth": 3},
    "sierpinski-tetrahedron": {"size": 60.0, "thickness": 1.6, "resolution": 160},
}


@dataclass(frozen=True)
class Made:
    """One part of the demonstration: its files, the seconds that each step took, and what was found wrong."""

    name: str
    files: tuple[Path, ...]
    seconds: Mapping[str, float] = field(default_factory=dict)
    words: str = ""
    faults: tuple[str, ...] = ()


def make(name: str, options: Mapping[str, Any], folder: Path) -> Made:
    """Print and draw one built-in automaton into a folder; a part that fails the check is not written."""
    import export
    import ifs
    from bcifs.picture import draw_mesh
    from bcifs.recipe import part_recipe

    seconds: dict[str, float] = {}
    start = time.perf_counter()

    def lap(step: str) -> None:
        nonlocal start
        now = time.perf_counter()
        seconds[step] = now - start
        start = now

    shape = ifs.shape(name)
    lap("read")
    with reporting() as progress:
        part = export.make_part(
            shape, **options, progress=lambda stage, done: progress(f"{name}: {stage}", done)
        )
    lap("part")
    if not part.report.ok:
        return Made(name, (), seconds, faults=part.report.faults)
    recipe = part_recipe(shape, part.recipe)
    target, picture = folder / f"{name}.3mf", folder / f"{name}.png"
    export.write_part(part.mesh, target, recipe, shape.name)
    lap("write")
    draw_mesh(part.mesh, picture, recipe)
    lap("picture")
    return Made(name, (target, picture), seconds, describe(part.report))


def describe(report: Any) -> str:
    """The size of a part and what it is made of, in a line."""
    size = " x ".join(f"{high - low:.0f}" for low, high in zip(report.low, report.high, strict=True))
    shells = f"{report.components} shell{'' if report.components == 1 else 's'}"
    return f"{size} mm, {report.triangles} triangles, {shells}, genus {sum(g or 0 for g in report.genus)}"


def table(made: list[Made]) -> str:
    """What was made, the seconds of each step, the sizes of the files, and how to open them."""
    steps = ("read", "part", "write", "picture")
    head = (
        f"{'part':<24}"
        + "".join(f"{step:>9}" for step in steps)
        + f"{'total':>9}{'3mf':>10}{'png':>10}  what"
    )
    rows = ["", head, "-" * len(head)]
    for one in made:
        times = "".join(f"{one.seconds.get(step, 0):>7.1f} s" for step in steps)
        sizes = (
            "".join(f"{file.stat().st_size / 1000:>7.0f} kB" for file in one.files) or f"{'not written':>20}"
        )
        total = sum(one.seconds.values())
        rows.append(f"{one.name:<24}{times}{total:>7.1f} s{sizes}  {one.words or '; '.join(one.faults)}")
    total = sum(sum(one.seconds.values()) for one in made)
    folder = made[0].files[0].parent if made and made[0].files else FOLDER
    rows += [
        "",
        f"{sum(bool(one.files) for one in made)} parts in {folder}/ after {total:.0f} s. Open a .3mf in a",
        "slicer such as PrusaSlicer (File, Import) or in any 3MF viewer; lengths are in millimetres.",
        "The .png of the same name shows the part.",
    ]
    return "\n".join(rows)


def main(folder: Path = FOLDER, parts: Mapping[str, Mapping[str, Any]] = PARTS) -> int:
    """Make all parts; the exit code is that of the command line, 5 when a part fails its check."""
    made: list[Made] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, options in parts.items():
            print(f"{name} …", flush=True)
            made.append(make(name, options, folder))
    except (Exception, KeyboardInterrupt) as error:
        code = exit_code(error)
        if code is None:
            raise
        print(f"bcifs: {explain(error)}", file=sys.stderr)
        return code
    print(table(made))
    return CHECK_FAILED if any(one.faults for one in made) else 0


if __name__ == "__main__":
    sys.exit(main())
