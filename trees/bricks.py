"""The working form: 64 cells a word, in Morton order, words that repeat written once."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import UInt64

from trees.errors import TreeError

CROWDED = 4

Entries = tuple[UInt64[np.ndarray, " _entries"], UInt64[np.ndarray, " _entries"]]


@dataclass(frozen=True, eq=False)
class Bricks:
    """The lowest six levels of the binary tree are one word, a brick: bit b of brick i is cell `64 i + b`.

    `words[j]` is the word of all bricks from `starts[j]` to before `starts[j + 1]`, so a large full or
    empty region is one entry. Neighbouring entries differ: a set has one form. A tree of fewer than 64
    cells uses the low bits of one word. `depth` is that of the binary tree, at most 64.
    """

    depth: int
    starts: UInt64[np.ndarray, " entries"]
    words: UInt64[np.ndarray, " entries"]

    def __post_init__(self):
        for name in ("starts", "words"):
            object.__setattr__(self, name, _frozen(getattr(self, name)))

    @property
    def number(self) -> int:
        """How many bricks the cube has."""
        return 2 ** max(self.depth - 6, 0)

    @property
    def lengths(self) -> UInt64[np.ndarray, " entries"]:
        """How many bricks each entry stands for."""
        return np.diff(self.starts, append=np.uint64(self.number))

    def __reduce__(self):
        return Bricks, (self.depth, self.starts, self.words)

    @property
    def nbytes(self) -> int:
        """The memory of the arrays."""
        return self.starts.nbytes + self.words.nbytes

    @cached_property
    def count(self) -> int:
        """How many cells are black."""
        ones = np.bitwise_count(self.words).astype(np.uint64)
        high, low = self.lengths >> np.uint64(29), self.lengths & np.uint64(2**29 - 1)
        return (int((ones * high).sum()) << 29) + int((ones * low).sum())

    @property
    def crowded(self) -> bool:
        """Whether a word for every brick is the better form: the rule that chooses between the two."""
        return self.number <= CROWDED * len(self.words)

    def same(self, other: "Bricks") -> bool:
        """Whether the arrays are equal."""
        return np.array_equal(self.starts, other.starts) and np.array_equal(self.words, other.words)


@dataclass(frozen=True, eq=False)
class Flat:
    """A word for every brick, where at least every fourth differs from the one before: see `Bricks`."""

    depth: int
    words: UInt64[np.ndarray, " bricks"]

    def __post_init__(self):
        object.__setattr__(self, "words", _frozen(self.words))

    def __reduce__(self):
        return Flat, (self.depth, self.words)

    @property
    def nbytes(self) -> int:
        """The memory of the array."""
        return self.words.nbytes

    @cached_property
    def count(self) -> int:
        """How many cells are black."""
        return int(np.bitwise_count(self.words).sum(dtype=np.int64))

    def same(self, other: "Flat") -> bool:
        """Whether the arrays are equal."""
        return np.array_equal(self.words, other.words)


def form_of_bricks(bricks: Bricks) -> Bricks | Flat:
    """The same set, flat where that is the better form."""
    return flat_of_bricks(bricks) if bricks.crowded else bricks


def form_of_words(
    depth: int, words: UInt64[np.ndarray, " bricks"], changes: int | None = None
) -> Bricks | Flat:
    """The set with these words, one for each brick, of which `changes` differ from the one before."""
    from trees import kernels

    changes = int(kernels.changes_of(words)) if changes is None else changes
    if words.size <= CROWDED * changes:
        return Flat(depth, own(words))
    return bricks_of(depth, kernels.squeezed(words, changes))


def flat_of_bricks(bricks: Bricks) -> Flat:
    """The same set with a word for every brick."""
    from trees import kernels

    return Flat(bricks.depth, own(kernels.spread(bricks.starts, bricks.words, bricks.number)))


def bricks_of_flat(flat: Flat) -> Bricks:
    """The same set with repeated words written once."""
    from trees import kernels

    return bricks_of(flat.depth, kernels.squeezed(flat.words, kernels.changes_of(flat.words)))


def bricks_of(depth: int, arrays: Entries) -> Bricks:
    """Bricks from arrays made here: they are locked, not copied."""
    starts, words = arrays
    return Bricks(depth, own(starts), own(words))


def own(array: UInt64[np.ndarray, " _entries"]) -> UInt64[np.ndarray, " _entries"]:
    """An array made here, locked."""
    array.setflags(write=False)
    return array


def _frozen(array: np.ndarray) -> UInt64[np.ndarray, " _entries"]:
    """The array if it cannot be changed, else a copy that cannot."""
    array = np.asarray(array, dtype=np.uint64)
    if array.flags.writeable:
        array = array.copy()
        array.setflags(write=False)
    return array


def brick_mask(depth: int) -> int:
    """The word with all bits that a tree of this depth uses."""
    return 2 ** (2 ** min(depth, 6)) - 1


def check_bricks(bricks: Bricks) -> None:
    """Raises `TreeError` where the entries are not in canonical form: for arrays that come from outside."""
    starts, words = bricks.starts, bricks.words
    if starts.ndim != 1 or starts.shape != words.shape or starts.size == 0 or starts[0] != 0:
        raise TreeError("starts and words are needed in equal number, the first start 0")
    if starts.size > 1 and not (starts[1:] > starts[:-1]).all():
        entry = int(np.argmin(starts[1:] > starts[:-1])) + 1
        raise TreeError(f"start {entry} is not above the one before")
    if int(starts[-1]) >= bricks.number:
        raise TreeError(f"brick {int(starts[-1])} of a tree of {bricks.number} bricks")
    if starts.size > 1 and (words[1:] == words[:-1]).any():
        entry = int(np.argmax(words[1:] == words[:-1])) + 1
        raise TreeError(f"word {entry} repeats the one before")
    if int(words[0]) & ~brick_mask(bricks.depth):
        raise TreeError(f"word {int(words[0]):#x} has bits beyond the {2**bricks.depth} cells of the tree")
