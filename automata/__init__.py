"""What a shape is: cells, operators, path words, constraints; and the text files that state them."""

from automata.automaton import (
    Automaton,
    Boundary,
    Cell,
    Equation,
    Figure,
    Symmetry,
)
from automata.description import describe
from automata.error import AutomatonError
from automata.file import builtin_names, parse_text, read

__all__ = [
    "Automaton",
    "AutomatonError",
    "Boundary",
    "Cell",
    "Equation",
    "Figure",
    "Symmetry",
    "builtin_names",
    "describe",
    "parse_text",
    "read",
]
