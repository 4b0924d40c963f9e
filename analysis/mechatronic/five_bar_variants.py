"""Which assumption moves the five-bar's printed numbers, and how far: one changed at a time (Roldan, section 4.1.4).

Height of the X move, centre and acceleration of the circles, feed-forward and low-pass of the position loop are not
printed. The joints lag by the position loop alone here; the velocity loop and all inside it count as instantaneous.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ...diagrams.five_bar_loop import CENTRE, GAINS, HEIGHT, MOTIONS, FiveBarLoop
from ...models import control
from ...models.paths import Circle, Line

Floats = NDArray[np.float64]

TURN = 2.0 * np.pi
PRINTED = 22.0  # X move, off the path [mm]


class Circled(NamedTuple):
    """What is printed of the model on a circle, read there from Figs. 4.9 and 4.10."""

    error: float  # of a joint [motor turns]
    lag: float  # of the velocity [s]


CIRCLES = {"circle": Circled(0.25, 0.1), "fast-circle": Circled(0.3, 0.25)}


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What a variant assumes; defaults are the diagram's."""

    feedforward: float = FiveBarLoop().feedforward  # [-]
    filter_time: float = 0.0  # of the position loop's low-pass [s]
    height: float = HEIGHT  # of the X move [m]
    centre: float = CENTRE[1]  # y of the circles [m]
    acceleration: float | None = None  # along the circles, by default the diagram's [m/s^2]
    turns: float | None = None  # of the circles, by default the diagram's


@dataclass(frozen=True, kw_only=True)
class Variant:
    """The three printed numbers under one setting."""

    name: str
    off_path: float  # X move [mm]
    circle: float  # joint error [motor turns]
    fast_circle: float  # the same at twice the feed


SETTINGS = {
    "as assumed": Setting(),
    "no feed-forward": Setting(feedforward=0.0),
    "feed-forward of 0.3": Setting(feedforward=0.3),
    "feed-forward of 0.5": Setting(feedforward=0.5),
    "low-pass of 20 ms": Setting(filter_time=0.02),
    "low-pass of 20 ms, no feed-forward": Setting(filter_time=0.02, feedforward=0.0),
    "X move at y = 0.7 m, circles about y = 0.7 m": Setting(height=0.7, centre=0.7),
    "X move at y = 1.05 m, circles about y = 0.9 m": Setting(height=1.05, centre=0.9),
    "0.8 m/s^2 along the circles": Setting(acceleration=0.8),
    "5 m/s^2 along the circles": Setting(acceleration=5.0),
    "two turns of the circles": Setting(turns=2.0),
    "no feed-forward, X move at y = 1.05 m": Setting(feedforward=0.0, height=1.05),
}


def variants() -> list[Variant]:
    """All of SETTINGS."""
    return [_variant(name, setting) for name, setting in SETTINGS.items()]


def deviation(path: Line, gain: float, feedforward: float, filter_time: float = 0.0) -> float:
    """Largest distance of the tool from a line along x [mm]; within 0.1 mm of the diagram at the printed gain.

    ``gain`` k_v [1/s]; ``feedforward`` is a share of the joints' rate [-]. NaN out of reach.
    """
    _, _, joints = _lag(path, gain, feedforward, filter_time)
    tool = FiveBarLoop().machine.forward(joints)
    return 1e3 * float(np.abs(tool[:, 1] - path.start[1]).max())


def joint_error(
    path: Line | Circle, gain: float, feedforward: float, filter_time: float = 0.0
) -> float:
    """Largest error of a joint [motor turns]; within 0.02 of the diagram on the printed circles."""
    wanted, _, joints = _lag(path, gain, feedforward, filter_time)
    return float(np.abs(wanted - joints).max()) / FiveBarLoop().axis.per_motor / TURN


def peak_rate(path: Line | Circle) -> float:
    """Largest rate of a motor [turns/s]."""
    _, rates, _ = _lag(path, 1.0, 0.0, 0.0)
    return float(np.abs(rates).max()) / FiveBarLoop().axis.per_motor / TURN


def least_error(path: Circle, gain: float) -> float:
    """Joint error below which no full circle at its feed stays without feed-forward, wherever it lies [motor turns].

    Along rod 2 the tool is as fast as its crank's end at most; on a circle it goes that way at full feed once, so that a
    crank turns at feed / l_1 at least.
    """
    loop = FiveBarLoop()
    return path.feed / loop.machine.geometry.crank1 / gain / loop.axis.per_motor / TURN


def feedforward_as_printed(path: Line, gain: float) -> float:
    """Share of feed-forward at which the move deviates by the printed 22 mm."""
    return float(brentq(lambda f: deviation(path, gain, f) - PRINTED, 0.0, 1.0, xtol=1e-3))


def _variant(name: str, s: Setting) -> Variant:
    line, errors = MOTIONS["x-move"], []
    assert isinstance(line, Line)
    moved = replace(line, start=(line.start[0], s.height), end=(line.end[0], s.height))
    for motion in CIRCLES:
        path = MOTIONS[motion]
        assert isinstance(path, Circle)
        path = replace(
            path,
            centre=(path.centre[0], s.centre),
            acceleration=s.acceleration or path.acceleration,
            turns=s.turns or path.turns,
        )
        errors.append(joint_error(path, GAINS[motion], s.feedforward, s.filter_time))
    off = deviation(moved, GAINS["x-move"], s.feedforward, s.filter_time)
    return Variant(name=name, off_path=off, circle=errors[0], fast_circle=errors[1])


def _lag(
    path: Line | Circle, gain: float, feedforward: float, filter_time: float
) -> tuple[Floats, Floats, Floats]:
    """Joints wanted, their rates, and the joints that lag behind them (samples, 2) [rad]."""
    loop = FiveBarLoop()
    period = loop.position_period
    t = period * np.arange(int(path.duration / period))
    wanted = loop.machine.inverse(path.sample(t)[0])
    rates = np.gradient(wanted, period, axis=0)
    decay = control.derivative_decay(1.0 / filter_time, period) if filter_time else 0.0
    joints, asked = np.empty_like(wanted), np.zeros(2)
    joints[0] = wanted[0]
    for k in range(len(t) - 1):
        new = gain * (wanted[k] - joints[k]) + feedforward * rates[k]
        asked = control.low_pass(new, asked, decay)
        joints[k + 1] = joints[k] + period * asked
    return wanted, rates, joints
