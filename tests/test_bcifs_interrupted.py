"""Commands that cannot end well, by Ctrl-C, full disks, closed folders or senseless input, leave nothing."""

import contextlib
import os
import pty
import re
import resource
import select
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import ifs
from bcifs.__main__ import main
from export.files import WRITABLE

PATIENCE = 240.0  # seconds until a test gives up
# The disk is so slow that no command ends before it is interrupted.
SLOW_DISK = """
import os, sys, time
os.fsync = lambda handle: time.sleep(300)
from bcifs.__main__ import main
sys.exit(main())
"""
STAGES = ["voxels", "thickness", "surface", "check", "writing"]


@contextlib.contextmanager
def at_a_terminal(command: list[str]):
    """A process whose standard error is a terminal, and the end at which that can be read."""
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "120"}
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=theirs, env=environment)
    os.close(theirs)
    try:
        yield process, ours
    finally:
        process.kill()
        process.wait()
        os.close(ours)


def read_on(terminal: int) -> bytes:
    if not select.select([terminal], [], [], 0.02)[0]:
        return b""
    try:
        return os.read(terminal, 65536)
    except OSError:  # the other end is closed
        return b""


@pytest.mark.parametrize(
    "stage", [pytest.param(s, marks=() if s in ("surface", "writing") else pytest.mark.slow) for s in STAGES]
)
def test_ctrl_c_leaves_nothing(stage, tmp_path):
    """The signal is sent when the progress bar names the stage; for the last, when a file has appeared."""
    words = ["print", "doo-sabin-patch", "--size", "80", "--thickness", "2", "--resolution", "100", "-o"]
    with at_a_terminal([sys.executable, "-c", SLOW_DISK, *words, str(tmp_path / "part.3mf")]) as (
        process,
        end,
    ):
        shown, give_up = b"", time.monotonic() + PATIENCE
        while time.monotonic() < give_up and process.poll() is None:
            shown += read_on(end)
            if any(tmp_path.iterdir()) if stage == "writing" else stage.encode() in shown:
                break
        assert process.poll() is None, shown
        process.send_signal(signal.SIGINT)
        while time.monotonic() < give_up and process.poll() is None:
            shown += read_on(end)
        shown += read_on(end)
        assert process.returncode == 130, shown
    assert b"Traceback" not in shown
    assert list(tmp_path.iterdir()) == []


@contextlib.contextmanager
def room_for(size: int):
    """No file can grow beyond this size."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize(
    "words",
    [
        *(f"print menger-sponge --depth 1 -o x{ending}" for ending in WRITABLE),
        "mesh koch-curve --depth 3 -o x.obj",
        "mesh doo-sabin-patch --depth 2 -o x.stl",
        "render koch-curve --depth 3 -o x.svg",
    ],
)
def test_a_disk_that_fills_up(words, tmp_path, capsys, monkeypatch):
    """At whatever byte it ends, what stood there before stays, and nothing else is left."""
    monkeypatch.chdir(tmp_path)
    assert main(words.split()) == 0
    (path,) = tmp_path.iterdir()
    whole = path.read_bytes()
    path.write_bytes(b"before")
    capsys.readouterr()
    for size in (1, len(whole) - 1):
        with room_for(size):
            assert main(words.split()) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.count("\n") == 1
        assert path.name in said.err
        assert "too large" in said.err
        assert [found.name for found in tmp_path.iterdir()] == [path.name]
        assert path.read_bytes() == b"before"
    with room_for(len(whole)):
        assert main(words.split()) == 0
    assert path.read_bytes() == whole


def test_a_full_file_system(tmp_path, capsys):
    """A file system in memory of 16 kB, where one can be mounted."""
    place = tmp_path / "small"
    place.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", str(place)]
    try:
        done = subprocess.run(mount, capture_output=True)
    except FileNotFoundError:
        pytest.skip("there is no mount")
    if done.returncode:
        pytest.skip("file systems cannot be mounted here")
    try:
        for ending in WRITABLE:
            code = main(["print", "menger-sponge", "--depth", "2", "-o", str(place / f"x{ending}")])
            said = capsys.readouterr()
            assert (code, said.out) == (2, "")
            assert said.err.endswith("No space left on device\n")
            assert f"x{ending}" in said.err
            assert list(place.iterdir()) == []
    finally:
        subprocess.run(["umount", str(place)], check=True)


def test_folders_that_cannot_be_written(tmp_path, capsys):
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    folders = ["/proc", *([] if os.geteuid() == 0 else [str(closed)])]
    for folder in folders:
        for words in ("print menger-sponge --depth 1", "print koch-curve --resolution 20"):
            assert main([*words.split(), "-o", f"{folder}/x.3mf"]) == 2
            said = capsys.readouterr()
            assert said.out == ""
            assert f"{folder}/x.3mf" in said.err
            assert said.err.count("\n") == 1
    assert list(closed.iterdir()) == []


def test_a_billion_voxels_are_refused_with_what_fits(tmp_path, capsys):
    assert main(["print", "menger-sponge", "--resolution", "19683", "-o", str(tmp_path / "x.3mf")]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "Traceback" not in said.err
    assert re.search(r"a resolution of \d+ fits", said.err)
    assert list(tmp_path.iterdir()) == []


NO_NUMBERS = ["nan", "-nan", "inf", "-inf", "1e400", '"0/0"', '"nan"']


@pytest.mark.parametrize("number", NO_NUMBERS)
def test_control_points_that_are_no_numbers(number, tmp_path, capsys):
    path = tmp_path / "curve.toml"
    path.write_text(
        f"""format = "bcifs/1"
name = "Line"
[[maps]]
scale = "1/2"
translation = [0, 0]
[[maps]]
scale = "1/2"
translation = ["1/2", 0]
[control]
points = [[0, 0], [10, {number}], [0, 10]]
"""
    )
    for words in (["print", str(path), "-o", str(tmp_path / "x.3mf")], ["info", str(path)]):
        assert main(words) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert re.match(r"bcifs: .*curve\.toml:10:\d+: ", said.err)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_control_points_from_python(number):
    shape = ifs.shape("koch-curve")
    for row in range(3):
        points = np.array(shape.control)
        points[row, 1] = number
        with pytest.raises(ValueError, match=f"control point {row} is not finite"):
            ifs.shape("koch-curve", control=points)
