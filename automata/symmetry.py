"""The symmetry group of a cell, and how its elements move past the labels of a path.

An element is a permutation p of the cell's control points, its matrix having the 1 of column j in row p[j],
so that the product of g and h is the permutation j -> g[h[j]]. Past a label it changes both:
`g T_i = T_i' g'`.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from automata.automaton import Automaton, Cell, Word
from automata.error import AutomatonError

LARGEST_GROUP = 1152
MOST_IMAGES = 100_000

Permutation = tuple[int, ...]
Image = tuple[str, Permutation]


@dataclass(frozen=True)
class Groups:
    """For each cell, its elements; each element maps a label to the label and element after it."""

    automaton: Automaton
    elements: Mapping[str, Mapping[Permutation, Mapping[str, Image]]]

    def identity(self, cell: str) -> Permutation:
        return tuple(range(self.automaton.cells[cell].points))

    def normal(self, cell: str, word: Word, element: Permutation | None = None) -> tuple[Word, Permutation]:
        """The path `element word` with every symmetry moved to its end: labels, and the last element."""
        element = element or self.identity(cell)
        labels = []
        for label in word:
            symmetry = self.automaton.cells[cell].symmetry.get(label)
            if symmetry:
                element = compose(element, symmetry.points)
                continue
            image, element = self.elements[cell][element][label]
            labels.append(image)
            target = self.automaton.target(cell, label)
            assert target is not None
            cell = target
        return tuple(labels), element


def compose(first: Permutation, second: Permutation) -> Permutation:
    """The permutation of the matrix product `first · second`."""
    return tuple(first[i] for i in second)


def inverse(element: Permutation) -> Permutation:
    result = [0] * len(element)
    for i, image in enumerate(element):
        result[image] = i
    return tuple(result)


def symmetry_groups(automaton: Automaton) -> Groups:
    """The groups that the declared symmetries generate.

    Raises `AutomatonError` when a symmetry leaves out a label whose image it must state, or when the group
    has more than 1152 elements.
    """
    elements = {name: _closure(automaton, cell) for name, cell in automaton.cells.items()}
    return Groups(automaton, elements)


def _closure(automaton: Automaton, cell: Cell) -> dict[Permutation, dict[str, Image]]:
    generators = {s.points: _images(automaton, cell, name) for name, s in cell.symmetry.items()}
    identity: Permutation = tuple(range(cell.points))
    unmoved: dict[str, Image] = {}
    for label in [*cell.subdivision, *cell.boundary]:
        target = automaton.target(cell.name, label)
        assert target is not None
        unmoved[label] = (label, tuple(range(automaton.cells[target].points)))
    found = {identity: unmoved}
    queue = [identity]
    for element in queue:
        for generator, moves in generators.items():
            product = compose(generator, element)
            if product in found:
                continue
            if len(found) >= LARGEST_GROUP:
                path = ("cells", cell.name, "symmetry")
                raise AutomatonError(f"the symmetries have over {LARGEST_GROUP} products", path=path)
            if len(found) * len(unmoved) > MOST_IMAGES:
                path = ("cells", cell.name, "symmetry")
                raise AutomatonError(f"the symmetries have over {MOST_IMAGES} images of labels", path=path)
            found[product] = {
                label: (moves[image][0], compose(moves[image][1], after))
                for label, (image, after) in found[element].items()
            }
            queue.append(product)
    return found


def _images(automaton: Automaton, cell: Cell, name: str) -> dict[str, Image]:
    symmetry = cell.symmetry[name]
    path = ("cells", cell.name, "symmetry", name)
    images: dict[str, Image] = {}
    for kind, labels in (("subdivision", cell.subdivision), ("boundary", cell.boundary)):
        stated = getattr(symmetry, kind)
        for label in labels:
            if label not in stated:
                raise AutomatonError(
                    f"state where the symmetry takes {label!r}: {kind} = {{ {label} = … }}", path=path
                )
            images[label] = _image(automaton, cell, labels, stated[label], (*path, kind, label))
    return images


def _image(automaton: Automaton, cell: Cell, labels, word: Word, path: tuple) -> Image:
    label, *symmetries = word
    if label not in labels:
        raise AutomatonError(f"expected one of {', '.join(labels)} first, found {label!r}", path=path)
    target = automaton.target(cell.name, label)
    assert target is not None
    element: Permutation = tuple(range(automaton.cells[target].points))
    for symmetry in symmetries:
        known = automaton.cells[target].symmetry
        if symmetry not in known:
            raise AutomatonError(f"cell {target!r} has no symmetry {symmetry!r}", path=path)
        element = compose(element, known[symmetry].points)
    return label, element
