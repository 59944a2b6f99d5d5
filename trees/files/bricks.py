"""The body of kind "bricks": starts and words, and the summary of a chunk of them.

A summary is the first start, the first word, and the number of black cells as a low and a high uint64. With
it a chunk can be judged, and its cells be counted, without its neighbours.
"""

import numpy as np
from jaxtyping import UInt64

from trees.bricks import brick_mask
from trees.errors import DamagedFile, TreeError
from trees.files.layout import CHUNK, Head, Stored
from trees.tree import Tree, of_bricks

Chunk = tuple[UInt64[np.ndarray, " _entries"], UInt64[np.ndarray, " _entries"]]
LOW = 2**64 - 1


def head_of(tree: Tree) -> Head:
    """The head of the file of a tree."""
    return Head("bricks", tree.cube, tree.bits, len(tree.words))


def summaries(tree: Tree) -> UInt64[np.ndarray, "chunks 4"]:
    """One row a chunk.

    >>> from trees import from_points
    >>> summaries(from_points([[1], [2]], bits=2)).tolist()
    [[0, 6, 2, 0]]
    """
    begins = np.arange(0, len(tree.words), CHUNK)
    found = np.zeros((len(begins), 4), dtype=np.uint64)
    found[:, 0], found[:, 1] = tree.starts[begins], tree.words[begins]
    lengths = tree.lengths
    for row, begin in enumerate(begins.tolist()):
        within = slice(begin, begin + CHUNK)
        cells = count(lengths[within], tree.words[within])
        found[row, 2:] = cells & LOW, cells >> 64
    return found


def count(lengths: UInt64[np.ndarray, " entries"], words: UInt64[np.ndarray, " entries"]) -> int:
    """The black cells of words, each repeated so often: exact, also where there are 2^64."""
    ones = np.bitwise_count(words).astype(np.uint64)
    high, low = lengths >> np.uint64(29), lengths & np.uint64(2**29 - 1)
    return (int((ones * high).sum()) << 29) + int((ones * low).sum())


def bricks_of(head: Head) -> int:
    """How many bricks the cube has."""
    return 2 ** max(head.cube.dimension * head.bits - 6, 0)


def check_table(stored: Stored) -> None:
    """Raises `DamagedFile` where no tree has these summaries: falling starts, more cells than room."""
    if stored.head.kind != "bricks" or stored.head.root:
        raise DamagedFile(
            f"a body of kind {stored.head.kind}, root {stored.head.root}, where bricks are read"
        )
    depth = stored.head.cube.dimension * stored.head.bits
    if depth > 64:
        raise DamagedFile(f"bricks of a tree of {depth} levels: they have at most 64")
    bricks = bricks_of(stored.head)
    first, _, low, high = stored.summaries.T
    if first[0] or (first[1:] <= first[:-1]).any() or int(first[-1]) >= bricks:
        raise DamagedFile(f"the chunks' first bricks do not rise from 0 to below {bricks}")
    if len(first) == 1:
        wrong = (int(high[0]) << 64) + int(low[0]) > 2**depth
    else:
        room = np.diff(first, append=np.uint64(bricks))
        wrong = high.any() or ((low >> np.uint64(6)) + (low & np.uint64(63) > 0) > room).any()
    if wrong:
        raise DamagedFile("a chunk that counts more cells than it has")


def checked_chunk(stored: Stored, number: int) -> Chunk:
    """Starts and words of a chunk. Raises `DamagedFile` where they are changed, or no part of a tree."""
    starts, words = (array.astype(np.uint64) for array in stored.chunk(number))
    start, word, low, high = stored.summaries[number].tolist()
    last = number + 1 == stored.head.chunks
    stop = bricks_of(stored.head) if last else int(stored.summaries[number + 1, 0])
    rising = (starts[1:] > starts[:-1]).all() and int(starts[-1]) < stop
    differing = (words[1:] != words[:-1]).all() and (last or words[-1] != stored.summaries[number + 1, 1])
    agreeing = int(starts[0]) == start and int(words[0]) == word
    if not (rising and differing and agreeing):
        raise DamagedFile(f"chunk {number}: its bricks are not in order, or words that repeat are not one")
    mask = brick_mask(stored.head.cube.dimension * stored.head.bits)
    if int(np.bitwise_or.reduce(words)) & ~mask:
        raise DamagedFile(f"chunk {number}: a word with bits beyond the cells of the tree")
    if count(np.diff(starts, append=np.uint64(stop)), words) != (high << 64) + low:
        raise DamagedFile(f"chunk {number}: its cells are not {(high << 64) + low}")
    return starts, words


def tree_of(stored: Stored) -> Tree:
    """The whole tree, each chunk checked."""
    check_table(stored)
    head = stored.head
    starts, words = np.empty(head.count, np.uint64), np.empty(head.count, np.uint64)
    for number in range(head.chunks):
        within = slice(number * CHUNK, (number + 1) * CHUNK)
        starts[within], words[within] = checked_chunk(stored, number)
    try:
        return of_bricks(head.cube, head.bits, starts, words)
    except TreeError as error:
        raise DamagedFile(f"no tree has these contents: {error}") from error
