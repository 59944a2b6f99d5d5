"""A set of cells, deformed by a smooth random field."""

import numpy as np
from jaxtyping import Bool, Float

_MODES = 24
_OCTAVES = 2.5  # from the longest waves to the shortest


def perturbed(
    cells: Bool[np.ndarray, "x y z"], seed: int, amount: float, wave: float
) -> Bool[np.ndarray, "x y z"]:
    """Cells x where x + u(x) lies in the set; u is a displacement of `amount` cells in the mean square.

    `u(x) = sum_m a_m cos(k_m x + f_m)` over 24 waves with directions and phases drawn from the seed; lengths
    fall from `wave` cells by 2.5 octaves, amplitudes in proportion. No cell moves by more than
    `largest_move(seed, amount, wave)` cells. An `amount` of 0 changes nothing. Raises `ValueError` for an
    amount below 0, a wave that is not above 0, or a seed below 0.

    >>> block = np.zeros((12, 12, 12), dtype=bool)
    >>> block[3:9, 3:9, 3:9] = True
    >>> [bool((perturbed(block, 1, amount, 6.0) == block).all()) for amount in (0.0, 2.0)]
    [True, False]
    """
    amplitudes, waves, phases = _field(seed, amount, wave)
    axes = [np.exp(1j * np.outer(waves[:, k], np.arange(cells.shape[k]))) for k in range(3)]
    start = np.exp(1j * phases)
    result = np.zeros_like(cells)
    grid_y, grid_z = np.indices(cells.shape[1:])
    top = np.array(cells.shape) - 1
    for i in range(cells.shape[0]):
        weights = (start * axes[0][:, i])[:, None] * amplitudes
        moved = np.einsum(
            "mk,my,mz->kyz", weights, axes[1], axes[2], optimize=["einsum_path", (0, 1), (0, 1)]
        )
        places = np.rint(moved.real).astype(np.int64)
        places += np.stack([np.full_like(grid_y, i), grid_y, grid_z])
        held = np.clip(places, 0, top[:, None, None])
        result[i] = cells[tuple(held)] & (held == places).all(axis=0)
    return result


def largest_move(seed: int, amount: float, wave: float) -> float:
    """A bound, in cells, of how far `perturbed` moves anything: `sum_m |a_m|`.

    >>> 3 < largest_move(1, 3.0, 40.0) < 20
    True
    """
    return float(np.linalg.norm(_field(seed, amount, wave)[0], axis=1).sum())


def _field(
    seed: int, amount: float, wave: float
) -> tuple[Float[np.ndarray, "modes 3"], Float[np.ndarray, "modes 3"], Float[np.ndarray, "modes"]]:
    """Amplitudes, wave vectors and phases."""
    if not (np.isfinite(amount) and amount >= 0) or not (np.isfinite(wave) and wave > 0) or seed < 0:
        raise ValueError(
            f"the amount is 0 or more, the wave above 0 cells and the seed 0 or more; "
            f"found {amount}, {wave} and {seed}"
        )
    random = np.random.default_rng(seed)
    lengths = wave * 2.0 ** (-_OCTAVES * np.arange(_MODES) / (_MODES - 1))
    directions, moves = random.normal(size=(2, _MODES, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    moves *= (lengths / np.linalg.norm(moves, axis=1))[:, None]
    moves *= amount / np.sqrt((moves**2).sum() / 2)
    return moves, directions * (2 * np.pi / lengths)[:, None], random.uniform(0, 2 * np.pi, _MODES)
