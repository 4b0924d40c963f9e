"""The machines of this package as bodies and closures, with the loops cut where their docstrings say.

Independent of the closed forms: only the parameters are shared.
"""

import numpy as np

from ..closure import Closure, Point
from .chain import Chain, Link, planar
from .five_bar import FiveBar
from .prs import Table
from .two_prr import TwoPRR


def five_bar(m: FiveBar, home: tuple[float, float] = (1.95, 1.05)) -> Chain:
    """5R, cut at the joint C of both rods; ``home`` are crank angles [rad], C on the left of A to B."""
    m1, m2, m3, m4, m5 = m.masses
    i1, i2, i3, i4 = m.inertias
    r1, r2, r3, r4 = m.centres
    half = 0.5 * m.base
    links = (
        planar("crank1", "world", "revolute", (-half, 0.0), m1, r1, i1 + m.rotors[0]),
        planar("rod2", "crank1", "revolute", (m.crank1, 0.0), m2, r2, i2),
        planar("tool", "rod2", "revolute", (m.tool, 0.0), m5),
        planar("crank4", "world", "revolute", (half, 0.0), m4, r4, i4 + m.rotors[1]),
        planar("rod3", "crank4", "revolute", (m.crank4, 0.0), m3, r3, i3),
    )
    joint = Closure(
        type="ball",
        body_a="rod2",
        body_b="rod3",
        p_a=(m.rod2, 0.0, 0.0),
        p_b=(m.rod3, 0.0, 0.0),
    )
    # Both rods lean up and inwards here; the closing iteration finds their angles.
    rods = (np.deg2rad(60.0) - home[0], np.deg2rad(120.0) - home[1])
    return Chain(
        name="five_bar",
        links=links,
        closures=(joint,),
        driven=("crank1", "crank4"),
        gravity=(0.0, -m.weight, 0.0),
        home=(home[0], rods[0], 0.0, home[1], rods[1]),
    )


def two_prr(m: TwoPRR, home: tuple[float, float] = (0.2, 0.25)) -> Chain:
    """2-PRR with parallelogram, cut where bars 4 and 5 meet the platform; ``home`` are slider positions [m]."""
    m1, m2, m3, m4, m5, m6 = m.masses
    i3, i4, i5 = m.bar_inertias
    half, turning = 0.5 * m.bar, 0.1  # sliders and platform do not turn: any inertia will do
    links = (
        planar("slider1", "world", "prismatic", mass=m1, inertia=turning),
        planar("bar3", "slider1", "revolute", mass=m3, centre=half, inertia=i3),
        planar("platform", "bar3", "revolute", (m.bar, 0.0), mass=m6, inertia=turning),
        planar("bar4", "slider1", "revolute", (m.offset, 0.0), m4, half, i4),
        planar("slider2", "world", "prismatic", (m.span, 0.0), m2, 0.0, turning, -1.0),
        planar("bar5", "slider2", "revolute", mass=m5, centre=half, inertia=i5),
    )
    tip, joint = (m.bar, 0.0, 0.0), (m.offset, 0.0, 0.0)
    shut = tuple(
        Closure(type="ball", body_a=bar, body_b="platform", p_a=tip, p_b=joint)
        for bar in ("bar4", "bar5")
    )
    alpha = np.deg2rad(50.0)
    return Chain(
        name="two_prr",
        links=links,
        closures=shut,
        driven=("slider1", "slider2"),
        gravity=(0.0, -m.weight, 0.0),
        home=(home[0], -alpha, alpha, -alpha, home[1], np.pi + alpha),
    )


def mast(table: Table, name: str = "mast") -> Chain:
    """2PRU-1PRS: platform on the universal joint of leg 1, welded to that of leg 3, ball on leg 2."""
    (e1, e2, e3), (t1, _, _) = table.radial, table.across
    slope = _home_slope(table)
    links = (
        *_leg(1, table),
        Link(name="cross1", parent="bar1", kind="revolute", at=_p(-table.bar * e1), axis=_p(t1)),
        _platform("cross1", (0.0, 0.0, 0.0), table, kind="revolute"),
        *_leg(2, table),
        *_leg(3, table),
        Link(name="cross3", parent="bar3", kind="revolute", at=_p(-table.bar * e3), axis=_p(t1)),
        Link(name="end3", parent="cross3", kind="revolute", axis=_p(e1)),
    )
    arms = table.radius * table.radial - table.radius * e1
    shut = (
        Closure(
            type="ball", body_a="bar2", body_b="platform", p_a=_p(-table.bar * e2), p_b=_p(arms[1])
        ),
        Closure(type="weld", body_a="end3", body_b="platform", p_b=_p(arms[2])),
    )
    return Chain(
        name=name,
        links=links,
        closures=shut,
        driven=("carriage1", "carriage2", "carriage3"),
        gravity=(0.0, 0.0, -table.weight),
        home=(0.0, slope, -slope, 0.0, 0.0, slope, 0.0, slope, slope, 0.0),
    )


def three_prs(table: Table, name: str = "three_prs") -> Chain:
    """3-PRS: platform on the spherical joint of leg 1, balls on legs 2 and 3."""
    e = table.radial
    arms = table.radius * (e - e[0])
    slope = _home_slope(table)
    links = (
        *_leg(1, table),
        _platform("bar1", _p(-table.bar * e[0]), table, kind="ball"),
        *_leg(2, table),
        *_leg(3, table),
    )
    shut = tuple(
        Closure(
            type="ball",
            body_a=f"bar{i + 1}",
            body_b="platform",
            p_a=_p(-table.bar * e[i]),
            p_b=_p(arms[i]),
        )
        for i in (1, 2)
    )
    return Chain(
        name=name,
        links=links,
        closures=shut,
        driven=("carriage1", "carriage2", "carriage3"),
        gravity=(0.0, 0.0, -table.weight),
        home=(0.0, slope, 0.0, -slope, 0.0, 0.0, slope, 0.0, slope),
    )


def _leg(number: int, table: Table) -> tuple[Link, Link]:
    e, t, d = (rows[number - 1] for rows in (table.radial, table.across, table.along))
    i = table.bar_inertia
    carriage = Link(
        name=f"carriage{number}",
        parent="world",
        kind="prismatic",
        at=_p(table.start * e),
        axis=_p(d),
        mass=table.carriage_mass,
    )
    # Slender: turning in the leg's plane alone enters; any direction of the bar has the same inertia there.
    bar = Link(
        name=f"bar{number}",
        parent=carriage.name,
        kind="revolute",
        axis=_p(t),
        mass=table.bar_mass,
        centre=_p(-0.5 * table.bar * e),
        inertia=(i, i, i, 0.0, 0.0, 0.0),
    )
    return carriage, bar


def _platform(parent: str, at: Point, table: Table, kind: str) -> Link:
    centre = np.array(table.platform_centre) - table.radius * table.radial[0]
    return Link(
        name="platform",
        parent=parent,
        kind=kind,
        at=at,
        axis=_p(table.radial[0]),
        mass=table.platform_mass,
        centre=_p(centre),
        inertia=table.platform_inertia,
    )


def _home_slope(table: Table) -> float:
    """Slope of all bars with the platform level."""
    return float(np.arcsin(table.home / table.bar))


def _p(vector) -> Point:  # type: ignore[no-untyped-def]
    x, y, z = (float(value) for value in vector)
    return x, y, z
