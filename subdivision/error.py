"""Why a description has no matrices, or not yet."""

from subdivision.coefficients import Scalar, text_of


class Contradiction(ValueError):
    """Constraints that no matrices satisfy.

    `equations` is a subset of the constraints, in the user's own words, that contradicts itself and
    none of whose members can be left out; `residual` is the number that they claim to be zero.
    """

    def __init__(self, equations: tuple[str, ...], residual: Scalar):
        self.equations = equations
        self.residual = residual
        listed = "".join(f"\n  - {equation}" for equation in equations)
        super().__init__(
            f"the constraints contradict each other (they require {text_of(residual)} = 0). These cannot "
            f"hold together, and leaving any one out removes the contradiction:{listed}"
        )


class NotLinear(ValueError):
    """Equations with products of unknowns that the linear constraints do not resolve."""

    def __init__(self, equations: tuple[str, ...]):
        self.equations = equations
        listed = "".join(f"\n  - {equation}" for equation in equations)
        super().__init__(
            "these constraints multiply unknowns with each other, and the others do not settle enough; "
            f"shorten their paths, or give one of the operators:{listed}"
        )


class WrongValue(ValueError):
    """A value for something that is not free, or for a name that does not exist."""


class Undetermined(ValueError):
    """Numbers were asked for while parameters are still free; `parameters` names them."""

    def __init__(self, parameters: tuple[str, ...]):
        self.parameters = parameters
        shown = ", ".join(parameters[:8]) + (", …" if len(parameters) > 8 else "")
        super().__init__(
            f"{len(parameters)} parameter{'s' if len(parameters) > 1 else ''} without a value: {shown}; "
            "set them under [set] in the file or with --set NAME=VALUE"
        )


class TooMuchWork(ValueError):
    """A system whose exact solution takes more steps than allowed; `limit` is their number."""

    def __init__(self, limit: int):
        self.limit = limit
        super().__init__(
            f"solving these constraints exactly takes over {limit} steps of arithmetic: use embeddings that "
            "select points, or fewer points in cells with dense embeddings"
        )
