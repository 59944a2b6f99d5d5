"""Families of operators as LaTeX: one align block of matrices."""

import re
from fractions import Fraction

from automata.expression import Expression, Name, Number, Operation, parse
from subdivision.display import as_data
from subdivision.solution import Solution

_INDEXED = re.compile(r"([A-Za-z]+)_?(\d+)")
_SUM, _PRODUCT, _ATOM = range(3)


def as_latex(solution: Solution) -> str:
    r"""All operators of a family, for a document with the package amsmath.

    Each is a pmatrix with fractions; parameters that end in digits get them as an index. The operator of
    sub-cell i of cell x is written `T^{\mathrm{x}}_{i}`. Source: Gentil 2010, figure 4.11.

    >>> import automata, subdivision
    >>> print(as_latex(subdivision.solve(automata.read("corner-cutting"))).splitlines()[1])
    T^{\mathrm{vertex}}_{s} &= \begin{pmatrix}
    """
    blocks = []
    for cell, table in as_data(solution)["matrices"].items():
        for label, rows in table.items():
            body = " \\\\\n".join("  " + " & ".join(entry_latex(text) for text in row) for row in rows)
            head = f"T^{{{_label(cell)}}}_{{{_label(label)}}}"
            blocks.append(f"{head} &= \\begin{{pmatrix}}\n{body}\n\\end{{pmatrix}}")
    return "\\begin{align*}\n" + " \\\\\n".join(blocks) + "\n\\end{align*}\n"


def entry_latex(text: str) -> str:
    r"""An expression of the description's grammar in LaTeX.

    Raises `automata.expression.ExpressionError` for a text that is none.

    >>> entry_latex("1 - 3a/2"), entry_latex("(u+2v)/(2(u+v))"), entry_latex("-1/4"), entry_latex("p12")
    ('1 - \\frac{3 a}{2}', '\\frac{u + 2 v}{2 (u + v)}', '-\\frac{1}{4}', 'p_{12}')
    """
    return _typeset(parse(text))[0]


def _typeset(expression: Expression) -> tuple[str, int]:
    """The LaTeX text, and how tightly it holds together."""
    match expression:
        case Number(value):
            return _number(value), _ATOM if value >= 0 else _SUM
        case Name(name):
            return _name(name), _ATOM
        case Operation("+" | "-" as sign, left, right):
            return f"{_typeset(left)[0]} {sign} {_held(right, _PRODUCT)}", _SUM
        case Operation("*", Number(value), right) if value == -1:
            return "-" + _held(right, _PRODUCT), _SUM
        case Operation("*", left, right):
            between = r" \cdot " if isinstance(right, Number) else " "
            return _held(left, _PRODUCT) + between + _held(right, _PRODUCT), _PRODUCT
        case Operation("/", left, right):
            top, tight = _typeset(left)
            if top.startswith("-") and tight == _SUM and not isinstance(left, Operation):
                return f"-\\frac{{{top[1:]}}}{{{_typeset(right)[0]}}}", _SUM
            return f"\\frac{{{top}}}{{{_typeset(right)[0]}}}", _PRODUCT
        case Operation(_, left, right):
            return f"{{{_held(left, _ATOM)}}}^{{{_typeset(right)[0]}}}", _ATOM
    raise AssertionError(expression)


def _held(expression: Expression, least: int) -> str:
    text, tight = _typeset(expression)
    return text if tight >= least else f"({text})"


def _number(value: Fraction) -> str:
    if value.denominator == 1:
        return str(value)
    sign = "-" if value < 0 else ""
    return f"{sign}\\frac{{{abs(value.numerator)}}}{{{value.denominator}}}"


def _name(name: str) -> str:
    """A parameter: `p12` is p with the index 12, longer words are upright, `a(u,v)` keeps its arguments."""
    word, parenthesis, arguments = name.partition("(")
    parts = arguments.rstrip(")").split(",") if parenthesis else []
    rest = f"({', '.join(_name(part) for part in parts)})" if parts else ""
    indexed = _INDEXED.fullmatch(word)
    base, index = (indexed[1], f"_{{{indexed[2]}}}") if indexed else (word, "")
    return _label(base) + index + rest


def _label(text: str) -> str:
    return text if len(text) == 1 or text.isdigit() else f"\\mathrm{{{_upright(text)}}}"


def _upright(text: str) -> str:
    """Text inside `mathrm`, with what LaTeX would take as commands escaped."""
    return re.sub(r"([_#$%&{}])", r"\\\1", text)
