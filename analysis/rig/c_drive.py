"""The C-drive behind the rig: two motors, a collar that slides between two switches and turns freely."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...models import c_drive, encoder
from ...models.c_drive import CDriveParameters
from ...models.motion import C_DRIVE_MOTIONS, c_drive_motion
from ..errors import InputError
from ..gap.machines.c_drive import NOMINAL, read_controller, read_parameters
from ..gap.machines.settings import Settings
from . import faults
from .drive_machine import DriveMachine, checked_rate
from .machine import Axis, Floats, Layout, Trajectory

BITS = 13  # of the encoders, section 5.1.4
DRY_FRICTION = 0.15  # order of magnitude of a fault [N m]
PD = {  # Table 5-1
    "kind": "pd",
    "kp_Nm_per_rad": 45.0,
    "kd_Nms_per_rad": 0.1,
    "derivative_filter_rad_per_s": 600.0,
}


class CDrive(DriveMachine):
    """The prototype with a fault, under PD until it is configured otherwise."""

    programs: Sequence[str] = tuple(C_DRIVE_MOTIONS)

    def __init__(self, fault: str = "none", seed: int = 0) -> None:
        self._controller: dict[str, Any] = dict(PD)
        self._nominal = {key: getattr(CDriveParameters(), name) for key, name in NOMINAL.items()}
        layout = _layout()
        plant = c_drive.drive(CDriveParameters()).copy()
        self.answer = faults.give(fault, plant, faults.of_drive(DRY_FRICTION, "N m"), seed)
        super().__init__(layout, plant, _law(self._controller, self._nominal, layout.dt))

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": dict(self._controller), "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Use other blocks; a controller of another kind is given whole."""
        same = controller.get("kind", self._controller["kind"]) == self._controller["kind"]
        new_controller = {**(self._controller if same else {}), **controller}
        new_nominal = {**self._nominal, **nominal}
        self.law = _law(new_controller, new_nominal, self.layout.dt)
        self._controller, self._nominal = new_controller, new_nominal

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A motion of Table 5-2."""
        try:
            program = c_drive_motion(name, rate)
            times = checked_rate(rate, cycles, self.layout.dt)
        except ValueError as error:
            found, _, expected = str(error).partition("; expected ")
            raise InputError("trajectory", found, expected) from None
        position, _, acceleration = program.sample(times)
        return Trajectory(
            name=f"{name} {rate:g} Hz",
            position=position,
            acceleration=acceleration,
            keys={"motion": name, "rate_Hz": rate},
        )

    def columns(self) -> dict[str, str]:
        """As in every log set of a C-drive."""
        counts = f"rad, {BITS}-bit encoder"
        return {
            "t": "s",
            "psi_L_ref": "rad",
            "psi_R_ref": "rad",
            "psi_L": counts,
            "psi_R": counts,
            "tau_L": "Nm, commanded",
            "tau_R": "Nm, commanded",
        }

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, references, readings, torques."""
        return [time, *reference, *reading, *command]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        return {
            "system": {"kind": "c_drive", "nominal": dict(self._nominal)},
            "sample_time_s": self.layout.dt,
            "controller": dict(self._controller),
        }


def _law(controller: Mapping[str, Any], nominal: Mapping[str, Any], dt: float) -> Any:
    values = Settings("configure, nominal", nominal, set(NOMINAL))
    model = read_parameters("configure, nominal", values)
    return read_controller("configure, controller", controller, model, dt)


def _layout() -> Layout:
    lead = CDriveParameters.lead
    return Layout(
        kind="c_drive",
        motors=c_drive.SHAFTS,
        unit="rad",
        effort="N m",
        axes=(
            # The collar travels 200 mm (Table 5-2); the switches stand 15 mm outside.
            Axis(name="slide", unit="m", speed=0.2, acceleration=2.0, low=-0.215, high=0.015),
            Axis(name="turn", unit="rad", speed=6.0, acceleration=60.0),
        ),
        axis_map=c_drive.collar_pose(np.eye(2), lead).T,
        origin=np.zeros(2),
        home=np.zeros(2),
        finds_switch=True,
        lsb=encoder.resolution(BITS),
        following_error=1.0,
    )
