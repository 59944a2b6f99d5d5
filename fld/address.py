"""Addresses of points of a curve: a finite word, then another one repeated for ever."""

from fld.curve import Curve
from ifs.orbits.addresses import Address, address, split_address

__all__ = ["Address", "address", "parse_address", "twin"]


def parse_address(text: str, curve: Curve) -> Address:
    """The address that a text such as `"0"`, `"1 0"`, `"0 1 (0)*"` or `"2 (0 1)*"` states, in normal form.

    Without `()*` the last label repeats. Raises `ValueError` for an empty text, an unknown label, and more
    than 200 labels.

    >>> import ifs
    >>> from fld.curve import curve
    >>> str(parse_address("1 0 0", curve(ifs.shape("koch-curve"))))
    '1 (0)*'
    """
    known = "the labels of this curve are " + ", ".join(curve.labels)
    try:
        word, repeated = split_address(text)
    except ValueError as error:
        raise ValueError(f"{error}; {known}") from None
    for label in (*word, *repeated):
        if label not in curve.labels:
            raise ValueError(f"unknown label {label!r} in the address {text.strip()!r}; {known}")
    return address(word, repeated)


def twin(where: Address, curve: Curve) -> Address | None:
    """The other address of a joint: the same point as the end of the piece before, or the start of the next.

    None for the two ends of the curve, and where no piece starts or ends.
    """
    first, last = curve.labels[0], curve.labels[-1]
    if not where.word or where.repeat not in ((first,), (last,)):
        return None
    place = curve.labels.index(where.word[-1])
    if where.repeat == (first,):
        return address((*where.word[:-1], curve.labels[place - 1]), (last,))
    return address((*where.word[:-1], curve.labels[place + 1]), (first,))
