"""The MM3A micromanipulator behind the rig: stick-slip motors that a controller sends whole steps, ``system.kind: mm3a``.

Every sample the controller sends as many steps as the nominal step says are missing, and an outer measuring system sees
how far they go; a move is a row of the log. It homes where it stands, by hand: a search for its end stops takes minutes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...models.mm3a.arm import Arm
from ...models.mm3a.step_size import STEP_TIME
from ..errors import InputError
from ..mm3a.empirical_moves import FIELDS, EmpiricalMover, plant
from ..mm3a.moves import COLUMNS, Series
from ..mm3a.simulated_moves import SCATTER
from . import faults
from .machine import Axis, Floats, Layout, Trajectory
from .setpoints import out_and_back

DT = 0.2  # [s]
BUSY = 0.4  # of the steps that fit into a sample, those that a motion may ask for: loaded steps are half as long
STEP = np.array([9e-5, 9e-5, 9e-7])  # a nominal step, unit of the motors' coordinates [rad, rad, m]
MARK = np.array([0.0, -0.5 * np.pi, 0.004])  # joints [rad, rad, m]
BEND = 0.7  # of the elbow in the motions called raised and lowered [rad]
# Joint that moves and by how much, and the elbow's angle from the mark [rad, rad or m].
MOTIONS = {
    "joint 3": (3, 0.002, 0.0),
    "joint 3 raised": (3, 0.002, BEND),
    "joint 3 lowered": (3, 0.002, -BEND),
    "joint 2 up": (2, 0.2, 0.0),
    "joint 2 down": (2, -0.2, 0.0),
}
FAULTS = {
    name: faults.Fault(
        name=name, effect=effect, apply=lambda made, strength: None, strength=(1.0, 1.0), unit=""
    )
    for name, effect in (
        ("load", "step.load"),
        ("recoil", "step.recoil"),
        ("direction", "step.direction"),
        ("payload", "inertia.payload"),
        ("memory", "actuator.hysteresis"),
    )
}


class Manipulator:
    """The arm with a fault, moves measured with the scatter of ``simulate mm3a --moves``."""

    programs: Sequence[str] = tuple(MOTIONS)

    def __init__(self, fault: str = "none", seed: int = 0) -> None:
        self._rng = np.random.default_rng(seed)
        chosen = faults.choose(fault, FAULTS, self._rng)
        planted = plant() if chosen is None else plant(chosen.effect)
        self.answer = (
            "none: the machine is its nominal model"
            if chosen is None
            else f"{chosen.effect} ({chosen.name})"
        )
        self._mover = EmpiricalMover(planted)
        self._nominal: dict[str, Any] = {**planted.nominal(), "repeatability": SCATTER}
        self.layout = _layout()
        self._q, self._offset = MARK.copy(), np.zeros(3)
        self._session, self._joint, self._moved = 0, 0, 0.0
        self.power_up(self._rng)

    def power_up(self, rng: np.random.Generator) -> None:
        """Stand near the mark, everything cold; a session of its own."""
        self._q = MARK + STEP * rng.uniform(-20.0, 20.0, 3)
        self._clock = 0.0
        self._session += 1
        self._mover.begin(str(self._session))
        self.preset(np.zeros(3))

    def read(self) -> Floats:
        """Measured joints (3,) [steps from the mark]."""
        return np.asarray((self._q - self._offset - MARK) / STEP)

    def preset(self, motors: Floats) -> None:
        """Let the measuring system read ``motors`` here."""
        self._offset = self._q - MARK - STEP * motors

    def true_axes(self) -> Floats:
        """Where the joints really are (3,)."""
        return self._q.copy()

    def wake(self) -> None:
        """The controller keeps nothing."""
        self._moved = 0.0

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """Steps sent to each motor (3,), as many as are missing and fit into the sample."""
        most = round(DT / STEP_TIME)
        wanted = np.clip(np.round(reference - self.read()), -most, most)
        self._clock += DT
        for joint in np.flatnonzero(wanted):
            series = Series(joint=int(joint) + 1, theta=0.0, postures=(), session="")
            moved = self._mover.move(series, self._q, int(wanted[joint]), self._clock)
            self._q[joint] += moved
            if joint == self._joint:
                self._moved = moved * (1.0 + SCATTER * self._rng.standard_normal())
        return np.asarray(wanted)

    def brake(self) -> None:
        """Stick-slip motors hold by themselves."""

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": {"kind": "steps"}, "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Another nominal step law; InputError for a key that it does not have."""
        if controller.get("kind", "steps") != "steps" or len(controller) > 1:
            raise InputError("configure, controller", f"{dict(controller)}", "kind: steps")
        new = dict(self._nominal)
        for key, value in nominal.items():
            if key not in (*FIELDS, "repeatability"):
                raise InputError("configure, nominal", f"unknown key {key!r}", ", ".join(FIELDS))
            old = new[key]
            if isinstance(old, dict):
                if not isinstance(value, Mapping) or not set(value) <= set(old):
                    raise InputError(f"configure, nominal.{key}", f"{value!r}", f"{old}")
                value = {**old, **value}
            new[key] = value
        self._nominal = new

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A move of one joint out and back, at a bend of the elbow."""
        size = {
            key: amplitude * np.eye(3)[joint - 1] / STEP
            for key, (joint, amplitude, _) in MOTIONS.items()
        }
        found = out_and_back(name, size, rate, cycles, DT)
        joint, _, bend = MOTIONS[name]
        self._joint = joint - 1
        peak = float(np.max(np.abs(np.diff(found.position, axis=0)))) / DT * STEP_TIME
        if peak > BUSY:
            raise InputError(
                "trajectory", f"{rate} Hz asks for {peak / STEP_TIME:.0f} steps a second",
                f"at most {rate * BUSY / peak:.3g} Hz",
            )  # fmt: skip
        keys = {"joint": joint, "session": str(self._session), "note": name}
        start = np.array([0.0, bend, 0.0]) / STEP
        return replace(found, position=found.position + start, keys=keys)

    def columns(self) -> dict[str, str]:
        """As in every log set of moves."""
        return dict(COLUMNS)

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time of the session, steps, joints before the move, and how far the joint went; nothing where it stood."""
        steps = command[self._joint]
        if steps == 0.0 or np.count_nonzero(command) > 1:
            return []
        return [self._clock, steps, *self.layout.axis(reading), self._moved]

    def document(self) -> dict[str, Any]:
        """System; samples are moves, at uneven times."""
        return {"system": {"kind": "mm3a", "nominal": _plain(self._nominal)}}


def _plain(nominal: Mapping[str, Any]) -> dict[str, Any]:
    return {k: dict(v) if isinstance(v, Mapping) else v for k, v in nominal.items()}


def _layout() -> Layout:
    arm = Arm()
    fast = BUSY / STEP_TIME  # [steps/s]
    return Layout(
        kind="mm3a",
        motors=("joint 1", "joint 2", "joint 3"),
        unit="step",
        effort="steps a sample",
        axes=tuple(
            Axis(name=f"joint {i + 1}", unit=unit, speed=fast * step, acceleration=fast * step,
                 low=low, high=high)
            for i, (unit, step, low, high) in enumerate(
                zip(("rad", "rad", "m"), STEP, arm.lower, arm.upper)
            )
        ),
        axis_map=np.diag(STEP),
        origin=MARK,
        home=np.zeros(3),
        finds_switch=False,
        lsb=0.0,
        following_error=200.0,
        dt=DT,
        rate=0.004,
        tables=False,
    )  # fmt: skip
