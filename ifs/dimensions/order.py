"""The critical order of moduli, and the parts of the parameter interval that go with it."""

import math
from collections.abc import Mapping, Sequence

import numpy as np


def solved_order(moduli: Sequence[float]) -> float:
    """alpha with `sum_i moduli_i^(1/alpha) = 1`, for two moduli or more in ]0, 1[.

    The sum falls as 1/alpha grows, and the solution lies between those of the extreme moduli alone.
    Source: Gentil 2010, equation 4.4.

    >>> round(solved_order([1 / 2, 1 / 4]), 12) == round(math.log(2) / math.log((1 + 5**0.5) / 2), 12)
    True
    """
    from scipy.optimize import brentq

    count = math.log(len(moduli))
    low, high = (count / -math.log(modulus) for modulus in (min(moduli), max(moduli)))
    if high - low <= 1e-14 * high:
        return 1 / high
    exponent = brentq(
        lambda s: math.fsum(modulus**s for modulus in moduli) - 1,
        low * (1 - 1e-9),
        high * (1 + 1e-9),
        xtol=1e-15,
    )
    return 1 / float(np.real(np.asarray(exponent)))


def ratios(moduli: Mapping[str, float]) -> dict[str, float]:
    """`r_i = moduli_i^(1/alpha)`, which sum to 1.

    >>> {label: round(part, 12) for label, part in ratios({"0": 0.5, "1": 0.5}).items()}
    {'0': 0.5, '1': 0.5}
    """
    order = solved_order(list(moduli.values()))
    return {label: modulus ** (1 / order) for label, modulus in moduli.items()}
