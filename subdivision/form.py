"""Affine forms `c + sum c_i x_i` over unknowns, and sparse matrices of them."""

from collections.abc import Mapping

from subdivision.coefficients import Scalar

CONSTANT = -1
"""The key of a form's constant term; the unknowns are numbered from 0."""

Form = Mapping[int, Scalar]
Column = Mapping[int, Form]
Columns = list[Column]
"""A matrix by columns; each column holds its nonzero rows."""

ONE: Form = {CONSTANT: 1}


class Product(ArithmeticError):
    """Two unknowns are multiplied: the result is no affine form."""


def constant(value: Scalar) -> Form:
    return {CONSTANT: value} if value else {}


def is_constant(form: Form) -> bool:
    return not form or (len(form) == 1 and CONSTANT in form)


def add(left: Form, right: Form, factor: Scalar = 1) -> Form:
    """`left + factor · right`."""
    result = dict(left)
    for key, coefficient in right.items():
        total = result.get(key, 0) + factor * coefficient
        if total:
            result[key] = total
        else:
            result.pop(key, None)
    return result


def scale(form: Form, factor: Scalar) -> Form:
    if factor == 1:
        return form
    return {key: factor * coefficient for key, coefficient in form.items()}


def multiply(left: Form, right: Form) -> Form:
    """The product of two forms of which one is constant; raises `Product` otherwise."""
    if is_constant(left):
        return scale(right, left[CONSTANT]) if left else {}
    if is_constant(right):
        return scale(left, right[CONSTANT]) if right else {}
    raise Product


def matmul(left: Columns, right: Columns) -> Columns:
    """The matrix product `left · right`; raises `Product` where unknowns meet."""
    return [_combination(left, column) for column in right]


def _combination(columns: Columns, weights: Column) -> Column:
    if len(weights) == 1:
        ((row, weight),) = weights.items()
        if weight == ONE:
            return columns[row]
    result: dict[int, Form] = {}
    for row, weight in weights.items():
        for place, form in columns[row].items():
            term = multiply(form, weight)
            result[place] = add(result[place], term) if place in result else term
    return {place: form for place, form in result.items() if form}


def difference(left: Columns, right: Columns) -> list[Form]:
    """The entries of `left - right` that are not identically zero."""
    entries = []
    for first, second in zip(left, right, strict=True):
        for row in first.keys() | second.keys():
            one, other = first.get(row, {}), second.get(row, {})
            if one != other:
                entries.append(add(one, other, -1))
    return entries
