"""The vertices and faces of OBJ text.

Imported inside the functions that use it, for numba takes a while to load.
"""

from typing import no_type_check

import numba

from export.formats.decimal_kernels import real

SPACE, SLASH, HASH, MINUS, V, F = 32, 47, 35, 45, 118, 102
LINE_END = 10
LONGEST = 18  # digits of the number of a vertex


@no_type_check
@numba.njit(cache=True, inline="always")
def blank(letter):
    """What parts words within a line."""
    return letter == SPACE or (9 <= letter <= 13 and letter != LINE_END)


@no_type_check
@numba.njit(cache=True, inline="always")
def ends(text, at):
    """Whether a line ends here for those who read it."""
    return at >= len(text) or text[at] == LINE_END or text[at] == HASH


@no_type_check
@numba.njit(cache=True, inline="always")
def word(text, at):
    """The next word of the line: where it begins and ends, equal where there is none."""
    while at < len(text) and blank(text[at]):
        at += 1
    end = at
    while not ends(text, end) and not blank(text[end]):
        end += 1
    return at, end


@no_type_check
@numba.njit(cache=True)
def counts(text):
    """How many lines begin with a word v, and with a word f, and how many words follow these."""
    vertices, faces, corners = 0, 0, 0
    at = 0
    while at < len(text):
        start, end = word(text, at)
        kind = text[start] if end == start + 1 else 0
        vertices += kind == V
        if kind == F:
            faces += 1
            start, end = word(text, end)
            while end > start:
                corners += 1
                start, end = word(text, end)
        at = end
        while at < len(text) and text[at] != LINE_END:
            at += 1
        at += 1
    return vertices, faces, corners


@no_type_check
@numba.njit(cache=True)
def vertex(text, at, end, known):
    """The vertex that the word names, counted from 0, with textures and normals passed over; -1 for none."""
    back = text[at] == MINUS
    begin = at + back
    at, value = begin, 0
    while at < end and 48 <= text[at] <= 57 and at - begin < LONGEST:
        value = 10 * value + text[at] - 48
        at += 1
    if at == begin or (at < end and text[at] != SLASH):
        return -1
    return known - value if back and value else value - 1


@no_type_check
@numba.njit(cache=True)
def fill(text, points, corners, lengths, odd):
    """Write down vertices, corners of faces and their lengths.

    `odd` takes where a coordinate begins and ends that is left to others, after its number in `points`.
    Returns how many of these there are, or -1 where the text is not plain.
    """
    vertices, faces, used, left = 0, 0, 0, 0
    at = 0
    while at < len(text):
        start, end = word(text, at)
        kind = text[start] if end == start + 1 else 0
        if kind == V:
            for axis in range(3):
                start, end = word(text, end)
                value, stop = real(text, start)
                if start == end:
                    return -1
                if stop != end or value != value:
                    if left == len(odd):
                        return -1
                    odd[left, 0], odd[left, 1], odd[left, 2] = 3 * vertices + axis, start, end
                    left += 1
                points[vertices, axis] = value
            vertices += 1
        elif kind == F:
            before = used
            start, end = word(text, end)
            while end > start:
                corners[used] = vertex(text, start, end, vertices)
                if corners[used] < 0:
                    return -1
                used += 1
                start, end = word(text, end)
            lengths[faces] = used - before
            if used - before < 3:
                return -1
            faces += 1
        at = end
        while at < len(text) and text[at] != LINE_END:
            at += 1
        at += 1
    return left
