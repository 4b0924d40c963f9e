"""A rotary inverted pendulum behind the rig: Quanser's QUBE-Servo 2 under the law of ``system.kind: furuta``.

The rig moves the arm; while the brakes are on, somebody holds the pendulum upright. It homes where the arm stands.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...models import encoder, furuta, furuta_kernels, joint
from ...models.furuta import FurutaParameters
from ...models.joint import Joints
from ..errors import InputError
from ..gap.machines.furuta import read_law
from . import faults
from .encoders import Encoders
from .machine import Axis, Floats, Layout, Trajectory
from .setpoints import out_and_back

DT, SUBSTEPS, HISTORY = 0.002, 4, 16
LSB = 2.0 * np.pi / 2048  # of both encoders [rad]
LAW = (
    "u_fb=-(6*e_t+1.8*D(e_t))-(30*e_a+2.5*D(e_a)), D=50s/(s+50) backward Euler; "
    "u=clip(u_fb+u_ff,-10,10)"
)
SWEEPS = {"short": 0.3, "medium": 0.6, "long": -0.9}  # [rad]
DRY_FRICTION = 6e-4  # order of magnitude of a fault [N m]
SIGN_WIDTH = 0.05  # [rad/s]


class Plant:
    """What effects act on: groups of masses, axes and motor."""

    def __init__(self, nominal: FurutaParameters) -> None:
        self.phi = np.array(nominal.groups)
        self.volts = nominal.k / nominal.R  # torque per volt [N m/V]
        self.joints: Joints = joint.ideal_joints(2, 1, SIGN_WIDTH)
        self.joints.law[:, joint.VISCOUS] = nominal.D_r + nominal.k * self.volts, nominal.D_p


class Furuta:
    """The pendulum with a fault."""

    programs: Sequence[str] = tuple(SWEEPS)

    def __init__(self, fault: str = "none", seed: int = 0) -> None:
        self._nominal: dict[str, Any] = {}
        self._text = LAW
        self._law = read_law("controller", LAW)
        self._plant = Plant(FurutaParameters())
        self.answer = faults.give(fault, self._plant, _faults(), seed)
        self.layout = _layout()
        self._encoders = Encoders(1, LSB)
        self._x = np.zeros(4)
        self.wake()

    def power_up(self, rng: np.random.Generator) -> None:
        """The arm stands where somebody has left it, its encoder at zero."""
        self._x = np.array([rng.uniform(-0.3, 0.3), 0.0, 0.0, 0.0])
        self.preset(np.zeros(1))

    def read(self) -> Floats:
        """Encoder of the arm (1,) [rad]."""
        return self._encoders.read(self._x[:1])

    def preset(self, motors: Floats) -> None:
        """Let the arm's encoder read ``motors`` here."""
        self._encoders.preset(self._x[:1], motors)

    def true_axes(self) -> Floats:
        """Where the arm really is (1,)."""
        return self._x[:1].copy()

    def wake(self) -> None:
        """Law without memory, at rest."""
        self._errors, self._slope, self._torque = np.zeros(2), np.zeros(2), np.zeros(1)
        self._command, self._leaning = np.zeros((HISTORY, 1)), 0.0

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """Law and plant of one sample; the voltage (1,)."""
        self._leaning = encoder.read(float(self._x[1]), LSB)
        wanted = np.array([reference[0], 0.0])
        seen = np.array([self.read()[0], self._leaning])
        self._command[:-1] = self._command[1:]
        self._command[-1] = furuta_kernels.command_of(
            wanted, seen, 0.0, self._law, DT, self._errors, self._slope
        )
        furuta_kernels.advance(
            self._x, self._torque, self._command, HISTORY - 1, self._plant.phi, self._plant.joints,
            self._plant.volts, DT, SUBSTEPS,
        )  # fmt: skip
        return self._command[-1].copy()

    def brake(self) -> None:
        """The arm stands, and the pendulum is held upright."""
        self._x = np.array([self._x[0], 0.0, 0.0, 0.0])

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": {"law": self._text}, "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Another law, or constants of ``FurutaParameters`` in place of the maker's."""
        unknown = sorted(set(controller) - {"law"})
        if unknown:
            raise InputError("configure, controller", f"unknown key {unknown[0]!r}", "law")
        text = controller.get("law", self._text)
        law = read_law("configure, controller.law", text)
        new = {**self._nominal, **nominal}
        try:
            FurutaParameters(**new)
        except (TypeError, ValueError) as error:
            raise InputError(
                "configure, nominal", str(error), f"one of {', '.join(vars(FurutaParameters()))}"
            ) from None
        self._text, self._law, self._nominal = str(text), law, new

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A sweep of the arm out and back."""
        sweeps = {key: np.array([value]) for key, value in SWEEPS.items()}
        return out_and_back(name, sweeps, rate, cycles, DT)

    def columns(self) -> dict[str, str]:
        """As in every log set of a rotary pendulum."""
        return {
            "t": "s",
            "theta_ref": "rad",
            "alpha_ref": "rad",
            "theta": "rad",
            "alpha": "rad",
            "u": "V",
        }

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, references, both encoders, voltage."""
        return [time, reference[0], 0.0, reading[0], self._leaning, command[0]]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        return {
            "system": {"kind": "furuta", "nominal": dict(self._nominal)},
            "sample_time_s": DT,
            "controller": {"law": self._text, "encoder_rad": LSB},
        }


def _faults() -> dict[str, faults.Fault]:
    nominal = FurutaParameters()

    def on_law(row: int, column: int) -> Any:
        def apply(plant: Plant, value: float) -> None:
            plant.joints.law[row, column] += value

        return apply

    def weak(plant: Plant, value: float) -> None:
        plant.joints.actuator[0, joint.GAIN] = value

    def tip(plant: Plant, mass: float) -> None:
        length = nominal.L_p
        plant.phi += mass * np.array(
            [nominal.L_r**2, length**2, length * nominal.L_r, furuta.G * length]
        )

    level, damping = DRY_FRICTION, nominal.D_r
    found = (
        faults.Fault(name="friction", effect="friction.coulomb", apply=on_law(0, joint.DRY),
                     strength=(0.7 * level, 1.5 * level), unit="N m"),
        faults.Fault(name="damping", effect="friction.viscous", apply=on_law(0, joint.VISCOUS),
                     strength=(-0.9 * damping, -0.5 * damping), unit="N m s/rad"),
        faults.Fault(name="payload", effect="inertia.payload", apply=tip,
                     strength=(0.004, 0.01), unit="kg"),
        faults.Fault(name="weak", effect="actuator.torque_constant", apply=weak,
                     strength=(0.75, 0.9), unit="-"),
    )  # fmt: skip
    return {fault.name: fault for fault in found}


def _layout() -> Layout:
    return Layout(
        kind="furuta",
        motors=("arm",),
        unit="rad",
        effort="V",
        axes=(Axis(name="arm", unit="rad", speed=0.8, acceleration=1.5, low=-1.6, high=1.6),),
        axis_map=np.ones((1, 1)),
        origin=np.zeros(1),
        home=np.zeros(1),
        finds_switch=False,
        lsb=LSB,
        following_error=1.5,
        dt=DT,
    )
