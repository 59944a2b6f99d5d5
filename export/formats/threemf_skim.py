"""Plain vertices and triangles taken out of XML before the parser sees them."""

import re
from collections.abc import Callable, Iterable
from itertools import chain
from typing import Any

import numpy as np

RUNS = ("vertices", "triangles")
OPENS = re.compile(b"<(%s)>" % "|".join(RUNS).encode())
HELD = 1024  # bytes that wait for the next piece; a longer element is none that is taken out
SHORTEST = 24  # bytes of an element with three numbers
NUMBER = rb'"([0-9eE.+-]+)"'
BLANK = b"[ \t\r\n]"
ODD = re.compile(
    BLANK + b"*<vertex" + b"".join(BLANK + b"+%c=" % axis + NUMBER for axis in b"xyz") + BLANK + b"*/>"
)
INVISIBLE = bytes(set(range(256)) - set(b"\r\n"))
LINE_ENDS = bytes.maketrans(b"\r", b"\n")

Take = Callable[[str, np.ndarray], None]


def feed(parser: Any, pieces: Iterable[bytes], opened: Callable[[], int], take: Take) -> None:
    """Parse the pieces, but hand the rows of plain elements to `take` with the name of what they stand in.

    Rows are taken out only right behind a tag `<vertices>` or `<triangles>` that the parser has just seen:
    `opened` is the place of the last one. What is taken out is blank for the parser, line by line and column
    by column, so that it tells the places of what is wrong as before.
    """
    rest, fed, plain, inside = b"", 0, True, ""

    def parse(text: bytes) -> None:
        nonlocal fed
        parser.Parse(text, False)
        fed += len(text)

    for piece in chain(pieces, [b""]):
        text, at, more = rest + piece, 0, bool(piece)
        while True:
            if inside:
                begin, (at, rows) = at, _skim(inside, text, at)
                take(inside, rows)
                parse(_blank(text[begin:at]))
                if more and len(text) - at < HELD:
                    break
                inside = ""
            found = OPENS.search(text, at) if plain else None
            end = found.end() if found else max(at, len(text) - HELD * more)
            parse(text[at:end])
            at = end
            if not found:
                break
            plain = opened() == fed - len(found[0])  # else it stands in a comment, or the like
            inside = found[1].decode() if plain else ""
        rest = text[at:]
    parser.Parse(b"", True)


def _skim(name: str, text: bytes, at: int) -> tuple[int, np.ndarray]:
    """Where the plain elements end, and their numbers."""
    from export.formats import threemf_kernels as kernels

    whole = name == "triangles"
    read, letters = kernels.triangles if whole else kernels.vertices, np.frombuffer(text, np.uint8)
    rows = np.empty(((len(text) - at) // SHORTEST + 1, 3), dtype=np.int64 if whole else np.float64)
    at, count = read(letters, at, rows)
    while not whole and (odd := ODD.match(text, at)):  # numbers that only Python rounds
        try:
            rows[count] = [float(word) for word in odd.groups()]
        except ValueError:
            break
        at, more = read(letters, odd.end(), rows[count + 1 :])
        count += 1 + more
    return at, rows[:count]


def _blank(taken: bytes) -> bytes:
    """The ends of the lines, and as many blanks as the last line has bytes."""
    last = max(taken.rfind(b"\n"), taken.rfind(b"\r"))
    return taken.replace(b"\r\n", b"\n").translate(LINE_ENDS, INVISIBLE) + b" " * (len(taken) - 1 - last)
