"""From an attractor to a file: voxels, meshes, unions and formats, beside the peers.

`python -m bench.parts [SIDE] [--level LEVEL] [--only WORD]`: SIDE is a power of two, 256 unless given, LEVEL
that of the sponge whose cubes are united, 3 unless given (4 takes manifold3d minutes); with a word only the
tasks whose title holds it. Each way runs in a process of its own (`bench.contest`). A peer that is not
installed, or needs more than 20 GiB, or more than is free, is left out with the reason. Ratios are to
the first way of a table, and the goals stand below it.
"""

import argparse
from collections.abc import Iterator

from bench.contest import Contest, rows


def contests(side: int, level: int) -> list[Contest]:
    """All tasks, in the order of the work."""
    from bench import parts_files, parts_meshing, parts_unions, parts_voxelising

    return [
        *parts_voxelising.contests(side),
        *parts_meshing.contests(side),
        *parts_unions.contests(level),
        *parts_files.contests(side),
    ]


def report(side: int = 256, level: int = 3, only: str = "") -> Iterator[str]:
    """The lines of the benchmark."""
    yield f"Parts at {side} voxels a side: least time of up to three runs, largest memory with the input."
    for contest in contests(side, level):
        if only.lower() in contest.title.lower():
            yield from rows(contest)


def _asked() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench.parts", description=(__doc__ or "").split("\n")[0])
    sides = [2**bits for bits in range(6, 12)]
    parser.add_argument("side", nargs="?", type=int, default=256, choices=sides, help="voxels a side")
    parser.add_argument("--level", type=int, default=3, choices=(1, 2, 3, 4), help="of the sponge")
    parser.add_argument("--only", default="", help="tasks whose title holds this word")
    return parser.parse_args()


if __name__ == "__main__":
    for line in report(**vars(_asked())):
        print(line, flush=True)
