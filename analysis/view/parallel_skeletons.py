"""Skeletons of the parallel machines: five-bars, the 2-PRR, and tables on three legs."""

from typing import Any

import numpy as np

from ...models.parallel import five_bar, prs, two_prr
from ...models.parallel.five_bar import FiveBar
from ...models.parallel.mast import MAST
from ...models.parallel.prs import Table
from ...models.parallel.replalink import REPLALINK
from ...models.parallel.three_prs import THREE_PRS
from ...models.parallel.two_prr import TwoPRR
from .skeletons import Coordinate, Floats, Skeleton

# Cranks to begin with and their sliders' way from there [rad], and how far off one looks [m].
SIGHTS = {"5r": ((1.95, 1.05), 1.0, 1.7), "replalink": ((2.0, 1.15), 0.7, 1.5)}


def five_bar_5r() -> Skeleton:
    """The five-bar of section 4.1."""
    return linkage("5r", FiveBar())


def replalink() -> Skeleton:
    """RePlaLink, whose tool lies beyond the joint of its rods."""
    return linkage("replalink", REPLALINK)


def linkage(name: str, machine: FiveBar) -> Skeleton:
    """A five-bar called ``5r`` or ``replalink`` with the lengths of ``machine``."""
    start, span, away = SIGHTS[name]

    def along(angle: Any) -> Floats:
        return np.array([np.cos(angle), np.sin(angle), 0.0])

    def place(values: Floats) -> dict[str, Floats]:
        posture = five_bar.forward(values, machine)
        a0 = np.array([-0.5 * machine.base, 0.0, 0.0])
        a = a0 + machine.crank1 * along(values[0])
        b = -a0 + machine.crank4 * along(values[1])
        long = max(machine.rod2, machine.tool)
        return {
            "crank 1": np.stack([a0, a]),
            "crank 4": np.stack([-a0, b]),
            "rod 2": np.stack([a, a + long * along(posture.angle2)]),
            "rod 3": np.stack([b, b + machine.rod3 * along(posture.angle3)]),
            "A": a,
            "B": b,
            "tool": np.array([*posture.tool, 0.0]),
            "motor 1": a0,
            "motor 4": -a0,
        }

    return Skeleton(
        name=name,
        coordinates=tuple(
            Coordinate(name=f"crank q{i}", unit="rad", low=q - span, high=q + span, start=q)
            for i, q in zip((1, 4), start)
        ),
        rods={"crank 1": 0.02, "crank 4": 0.02, "rod 2": 0.015, "rod 3": 0.015},
        balls={"A": 0.025, "B": 0.025, "tool": 0.035, "motor 1": 0.045, "motor 4": 0.045},
        place=place,
        camera=(0.0, -0.6, away),
        centre=(0.0, 0.5, 0.0),
    )


def slider_pair(machine: TwoPRR | None = None) -> Skeleton:
    """2-PRR: two sliders on one guide, the platform below held by a parallelogram."""
    machine = machine or TwoPRR()

    def place(values: Floats) -> dict[str, Floats]:
        x, y = two_prr.forward(values, machine)
        first = np.array([values[0], 0.0, 0.0])
        second = np.array([machine.span - values[1], 0.0, 0.0])
        joint = np.array([x, y, 0.0])
        beside = np.array([machine.offset, 0.0, 0.0])
        return {
            "guide": np.array([[-0.1, 0.0, 0.0], [machine.span + 0.1, 0.0, 0.0]]),
            "bar 3": np.stack([first, joint - beside]),
            "bar 4": np.stack([first + beside, joint]),
            "bar 5": np.stack([second, joint]),
            "slider 1": np.stack([first, first + beside]),
            "platform": np.stack([joint - beside, joint]),
            "slider 2": second,
            "joint": joint,
        }

    return Skeleton(
        name="2prr",
        coordinates=tuple(
            Coordinate(name=f"slider {i}", unit="m", low=low, high=0.35, start=start)
            for i, low, start in ((1, 0.002, 0.2), (2, 0.047, 0.25))
        ),
        rods={"guide": 0.012, "bar 3": 0.012, "bar 4": 0.012, "bar 5": 0.012, "slider 1": 0.035,
              "platform": 0.025},
        balls={"slider 2": 0.045, "joint": 0.03},
        place=place,
        camera=(0.65, -0.4, 1.4),
        centre=(0.65, -0.3, 0.0),
    )  # fmt: skip


def mast() -> Skeleton:
    """2PRU-1PRS table, sliders vertical."""
    return _table("mast", MAST, 0.06, (0.7, -0.7, 0.6))


def three_prs() -> Skeleton:
    """3-PRS table on flexures, sliders radial."""
    return _table("3prs", THREE_PRS, 0.002, (0.19, -0.19, 0.16))


def _table(name: str, table: Table, reach: float, camera: tuple[float, float, float]) -> Skeleton:
    feet = table.start * table.radial  # (3, 3)

    def place(values: Floats) -> dict[str, Floats]:
        posed = prs.pose(prs.forward(values, table), table)
        sliders = feet + np.asarray(values)[:, None] * table.along
        parts = {}
        for i in range(3):
            ends = feet[i] + np.outer([-1.0, 1.0], table.along[i]) * (reach + 0.15 * table.start)
            parts[f"guide {i + 1}"] = ends
            parts[f"bar {i + 1}"] = np.stack([sliders[i], posed.joints[i]])
            parts[f"platform {i + 1}"] = np.stack([posed.position, posed.joints[i]])
            parts[f"slider {i + 1}"] = sliders[i]
            parts[f"joint {i + 1}"] = posed.joints[i]
        return {**parts, "centre": posed.position}

    thick = 0.03 * table.bar
    legs = (1, 2, 3)
    return Skeleton(
        name=name,
        coordinates=tuple(
            Coordinate(name=f"slider {i}", unit="m", low=-reach, high=reach, start=0.0)
            for i in legs
        ),
        rods={
            **{f"guide {i}": thick for i in legs},
            **{f"bar {i}": thick for i in legs},
            **{f"platform {i}": 1.5 * thick for i in legs},
        },
        balls={
            **{f"slider {i}": 2.5 * thick for i in legs},
            **{f"joint {i}": 1.8 * thick for i in legs},
            "centre": 2.0 * thick,
        },
        place=place,
        camera=camera,
        centre=(0.0, 0.0, 0.5 * table.home),
    )
