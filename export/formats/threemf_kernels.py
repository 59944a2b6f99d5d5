"""The vertices and triangles of a 3MF model, where they are written plainly.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba
import numpy as np

from export.formats.decimal_kernels import real

QUOTE = 34
LONGEST = 18  # digits of a whole number


def _words(*words: str) -> tuple[np.ndarray, ...]:
    return tuple(np.frombuffer(word.encode(), np.uint8) for word in words)


VERTEX, TRIANGLE, END = _words("<vertex", "<triangle", "/>")
X, Y, Z, V1, V2, V3, PID, P1, P2, P3 = _words(
    'x="', 'y="', 'z="', 'v1="', 'v2="', 'v3="', 'pid="', 'p1="', 'p2="', 'p3="'
)


@no_type_check
@numba.njit(cache=True)
def after(text, at, word):
    """The place after a word, -1 where it does not stand here, or where `at` is -1 already."""
    if at < 0 or at + len(word) > len(text):
        return -1
    for k in range(len(word)):
        if text[at + k] != word[k]:
            return -1
    return at + len(word)


@no_type_check
@numba.njit(cache=True, inline="always")
def after_blanks(text, at):
    while 0 <= at < len(text) and (text[at] == 32 or text[at] == 9 or text[at] == 10 or text[at] == 13):
        at += 1
    return at


@no_type_check
@numba.njit(cache=True)
def value_of(text, at, word):
    """Where the value of an attribute begins, which blanks and the word with its quote lead to; else -1."""
    begin = after_blanks(text, at)
    return after(text, begin, word) if begin > at else -1


@no_type_check
@numba.njit(cache=True)
def quoted_real(text, at, word):
    at = value_of(text, at, word)
    if at < 0:
        return 0.0, -1
    value, at = real(text, at)
    return value, at + 1 if value == value and at < len(text) and text[at] == QUOTE else -1


@no_type_check
@numba.njit(cache=True)
def quoted_whole(text, at, word):
    at = begin = value_of(text, at, word)
    value = 0
    if at < 0:
        return value, -1
    while at < len(text) and 48 <= text[at] <= 57 and at - begin < LONGEST:
        value = 10 * value + text[at] - 48
        at += 1
    return value, at + 1 if begin < at < len(text) and text[at] == QUOTE else -1


@no_type_check
@numba.njit(cache=True)
def vertices(text, at, rows):
    """Read elements `<vertex x=".." y=".." z=".."/>` that follow each other; where they end, and how many."""
    count = 0
    while count < len(rows):
        place = after(text, after_blanks(text, at), VERTEX)
        rows[count, 0], place = quoted_real(text, place, X)
        rows[count, 1], place = quoted_real(text, place, Y)
        rows[count, 2], place = quoted_real(text, place, Z)
        place = after(text, after_blanks(text, place), END)
        if place < 0:
            break
        at = place
        count += 1
    return at, count


@no_type_check
@numba.njit(cache=True)
def passed(text, at, word):
    """The place after an attribute with a whole number, if it stands here."""
    _, place = quoted_whole(text, at, word)
    return place if place >= 0 else at


@no_type_check
@numba.njit(cache=True)
def triangles(text, at, rows):
    """The same of `<triangle v1=".." v2=".." v3=".."/>`, with or without pid, p1, p2 and p3."""
    count = 0
    while count < len(rows):
        place = after(text, after_blanks(text, at), TRIANGLE)
        rows[count, 0], place = quoted_whole(text, place, V1)
        rows[count, 1], place = quoted_whole(text, place, V2)
        rows[count, 2], place = quoted_whole(text, place, V3)
        place = passed(text, passed(text, place, PID), P1)
        place = passed(text, passed(text, place, P2), P3)
        place = after(text, after_blanks(text, place), END)
        if place < 0:
            break
        at = place
        count += 1
    return at, count
