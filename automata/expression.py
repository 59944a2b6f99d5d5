"""Arithmetic expressions of a description: `1/4`, `1 - a`, `(u+2v)/(2(u+v))`.

A text is parsed by the grammar below and never evaluated as code:

    sum     = ["+" | "-"] product { ("+" | "-") product }
    product = power { ["*" | "/"] power }          2v is 2*v; 1/2v is (1/2)*v
    power   = atom [ "^" ["-"] integer ]
    atom    = number | name | name "(" name {"," name} ")" | "(" sum ")"

A name directly before parentheses that hold only names, such as `a(u,v)`, is one unknown that
may depend on those parameters; `u(v+1)` is a product.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

LONGEST_TEXT = 400
DEEPEST_NESTING = 40
LARGEST_POWER = 12
LONGEST_NUMBER = 60

LARGEST_BITS = 1000
LARGEST_DEGREE = 64

_NUMBER = r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_TOKEN = re.compile(rf"\s*(?:({_NUMBER})|([A-Za-z_][A-Za-z_0-9]*)|(\S))", re.ASCII)
_DEPENDENCE = re.compile(r"\(\s*([A-Za-z_]\w*(?:\s*,\s*[A-Za-z_]\w*)*)\s*\)", re.ASCII)


class ExpressionError(ValueError):
    """A text that is no expression; `position` counts its characters from 0."""

    def __init__(self, message: str, position: int):
        super().__init__(message)
        self.position = position


@dataclass(frozen=True)
class Number:
    """An exact rational constant."""

    value: Fraction

    def __str__(self) -> str:
        return str(self.value)


@dataclass(frozen=True)
class Name:
    """A parameter."""

    name: str

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Operation:
    """`left operator right`, the operator one of `+ - * / ^`."""

    operator: str
    left: "Expression"
    right: "Expression"

    def __str__(self) -> str:
        sides = (f"({side})" if _compound(side) else str(side) for side in (self.left, self.right))
        return f" {self.operator} ".join(sides) if self.operator in "+-" else self.operator.join(sides)


Expression = Number | Name | Operation

_ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {
    "+": lambda left, right: left + right,
    "-": lambda left, right: left - right,
    "*": lambda left, right: left * right,
    "/": lambda left, right: left / right,
    "^": lambda left, right: left ** int(right),
}


def _compound(side: Expression) -> bool:
    """Whether a part of an operation is written in parentheses."""
    if isinstance(side, Number):
        return side.value < 0 or side.value.denominator != 1
    return isinstance(side, Operation)


def too_large(value: Fraction) -> bool:
    """Whether a number has over 1000 bits above or below its fraction bar; others fit into doubles."""
    return max(value.numerator.bit_length(), value.denominator.bit_length()) > LARGEST_BITS


def parse(text: str) -> Expression:
    """The expression that a text writes.

    Raises `ExpressionError` with the position of the first character that does not fit.

    >>> evaluate(parse("(u+2v)/(2(u+v))"), {"u": Fraction(1), "v": Fraction(1)})
    Fraction(3, 4)
    """
    if len(text) > LONGEST_TEXT:
        raise ExpressionError(f"an expression has at most {LONGEST_TEXT} characters", LONGEST_TEXT)
    expression = _Parser(text).whole()
    if degree(expression) > LARGEST_DEGREE:
        raise ExpressionError(f"the degree of an expression is at most {LARGEST_DEGREE}", 0)
    return expression


def number(text: str) -> Fraction:
    """The exact value of a text without parameters: `number("3/16")` is 3/16.

    Raises `ExpressionError` when the text names a parameter or is no expression.
    """
    expression = parse(text)
    free = names(expression)
    if free:
        raise ExpressionError(f"expected a number, found the name {min(free)!r}", 0)
    return evaluate(expression, {})


def names(expression: Expression) -> frozenset[str]:
    """The names that occur in an expression."""
    match expression:
        case Number():
            return frozenset()
        case Name(name):
            return frozenset([name])
        case Operation(_, left, right):
            return names(left) | names(right)


def evaluate(expression: Expression, values: Mapping[str, Any]) -> Any:
    """The value of an expression, in whatever field the values of its names belong to.

    Raises `KeyError` for a name without a value and `ZeroDivisionError`.
    """
    match expression:
        case Number(value):
            return value
        case Name(name):
            return values[name]
        case Operation(operator, left, right):
            return _ARITHMETIC[operator](evaluate(left, values), evaluate(right, values))


def degree(expression: Expression) -> int:
    """A bound on the degrees of numerator and denominator, sums being brought to one denominator."""
    match expression:
        case Number():
            return 0
        case Name():
            return 1
        case Operation("^", left, Number(power)):
            return degree(left) * abs(int(power))
        case Operation(_, left, right):
            return degree(left) + degree(right)


def substitute(expression: Expression, values: Mapping[str, Fraction]) -> Expression:
    """The expression with names replaced by numbers, and worked out where no name is left.

    Raises `ZeroDivisionError`, and `ExpressionError` for a number out of range.

    >>> str(substitute(parse("u + v/2"), {"v": Fraction(3)}))
    'u + (3/2)'
    """
    match expression:
        case Number():
            return expression
        case Name(name):
            return Number(values[name]) if name in values else expression
        case Operation(operator, left, right):
            left, right = substitute(left, values), substitute(right, values)
            if isinstance(left, Number) and isinstance(right, Number):
                value = _ARITHMETIC[operator](left.value, right.value)
                if too_large(value):
                    raise ExpressionError("the number is too large", 0)
                return Number(value)
            return Operation(operator, left, right)


class _Parser:
    """Recursive descent over the tokens; `position` is where the next token begins."""

    def __init__(self, text: str):
        self.text = text
        self.position = 0
        self.depth = 0

    def whole(self) -> Expression:
        result = self.sum()
        if self.peek():
            raise self.unexpected("an operator or the end")
        return result

    def peek(self) -> str:
        match = _TOKEN.match(self.text, self.position)
        return match.group(match.lastindex or 0) if match else ""

    def take(self) -> str:
        match = _TOKEN.match(self.text, self.position)
        assert match is not None
        self.position = match.end()
        return match.group(match.lastindex or 0)

    def next_position(self) -> int:
        """Where the next token itself begins, after any spaces."""
        match = _TOKEN.match(self.text, self.position)
        return match.start(match.lastindex or 0) if match else len(self.text)

    def unexpected(self, wanted: str) -> ExpressionError:
        found = repr(self.peek()) if self.peek() else "the end"
        return ExpressionError(f"expected {wanted}, found {found}", self.next_position())

    def sum(self) -> Expression:
        self.depth += 1
        if self.depth > DEEPEST_NESTING:
            place = self.next_position()
            raise ExpressionError(f"parentheses nest at most {DEEPEST_NESTING} deep", place)
        result: Expression
        if self.peek() in ("+", "-"):
            sign = Fraction(-1 if self.take() == "-" else 1)
            result = self.join("*", Number(sign), self.product(), self.position)
        else:
            result = self.product()
        while self.peek() in ("+", "-"):
            start = self.next_position()
            result = self.join(self.take(), result, self.product(), start)
        self.depth -= 1
        return result

    def product(self) -> Expression:
        result = self.power()
        while (token := self.peek()) and token not in ("+", "-", ")", ","):
            start = self.next_position()
            operator = self.take() if token in ("*", "/") else "*"
            result = self.join(operator, result, self.power(), start)
        return result

    def power(self) -> Expression:
        base = self.atom()
        if self.peek() != "^":
            return base
        start = self.next_position()
        self.take()
        sign = -1 if self.peek() == "-" and self.take() else 1
        if re.fullmatch("[0-9]+", self.peek()) is None:
            raise self.unexpected("a whole number as the power")
        place = self.next_position()
        power = Fraction(self.number())
        if power > LARGEST_POWER:
            raise ExpressionError(f"powers go up to {LARGEST_POWER}", place)
        return self.join("^", base, Number(sign * power), start)

    def number(self) -> Fraction:
        start = self.next_position()
        digits = self.take()
        mantissa, _, exponent = digits.lower().partition("e")
        if len(mantissa) > LONGEST_NUMBER or len(exponent.lstrip("+-")) > 3:
            raise ExpressionError(f"numbers have at most {LONGEST_NUMBER} digits", start)
        value = Fraction(digits)
        if too_large(value):
            raise ExpressionError("the number is too large", start)
        return value

    def atom(self) -> Expression:
        token = self.peek()
        if re.match(r"\.?[0-9]", token):
            return Number(self.number())
        if re.match("[A-Za-z_]", token):
            name = self.take()
            return Name(name + self.dependence())
        if token == "(":
            self.take()
            result = self.sum()
            if self.peek() != ")":
                raise self.unexpected("')'")
            self.take()
            return result
        raise self.unexpected("a number, a name or '('")

    def dependence(self) -> str:
        """The `(u,v)` of an unknown `a(u,v)`, or nothing."""
        match = _DEPENDENCE.match(self.text, self.position)
        if not match:
            return ""
        self.position = match.end()
        return "(" + ",".join(part.strip() for part in match.group(1).split(",")) + ")"

    def join(self, operator: str, left: Expression, right: Expression, place: int) -> Expression:
        """The operation, worked out at once on two numbers; faults are at the place of its operator."""
        if not (isinstance(left, Number) and isinstance(right, Number)):
            return Operation(operator, left, right)
        try:
            value = _ARITHMETIC[operator](left.value, right.value)
        except ZeroDivisionError:
            raise ExpressionError("division by zero", place) from None
        if too_large(value):
            raise ExpressionError("the number is too large", place)
        return Number(value)
