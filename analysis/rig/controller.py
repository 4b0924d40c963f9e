"""The rig: takes requests, moves the machine one sample at a time, watches it, and keeps finished runs.

``request`` is what a user asks, ``tick`` is one sample. Neither knows of time or network: ``pacing`` calls the one,
``server`` the other, tests both.
"""

from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..errors import InputError
from . import motions
from .machine import RigMachine, Trajectory
from .motions import Setpoint
from .recorder import Recorder
from .setpoints import Ramp
from .states import MOVING, REQUESTS, TRANSITIONS, Event, Refused, State, follow

QUICK = 4.0  # deceleration of a stop over that of a halt
SHOWN = 0.02  # between two points of the page's plot [s]
KEPT = 300  # points of the plot


class Rig:
    """A machine, its state machine and its log."""

    def __init__(self, machine: RigMachine, recorder: Recorder, seed: int = 0) -> None:
        self.machine = machine
        self.recorder = recorder
        self.state = State.INITIALISE
        self.homed = False
        self.loaded: Trajectory | None = None
        self.message = "starting"
        self.samples = 0
        self.trace: deque[list[float]] = deque(maxlen=KEPT)
        n = len(machine.layout.motors)
        self._rng = np.random.default_rng(seed)
        self._motion: Iterator[Setpoint] | None = None
        self._ramp: Ramp | None = None
        self._reference, self._before, self._command = np.zeros(n), np.zeros(n), np.zeros(n)
        self._rows: list[list[float]] = []
        self._recorded = 0  # samples of the run so far
        self._every = max(1, round(SHOWN / machine.layout.dt))
        self._halted = False
        self._pressed: frozenset[tuple[int, int]] = frozenset()
        self._use = "fit"

    # --- requests -----------------------------------------------------------------------------

    def request(self, event: Event, data: Mapping[str, Any] | None = None) -> None:
        """Do what the user asks; Refused where the state does not allow it, InputError for bad data.

        Either leaves the rig as it was.
        """
        after = follow(self.state, event, homed=self.homed)
        getattr(self, f"_on_{event}", lambda data: None)(data or {})
        self._enter(after, event)

    def _on_set(self, data: Mapping[str, Any]) -> None:
        unknown = sorted(set(data) - {"controller", "nominal"})
        if unknown:
            raise InputError("configure", f"unknown key {unknown[0]!r}", "controller or nominal")
        blocks = [data.get(key, {}) for key in ("controller", "nominal")]
        if not all(isinstance(block, Mapping) for block in blocks):
            raise InputError("configure", "a block is no mapping", "keys with values")
        self.machine.configure(*blocks)

    def _on_load(self, data: Mapping[str, Any]) -> None:
        from .trajectories import load

        self.loaded = load(self.machine, data)

    def _on_start(self, data: Mapping[str, Any]) -> None:
        if self.state is State.JOG or self.state is State.JOGGING:
            self._jog(data)
        elif self.state is State.HOME:
            self._begin(self._homing())
        else:
            use = data.get("use", "fit")
            if use not in ("fit", "validate"):
                raise InputError("start", f"use is {use!r}", "fit or validate")
            assert self.loaded is not None
            self._use = use
            reading = self.machine.read()
            self._begin(motions.executing(self.machine.layout, reading, self.loaded))

    def _on_halt(self, data: Mapping[str, Any]) -> None:
        self._halted = True
        self._slow_down(1.0)

    def _on_close(self, data: Mapping[str, Any]) -> None:
        self.loaded = None

    def _on_reset(self, data: Mapping[str, Any]) -> None:
        self._motion, self.homed, self.loaded = None, False, None

    # --- motions ------------------------------------------------------------------------------

    def _begin(self, motion: Iterator[Setpoint]) -> None:
        self._motion, self._rows, self._recorded, self._halted = motion, [], 0, False
        self._reference = self._before = self.machine.read()
        self.machine.wake()

    def _homing(self) -> Iterator[Setpoint]:
        machine = self.machine
        if not machine.layout.finds_switch:
            machine.preset(machine.layout.home)
            yield Setpoint(machine.read(), np.zeros(len(machine.layout.motors)), wake=True)
        else:
            yield from motions.homing(
                machine.layout, machine.read, machine.preset, lambda: self._pressed
            )
        self.homed = True

    def _jog(self, data: Mapping[str, Any]) -> None:
        axes = self.machine.layout.axes
        names = [axis.name for axis in axes]
        name, share = data.get("axis", names[0]), data.get("speed", 0.0)
        if name not in names:
            raise InputError("jog", f"unknown axis {name!r}", f"one of {', '.join(names)}")
        if isinstance(share, bool) or not isinstance(share, int | float) or not abs(share) <= 1.0:
            raise InputError("jog", f"speed is {share!r}", "a share of the axis's speed, -1 to 1")
        i = names.index(name)
        if (i, int(np.sign(share))) in self._pressed:
            raise InputError("jog", f"the switch on this side of {name} is reached", "the way back")
        if self.state is State.JOG or self._ramp is None:
            self._ramp = motions.at_rest(self.machine.layout, self.machine.read())
            self._begin(motions.ramp(self.machine.layout, self._ramp))
        self._halted = False
        self._ramp.wanted[:] = 0.0
        self._ramp.wanted[i] = share * axes[i].speed

    def _slow_down(self, urgency: float) -> None:
        """Go over to a ramp that brings the present setpoint to rest."""
        layout = self.machine.layout
        self._ramp = motions.at_rest(layout, self._reference, urgency)
        self._ramp.speed = layout.axis_map @ (self._reference - self._before) / layout.dt
        self._motion = motions.ramp(layout, self._ramp)

    # --- one sample ---------------------------------------------------------------------------

    def tick(self) -> None:
        """One sample of the machine and its controller."""
        if self.state is State.INITIALISE:
            self.machine.power_up(self._rng)
            self._pressed = self._switches()
            self._fire(Event.INITIALISED)
        if self._motion is not None:
            self._follow()
            self._watch()
        self.samples += 1
        if self.samples % self._every == 0:
            self.trace.append(self._point())

    def _follow(self) -> None:
        assert self._motion is not None
        try:
            setpoint = next(self._motion, None)
        except motions.Lost as error:
            self._fire(Event.FAULT, str(error))
            return
        if setpoint is None:
            self._finish()
            return
        if setpoint.wake:
            self.machine.wake()
        reading = self.machine.read()
        self._before, self._reference = self._reference, setpoint.reference
        if setpoint.wake:
            self._before = self._reference
        self._command = self.machine.step(setpoint.reference, setpoint.acceleration)
        if setpoint.record:
            time = self._recorded * self.machine.layout.dt
            row = self.machine.row(time, setpoint.reference, reading, self._command)
            self._recorded += 1
            if len(row):
                self._rows.append([*row])

    def _watch(self) -> None:
        if self._motion is None:
            return
        layout = self.machine.layout
        error = np.abs(self._reference - self.machine.read())
        most = np.broadcast_to(layout.following_error, error.shape)
        lost = ~(error < most)  # NaN, too
        if np.any(lost):
            if self.state in MOVING:
                j = int(np.argmax(lost))
                told = f"following error of {layout.motors[j]} above {most[j]:g} {layout.unit}"
                self._fire(Event.FAULT, told)
            self._brake()
            return
        now = self._switches()
        new, self._pressed = now - self._pressed, now
        if new and self.state in MOVING:
            self._at_switch(new)

    def _at_switch(self, new: frozenset[tuple[int, int]]) -> None:
        names = self.machine.layout.axes
        where = ", ".join(f"{'+' if side > 0 else '-'}{names[i].name}" for i, side in sorted(new))
        if self.state is State.JOGGING and self._ramp is not None:
            for i, side in new:
                if side * self._ramp.wanted[i] > 0.0:
                    self._ramp.wanted[i] = 0.0
        self._fire(Event.LIMIT, f"limit switch {where}")

    def _switches(self) -> frozenset[tuple[int, int]]:
        position = self.machine.true_axes()
        return frozenset(
            (i, side)
            for i, axis in enumerate(self.machine.layout.axes)
            for side, reached in ((-1, position[i] <= axis.low), (1, position[i] >= axis.high))
            if reached
        )

    def _finish(self) -> None:
        """The motion is complete: brakes on, and a whole run is kept."""
        self._brake()
        if self.state not in MOVING:
            return
        told = "halted" if self._halted else "done"
        if self.state is State.EXECUTING and not self._halted:
            assert self.loaded is not None
            path = self.recorder.keep(self.machine, self.loaded, self._rows, self._use)
            told = f"recorded {path}"
        self._fire(Event.DONE, told)

    def _brake(self) -> None:
        self._motion = self._ramp = None
        self._command = np.zeros_like(self._command)
        self.machine.brake()

    def _fire(self, event: Event, message: str = "") -> None:
        if event in TRANSITIONS[self.state]:
            self._enter(follow(self.state, event, homed=self.homed), event, message)

    def _enter(self, state: State, event: Event, message: str = "") -> None:
        self.message = message or f"{event}"
        if state is self.state:
            return
        if state in (State.STOP, State.OFF):
            if self._motion is not None:
                self._slow_down(QUICK)
            if self.state is State.HOMING:
                self.homed = False
        self.state = state

    # --- what is shown ------------------------------------------------------------------------

    @property
    def standing(self) -> bool:
        """Whether the brakes are on."""
        return self._motion is None

    def _point(self) -> list[float]:
        layout = self.machine.layout
        axes, wanted = layout.axis(self.machine.read()), layout.axis(self._reference)
        time = self.samples * layout.dt
        return [round(float(x), 6) for x in (time, *axes, *wanted, *self._command)]

    def status(self) -> dict[str, Any]:
        """Everything the page shows, as JSON values."""
        layout = self.machine.layout
        return {
            "state": self.state,
            "message": self.message,
            "allowed": self.allowed(),
            "homed": self.homed,
            "standing": self.standing,
            "time_s": round(self.samples * layout.dt, 3),
            "switches": sorted([list(pressed) for pressed in self._pressed]),
            "trajectory": None if self.loaded is None else self.loaded.name,
            "runs": self.recorder.summary(),
            "trace": list(self.trace),
            "settings": self.machine.settings(),
        }

    def allowed(self) -> list[str]:
        """Requests that would not be refused now."""
        names = []
        for event in REQUESTS:
            try:
                follow(self.state, event, homed=self.homed)
            except Refused:
                continue
            names.append(str(event))
        return names
