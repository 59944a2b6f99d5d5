"""Addresses of points of a curve: a finite word, then a label repeated for ever."""

from dataclasses import dataclass

from fld.curve import Curve
from ifs.orbits.addresses import split_address


@dataclass(frozen=True)
class Address:
    """`word` then `repeat` for ever; the word does not end in `repeat`, so equal addresses compare equal."""

    word: tuple[str, ...]
    repeat: str

    def __str__(self) -> str:
        return " ".join((*self.word, f"({self.repeat})*"))


def parse_address(text: str, curve: Curve) -> Address:
    """The address that a text such as `"0"`, `"1 0"` or `"0 1 (0)*"` states.

    Without `()*` the last label repeats.

    Raises `ValueError` for an empty text, an unknown label, a repeated word that is not a single label, and
    more than 200 labels.

    >>> import ifs
    >>> from fld.curve import curve
    >>> str(parse_address("1 0 0", curve(ifs.shape("koch-curve"))))
    '1 (0)*'
    """
    word, repeated = split_address(text)
    known = "the labels of this curve are " + ", ".join(curve.labels)
    if len(repeated) != 1:
        raise ValueError(
            f"the address {text.strip()!r} must repeat one label, as in "
            f"{curve.labels[-1]} ({curve.labels[0]})*; {known}"
        )
    for label in (*word, *repeated):
        if label not in curve.labels:
            raise ValueError(f"unknown label {label!r} in the address {text.strip()!r}; {known}")
    return _address(word, repeated[0])


def twin(address: Address, curve: Curve) -> Address | None:
    """The other address of a joint: the same point as the end of the piece before, or the start of the next.

    None for the two ends of the curve, and where no piece starts or ends.
    """
    first, last = curve.labels[0], curve.labels[-1]
    if not address.word or address.repeat not in (first, last):
        return None
    place = curve.labels.index(address.word[-1])
    if address.repeat == first:
        return _address((*address.word[:-1], curve.labels[place - 1]), last)
    return _address((*address.word[:-1], curve.labels[place + 1]), first)


def _address(word: tuple[str, ...], repeat: str) -> Address:
    while word and word[-1] == repeat:
        word = word[:-1]
    return Address(word, repeat)
