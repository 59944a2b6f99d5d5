"""What can be wrong with a map of trees."""

from trees.errors import TreeError


class SingularMatrix(TreeError):
    """A matrix of determinant 0: its image is flat, and no inverse image of the cube exists."""

    def __init__(self, rank: int, needed: int):
        self.rank, self.needed = rank, needed
        super().__init__(
            f"a homogeneous matrix of rank {rank}: rank {needed} is needed, for images are computed through "
            "the inverse; `project` projects along an axis, and `image_of_cube` draws a flattened cube"
        )


class BeyondHorizon(TreeError):
    """Points with weights of both signs, or 0: a perspective sends them to infinity or behind the eye."""

    def __init__(self, what: str, weight: float, other: float):
        self.weight, self.other = weight, other
        super().__init__(
            f"{what} has weight {weight:.6g}, and the opposite end of the set {other:.6g}: all must have one "
            "sign and none be 0, so cut the set in front of the horizon first, by `& from_half_spaces(...)`"
        )
