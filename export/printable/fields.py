"""Distance fields that follow a part through its changes."""

import itertools

import numpy as np
from jaxtyping import Bool, Float, Int

from export.meshing.skin import Field
from export.printable.fitting import Turn
from trees import Tree

HALF = 0.5
LEAST = 0.05  # pitches: no nearer to 0 than that where the field is replaced
BESIDE = np.array([step for step in itertools.product((-1, 0, 1), repeat=3) if np.abs(step).sum() == 1])


def turned_field(field: Field, tree: Tree, turn: Turn) -> Field:
    """The field of a part that was turned about the middle of its cube: see `export.printable.turned`."""
    middle = np.array(tree.origin) + tree.size / 2
    matrix = np.array(turn, dtype=np.float64)
    return lambda places: field(middle + (places - middle) @ matrix)


def agreeing(field: Field, tree: Tree) -> Field:
    """A field that is at most 0 in the black cells of a tree and above 0 elsewhere.

    Where the field is so already, it stays. At the centre of another cell it becomes, with the sign that it
    should have, as large as it is on average at the centres of the cells across faces on the other side of
    the surface: the surface then lies about half-way; half a cell where there are none to go by.
    """

    def agreed(places: Float[np.ndarray, "places 3"]) -> Float[np.ndarray, " places"]:
        values = np.array(field(places), dtype=np.float64)
        inside = _holds(tree, places)
        wrong = np.flatnonzero((values <= 0) != inside)
        if len(wrong):
            size = _sizes_across(field, tree, places[wrong], inside[wrong])
            values[wrong] = np.where(inside[wrong], -size, size)
        return values

    return agreed


def _sizes_across(
    field: Field, tree: Tree, places: Float[np.ndarray, "_n 3"], inside: Bool[np.ndarray, " _n"]
) -> Float[np.ndarray, " _n"]:
    around = (places[:, None] + BESIDE * tree.cell_size).reshape(-1, 3)
    values = np.asarray(field(around), dtype=np.float64)
    black = _holds(tree, around)
    good = (black != np.repeat(inside, len(BESIDE))) & ((values <= 0) == black) & np.isfinite(values)
    good, values = good.reshape(len(places), -1), np.abs(values).reshape(len(places), -1)
    count = good.sum(axis=1)
    mean = np.where(good, values, 0.0).sum(axis=1) / np.maximum(count, 1)
    return np.where(count > 0, np.maximum(mean, LEAST * tree.cell_size), HALF * tree.cell_size)


def _holds(tree: Tree, places: Float[np.ndarray, "_n 3"]) -> Bool[np.ndarray, " _n"]:
    cells: Int[np.ndarray, "_n 3"] = np.rint((places - np.array(tree.origin)) / tree.cell_size - 0.5).astype(
        np.int64
    )
    return tree.holds_cells(cells)
