"""A linear axis behind the rig: the EMPS benchmark's machine with a cascade P-P law."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...models.motion import MotionProgram
from ..errors import InputError
from ..gap.machines.settings import Settings
from ..gap.machines.slider import read_controller, slider_machine
from . import faults
from .drive_machine import DriveMachine, checked_rate
from .machine import Axis, Floats, Layout, Trajectory

# Janot, Gautier and Brunot 2019: mass, viscous friction, and the drive's constants.
NOMINAL = {"mass_kg": 95.1089, "viscous_N_s_per_m": 203.5034}
LSB = 5.0e-8  # of the encoder [m]
CASCADE = {
    "kind": "cascade_p_p",
    "kp_per_s": 160.18,
    "kv_V_per_m_per_s": 243.45,
    "saturation_V": 10.0,
    "force_per_volt_N": 35.15065,
    "encoder_lsb_m": LSB,
}
STROKES = {"short": 0.08, "medium": 0.15, "long": 0.20}  # [m]
DRY_FRICTION = 20.0  # order of magnitude of a fault [N]


class Slider(DriveMachine):
    """The axis with a fault."""

    programs: Sequence[str] = tuple(STROKES)

    def __init__(self, fault: str = "none", seed: int = 0) -> None:
        self._controller: dict[str, Any] = dict(CASCADE)
        self._nominal: dict[str, Any] = dict(NOMINAL)
        machine = slider_machine(NOMINAL["mass_kg"], NOMINAL["viscous_N_s_per_m"], 0.0)
        values = {"mass": NOMINAL["mass_kg"], "viscous": NOMINAL["viscous_N_s_per_m"]}
        plant = machine.build(values).drive
        self.answer = faults.give(fault, plant, faults.of_drive(DRY_FRICTION, "N"), seed)
        super().__init__(_layout(), plant, read_controller("controller", self._controller))

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": dict(self._controller), "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Use other gains or another nominal model."""
        new_controller = {**self._controller, **controller}
        new_nominal = {**self._nominal, **nominal}
        values = Settings("configure, nominal", new_nominal, set(NOMINAL))
        values.number("mass_kg", positive=True)
        values.number("viscous_N_s_per_m", least=0.0)
        self.law = read_controller("configure, controller", new_controller)
        self._controller, self._nominal = new_controller, new_nominal

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A stroke out and back by the 4-5-6-7 polynomial."""
        if name not in STROKES:
            raise InputError(
                "trajectory", f"unknown stroke {name!r}", f"one of {', '.join(STROKES)}"
            )
        try:
            program = MotionProgram(
                name=name, amplitude_L=STROKES[name], amplitude_R=0.0, rate=rate
            )
            times = checked_rate(rate, cycles, self.layout.dt)
        except ValueError as error:
            found, _, expected = str(error).partition("; expected ")
            raise InputError("trajectory", found, expected) from None
        position, _, acceleration = program.sample(times)
        return Trajectory(
            name=f"{name} {rate:g} Hz",
            position=position[:, :1],
            acceleration=acceleration[:, :1],
            keys={"rate_Hz": rate},
        )

    def columns(self) -> dict[str, str]:
        """As in every log set of a slider."""
        return {"t": "s", "q_ref": "m", "q": "m", "force": "N"}

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, reference, reading, force."""
        return [time, *reference, *reading, *command]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        return {
            "system": {"kind": "slider", "nominal": dict(self._nominal)},
            "sample_time_s": self.layout.dt,
            "controller": dict(self._controller),
        }


def _layout() -> Layout:
    return Layout(
        kind="slider",
        motors=("axis",),
        unit="m",
        effort="N",
        axes=(
            Axis(name="axis", unit="m", speed=0.2, acceleration=1.0, low=-0.02, high=0.26),
        ),
        axis_map=np.ones((1, 1)),
        origin=np.zeros(1),
        home=np.zeros(1),
        finds_switch=True,
        lsb=LSB,
        following_error=0.02,
    )  # fmt: skip
