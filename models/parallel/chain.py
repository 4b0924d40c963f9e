"""A closed chain described by its bodies and closures: what any machine needs for dynamics and identification.

A tree of links, each on one joint of its parent, and closures that hold the cut loops together. Link frames are
parallel to W where all coordinates are zero. ``systems.closed_chain`` makes a plant of it, ``sdf`` a file; ``analysis.identification.machine.of_chain`` and ``study.run``
identify it, as ``analysis.examples.own_closed_chain`` does with a four-bar.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from ..closure import Closure, Point

KINDS = ("revolute", "prismatic", "ball")
Entries = tuple[float, float, float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class Link:
    """A body on a joint; its frame lies in the joint. Raises ValueError for an unknown kind."""

    name: str
    parent: str  # "world" or an earlier link
    kind: str  # of KINDS
    at: Point = (0.0, 0.0, 0.0)  # of the joint, in the parent's frame [m]
    axis: Point = (0.0, 0.0, 1.0)  # of revolute and prismatic joints, of length one
    mass: float = 0.0  # [kg]
    centre: Point = (0.0, 0.0, 0.0)  # of mass, in the link's frame [m]
    inertia: Entries = (0.0,) * 6  # xx yy zz xy xz yz about the centre [kg m^2]

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"{self.name}: joint {self.kind!r}; expected one of {KINDS}")


@dataclass(frozen=True, kw_only=True)
class Chain:
    """Links from the base outwards, closures, driven joints, gravity. Raises ValueError for unknown names."""

    name: str
    links: tuple[Link, ...]
    closures: tuple[Closure, ...]
    driven: tuple[str, ...]  # joints, named after their links
    gravity: Point  # [m/s^2]
    home: tuple[
        float, ...
    ]  # coordinates near a closed posture, in order of links; a ball has roll, pitch, yaw

    def __post_init__(self) -> None:
        known = {"world"}
        for link in self.links:
            if link.parent not in known:
                raise ValueError(
                    f"{link.name}: parent {link.parent!r}; expected one of {sorted(known)}"
                )
            known.add(link.name)
        named = [*self.driven, *(b for c in self.closures for b in (c.body_a, c.body_b))]
        for name in named:
            if name not in known:
                raise ValueError(f"unknown link {name!r}; expected one of {sorted(known)}")


def planar(
    name: str,
    parent: str,
    kind: str,
    at: Sequence[float] = (0.0, 0.0),
    mass: float = 0.0,
    centre: float = 0.0,
    inertia: float = 0.0,
    direction: float = 1.0,
) -> Link:
    """Link in the plane xy: revolute about z or prismatic along x, centre of mass on its x axis.

    Only zz [kg m^2] enters planar motion; xx and yz are those of a body without depth, so that the tensor is valid.
    """
    axis = (0.0, 0.0, direction) if kind == "revolute" else (direction, 0.0, 0.0)
    tensor = (0.5 * inertia, 0.5 * inertia, inertia, 0.0, 0.0, 0.0)
    return Link(
        name=name,
        parent=parent,
        kind=kind,
        at=(at[0], at[1], 0.0),
        axis=axis,
        mass=mass,
        centre=(centre, 0.0, 0.0),
        inertia=tensor,
    )
