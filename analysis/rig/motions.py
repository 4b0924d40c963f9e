"""The motions of the rig as generators of setpoints, one a sample, in motor coordinates."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from .machine import Floats, Layout, Trajectory
from .setpoints import Ramp, rest_to_rest

SEARCH, CREEP = 0.5, 0.02  # speeds of homing, as shares of the axis's speed
SETTLE = 0.3  # standing still before a trajectory and after homing [s]
TOO_FAR = 1.5  # travel of a search for a switch, as share of the distance of the switches

Pressed = Callable[[], frozenset[tuple[int, int]]]  # (axis, -1 or +1) of the switches


class Lost(RuntimeError):
    """A switch was not found where it must be."""


@dataclass(frozen=True)
class Setpoint:
    """What to follow during the next sample."""

    reference: Floats  # (motors,)
    acceleration: Floats
    record: bool = False  # this sample belongs to the log
    wake: bool = False  # start the controller afresh first


def ramp(layout: Layout, state: Ramp) -> Iterator[Setpoint]:
    """Follow a ramp in the axes until it is at rest."""
    while True:
        yield _along(layout, state)
        if state.at_rest:
            return


def executing(layout: Layout, reading: Floats, trajectory: Trajectory) -> Iterator[Setpoint]:
    """Approach the start, settle, then the trajectory, whose samples are recorded."""
    start = trajectory.position[0]
    yield from _approach(layout, reading, start)
    for k, (reference, acceleration) in enumerate(
        zip(trajectory.position, trajectory.acceleration)
    ):
        yield Setpoint(reference, acceleration, record=True, wake=k == 0)


def homing(
    layout: Layout,
    reading: Callable[[], Floats],
    preset: Callable[[Floats], None],
    pressed: Pressed,
) -> Iterator[Setpoint]:
    """Find the negative switch of each axis, set its position there, and go to the home position.

    The switch is found fast and left slowly: its position counts where it lets go. Raises Lost where it is not found.
    """
    for i, axis in enumerate(layout.axes):
        if not axis.switched:
            continue
        state = at_rest(layout, reading())
        start = state.position[i]
        state.wanted[i] = -SEARCH * axis.speed
        while (i, -1) not in pressed():
            if start - state.position[i] > TOO_FAR * (axis.high - axis.low):
                raise Lost(f"no negative switch on axis {axis.name}")
            yield _along(layout, state)
        state.wanted[i] = 0.0
        yield from ramp(layout, state)
        state.wanted[i] = CREEP * axis.speed
        while (i, -1) in pressed():
            yield _along(layout, state)
        released = layout.axis(reading())[i]
        state.wanted[i] = 0.0
        yield from ramp(layout, state)
        yield from _hold(layout, layout.motor(state.position))
        axes = layout.axis(reading())
        axes[i] += axis.low - released
        preset(layout.motor(axes))
        yield Setpoint(reading(), np.zeros(len(axes)), wake=True)
    yield from _approach(layout, reading(), layout.home)


def at_rest(layout: Layout, reading: Floats, urgency: float = 1.0) -> Ramp:
    """A ramp that stands at a reading (motors,)."""
    axes = layout.axis(reading)
    bounds = urgency * np.array([axis.acceleration for axis in layout.axes])
    return Ramp(axes, np.zeros_like(axes), bounds, layout.dt)


def _approach(layout: Layout, start: Floats, end: Floats) -> Iterator[Setpoint]:
    speed = np.array([axis.speed for axis in layout.axes])
    acceleration = np.array([axis.acceleration for axis in layout.axes])
    way, second = rest_to_rest(layout.axis(start), layout.axis(end), speed, acceleration, layout.dt)
    for axes, rate in zip(way, second):
        yield Setpoint(layout.motor(axes), _motor_rates(layout, rate))
    yield from _hold(layout, end)


def _hold(layout: Layout, reference: Floats) -> Iterator[Setpoint]:
    still = Setpoint(np.asarray(reference), np.zeros(len(reference)))
    for _ in range(round(SETTLE / layout.dt)):
        yield still


def _along(layout: Layout, state: Ramp) -> Setpoint:
    position, acceleration = state.advance()
    return Setpoint(layout.motor(position), _motor_rates(layout, acceleration))


def _motor_rates(layout: Layout, axes: Floats) -> Floats:
    return layout.motor(axes + layout.origin)
