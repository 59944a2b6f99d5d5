"""How long a part prints, by PrusaSlicer where it is installed."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from export.files import write_part
from ifs.mesh import Mesh

LIMIT = 300.0  # seconds
SAID = re.compile(r"; estimated printing time \(normal mode\) = (.+)")
PARTS = re.compile(r"(\d+)([dhms])")
SECONDS = {"d": 86400, "h": 3600, "m": 60, "s": 1}


class NoSlicer(ValueError):
    """The print time cannot be told: no slicer is installed, it took too long, or it refused the part."""


def print_time(mesh: Mesh, limit: float = LIMIT, slicer: str | None = None) -> int:
    """The seconds that PrusaSlicer expects, with the mesh (mm) as it stands.

    Its standard settings hold, but for a bed that is large enough.
    It runs for `limit` seconds at most. `slicer` is its program, by default `prusa-slicer` or
    `PrusaSlicer` on the path. Raises `NoSlicer`.
    """
    program = slicer or shutil.which("prusa-slicer") or shutil.which("PrusaSlicer")
    if program is None:
        raise NoSlicer("PrusaSlicer is not installed: the print time cannot be told")
    with tempfile.TemporaryDirectory() as folder:
        part, gcode = Path(folder) / "part.stl", Path(folder) / "part.gcode"
        write_part(mesh, part)
        command = [program, "--export-gcode", *_bed(mesh), "-o", str(gcode), str(part)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=limit)
        except subprocess.TimeoutExpired:
            raise NoSlicer(f"PrusaSlicer took more than {limit:g} s: the print time cannot be told") from None
        except OSError as error:
            raise NoSlicer(f"{program}: {error.strerror}: the print time cannot be told") from None
        if done.returncode or not gcode.exists():
            words = [line for line in (done.stdout + done.stderr).splitlines() if line.strip()]
            reason = words[-1].strip()[:200] if words else f"exit code {done.returncode}"
            raise NoSlicer(f"PrusaSlicer does not slice the part: {reason}")
        said = SAID.search(gcode.read_text(errors="replace"))
    if said is None:
        raise NoSlicer("PrusaSlicer does not tell the print time")
    return seconds(said[1])


def _bed(mesh: Mesh) -> list[str]:
    """Options for a printer on which the part fits, in its middle."""
    width, depth = (max(int(side) + 60, 250) for side in np.ptp(mesh.points_3d()[:, :2], axis=0))
    shape = f"0x0,{width}x0,{width}x{depth},0x{depth}"
    return ["--bed-shape", shape, "--center", f"{width / 2:g},{depth / 2:g}"]


def seconds(text: str) -> int:
    """The seconds of a time as the slicer writes it.

    >>> seconds("1d 2h 3m 4s")
    93784
    """
    return sum(int(count) * SECONDS[unit] for count, unit in PARTS.findall(text))


def duration(time: int) -> str:
    """A time in words.

    >>> duration(93784)
    '26 h 3 min'
    """
    hours, minutes = divmod(round(time / 60), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"
