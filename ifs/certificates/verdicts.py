"""Does each of many systems contract: verdicts for a whole map of parameters at once.

Each system is one cell cut into copies of itself. What is asked is whether the joint spectral radius of its
linear parts is below 1, as in `ifs.convergence`, but with operations on stacks of matrices. Eigenvalues below
1 for every operator alone must hold, but do not suffice: corner cutting with a = -7/10, b = 9/10 has the
eigenvalues -7/10, 9/10 and 4/5, and yet the product of its two operators has one above 1.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from ifs.certificates.differences import spectral_norm

Stack = Float[np.ndarray, "members labels size size"]

_ONE = 1 - 1e-12
_CLOSED = 1 - 1e-6  # far above the rounding of what is multiplied, for norms as well-conditioned as these
_WEIGHT = 1e-4
_ROUNDS = 40
_SHORT = 6  # letters of the words whose eigenvalues are looked at
_WORDS = 40  # at most that many of them
_EFFORTS = ((20, 100), (60, 600))  # letters of the words whose norms are looked at; open words a member
_CHUNK = 20_000


@dataclass(frozen=True)
class Verdicts:
    """For each member whether it `contracts` (proven) or `diverges` (proven); neither where undecided.

    `alone` says whether every operator alone has its eigenvalues below 1 in modulus, the condition that the
    source states; it is necessary. `witness[m]` is the place in `words` of a word whose product has
    spectral radius 1 or more, -1 where there is none.
    """

    contracts: Bool[np.ndarray, "members"]
    diverges: Bool[np.ndarray, "members"]
    alone: Bool[np.ndarray, "members"]
    witness: Int[np.ndarray, "members"]
    words: tuple[tuple[int, ...], ...]


def verdicts(linear: Stack, report: Callable[[float], None] = lambda done: None) -> Verdicts:
    """The verdicts for stacked linear parts (`differences.linear_part`), labels counted from 0.

    A member diverges when a cycle of up to 6 letters has spectral radius 1 - 1e-12 or more; it contracts
    when, in a norm chosen for it, every long enough word has a prefix of norm below 1 - 1e-6 (some power of
    the joint spectral radius is then below 1). `report` is told the part that is done.
    Source: Gentil 2010, 4.3.1 (figure 4.12), whose condition on the eigenvalues of single operators is
    necessary, not sufficient.

    >>> half = np.full((1, 2, 1, 1), 0.5)
    >>> bool(verdicts(half).contracts[0]), bool(verdicts(2 * half).diverges[0])
    (True, True)
    """
    count, labels, size, _ = linear.shape
    words = short_words(labels)
    contracts, witness = np.zeros(count, bool), np.full(count, -1)
    alone = np.ones(count, bool)
    if size == 0:
        return Verdicts(~contracts, contracts, alone, witness, words)
    for place, word in enumerate(words):
        open_ = np.flatnonzero(witness < 0)
        radii = np.abs(np.linalg.eigvals(_product(linear[open_], word))).max(axis=1)
        witness[open_[radii >= _ONE ** len(word)]] = place
        if len(word) == 1:
            alone &= witness < 0
        report(0.5 * (place + 1) / len(words))
    for effort, (longest, most) in enumerate(_EFFORTS):
        rest = np.flatnonzero((witness < 0) & ~contracts)
        for start in range(0, len(rest), _CHUNK):
            part = rest[start : start + _CHUNK]
            contracts[part] = _shrinks(linear[part], longest, most)
            report(0.5 + 0.25 * (effort + (start + len(part)) / len(rest)))
    return Verdicts(contracts, witness >= 0, alone, witness, words)


def short_words(labels: int) -> tuple[tuple[int, ...], ...]:
    """One word for each cycle of up to 6 letters, shortest first, about 40 at most, single letters first."""
    ordered = sorted(lyndon(labels, _SHORT if labels < 4 else 3), key=lambda word: (len(word), word))
    return tuple(ordered[: max(_WORDS, labels)])


def lyndon(labels: int, length: int) -> Iterator[tuple[int, ...]]:
    """The words of up to `length` letters that are first among their rotations, and no powers: one a cycle.

    >>> list(lyndon(2, 3))
    [(0,), (0, 0, 1), (0, 1), (0, 1, 1), (1,)]
    """
    word = [-1]
    while word:
        word[-1] += 1
        yield tuple(word)
        size = len(word)
        while len(word) < length:
            word.append(word[-size])
        while word and word[-1] == labels - 1:
            word.pop()


def _product(linear: Stack, word: tuple[int, ...]) -> Float[np.ndarray, "members size size"]:
    product = linear[:, word[0]]
    for letter in word[1:]:
        product = product @ linear[:, letter]
    return product


def _shrinks(linear: Stack, longest: int, most: int) -> Bool[np.ndarray, "members"]:
    """Gripenberg's search for all members together; a member is given up when too many words stay open."""
    count, labels, size, _ = linear.shape
    scaled = _in_good_norms(linear)
    given_up = np.zeros(count, bool)
    member = np.arange(count)
    products = np.broadcast_to(np.eye(size), (count, size, size))
    for _ in range(longest):
        grown = [products @ scaled[member, label] for label in range(labels)]
        products, member = np.concatenate(grown), np.tile(member, labels)
        norms = spectral_norm(products)
        still = ~(norms < _CLOSED)
        products, member = products[still], member[still]
        given_up |= np.bincount(member, minlength=count) > most
        keep = ~given_up[member]
        products, member = products[keep], member[keep]
        if len(member) == 0:
            break
    given_up[member] = True
    return ~given_up


def _in_good_norms(linear: Stack) -> Stack:
    """`R L R^-1` with R from the iteration of `ellipsoids`, at one weight; R has condition below 1e3."""
    count, _, size, _ = linear.shape
    plain = (np.eye(size) + 1.0) / (2.0 * size)
    forms = np.broadcast_to(plain, (count, size, size)).copy()
    for _ in range(_ROUNDS):
        moved = np.einsum("mlji,mjk,mlkn->min", linear, forms, linear, optimize=True)
        growth = np.maximum(np.trace(moved, axis1=1, axis2=2), 1e-300)[:, None, None]
        forms = (_WEIGHT * plain + moved / growth + 0.5 * forms) / (1.5 + _WEIGHT)
    factors = np.linalg.cholesky(forms).swapaxes(1, 2)
    return factors[:, None] @ linear @ np.linalg.inv(factors)[:, None]
