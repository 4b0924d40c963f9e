"""A loop closure: two bodies held together where a tree of joints was cut."""

from dataclasses import dataclass

Point = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Closure:
    """One closure. Raises ValueError for an unknown type."""

    type: str
    body_a: str
    body_b: str
    p_a: Point = (0.0, 0.0, 0.0)  # in the frame of body a [m]
    p_b: Point = (0.0, 0.0, 0.0)  # in the frame of body b [m]

    def __post_init__(self) -> None:
        if self.type not in ("weld", "ball"):
            raise ValueError(f"closure type is {self.type!r}; expected weld or ball")
