"""Step size against posture, load, inertia, voltage and frequency: data behind the figures."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...models import chang_li, stick_slip
from ...models.mm3a import actuators, dynamics, step_size
from ...models.mm3a.arm import STANDARD_GRAVITY, Arm, gravity_in_base
from ...models.mm3a.step_size import StepModel

NO_FORCE = (0.0, 0.0, 0.0)
LEVEL = -0.5 * np.pi


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Step sizes over one quantity by several sources."""

    x: NDArray[np.float64]  # in the unit of its axis
    steps: dict[str, NDArray[np.float64]]  # by source; rad or m


def posture_curve(
    joint: int,
    direction: int,
    x: Sequence[float] | NDArray[np.float64],
    postures: Sequence[tuple[float, float, float]],
    tilts: Sequence[tuple[float, float]],
    model: StepModel | None = None,
) -> Curve:
    """Empirical and physical step of ``joint`` (1-3) at postures (q1, q2, q3) and tilts (theta, psi)."""
    arm, parts = Arm(), actuators.joint_actuators()
    table, travel = (model or StepModel()).table(), arm.upper_3 - arm.lower_3
    empirical, physical = [], []
    for q, (theta, psi) in zip(postures, tilts):
        gravity = gravity_in_base(theta, psi)
        load = step_size.load_factors(q, gravity, NO_FORCE, arm)[joint - 1]
        empirical.append(step_size.step_size(joint - 1, int(direction > 0), q, load, table, travel))
        physical.append(
            abs(actuators.physical_step(joint - 1, direction, q, gravity, NO_FORCE, arm, parts))
        )
    return Curve(
        x=np.asarray(x, dtype=float),
        steps={"empirical": np.array(empirical), "physical": np.array(physical)},
    )


def load_curve(points: int = 17) -> Curve:
    """Joint 3, positive step, against the load in weights of link 3, at q2 = -pi/2.

    Chang and Li's closed form takes the stroke that gives the physical step without load.
    """
    arm, joint = Arm(), actuators.prismatic_actuator()
    weight = arm.mass_3 * STANDARD_GRAVITY
    loads = np.linspace(-1.5, 1.5, points)
    step = StepModel().joint_3_positive
    contact = joint.actuator
    # Without load the closed form loses t_f^2 F_c / m of its stroke.
    lost = joint.drive.flyback**2 * contact.coulomb / arm.mass_3
    stroke = joint.step(1, 0.0, arm.mass_3) + lost
    return Curve(
        x=loads,
        steps={
            "empirical": step_size.prismatic_step(LEVEL, loads, step.basic, step.recoil, step.load),
            "physical": np.array([joint.step(1, load * weight, arm.mass_3) for load in loads]),
            "Chang and Li": np.array(
                [
                    chang_li.step(
                        stroke, joint.drive.flyback, contact.coulomb, arm.mass_3, load * weight
                    )
                    for load in loads
                ]
            ),
        },
    )


def inertia_curve(points: int = 80) -> Curve:
    """Joint 2, unloaded, against inertia [kg m^2]: contact as chosen and four times softer."""
    joint = actuators.elbow_actuator()
    soft = replace(
        joint,
        actuator=replace(
            joint.actuator, presliding_stiffness=0.25 * joint.actuator.presliding_stiffness
        ),
    )
    inertias = np.geomspace(0.5e-6, 2e-5, points)
    return Curve(
        x=inertias,
        steps={
            "physical": _settled(joint, inertias),
            "softer contact": _settled(soft, inertias),
        },
    )


def _settled(joint: actuators.JointActuator, inertias: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unloaded steps after fifty periods: heavy sliders swing long before they repeat."""
    return np.array(
        [
            stick_slip.simulate(
                joint.actuator, joint.drive, steps=50, slider_mass=inertia / joint.radius**2
            )
            .steps[-10:]
            .mean()
            / joint.radius
            for inertia in inertias
        ]
    )


def inertia_range() -> tuple[float, float]:
    """Inertia about joint 2 [kg m^2] retracted and extended."""
    arm = Arm()
    low, high = (dynamics.mass_diagonal((0.0, LEVEL, q3), arm)[1] for q3 in (0.0, 0.012))
    return float(low), float(high)


def voltage_curve(points: int = 17) -> Curve:
    """Joint 3, unloaded, against the amplitude of the sawtooth [V], by hysteresis model."""
    volts = np.linspace(5.0, 100.0, points)
    drive = stick_slip.Sawtooth()
    return Curve(
        x=volts,
        steps={
            kind: np.array(
                [
                    stick_slip.settled_step(
                        stick_slip.Actuator(hysteresis=kind), replace(drive, amplitude=volt)
                    )
                    for volt in volts
                ]
            )
            for kind in stick_slip.HYSTERESES
        },
    )


def frequency_curve(points: int = 15) -> Curve:
    """Joint 3, unloaded, against the step frequency [Hz]."""
    frequencies = np.geomspace(20.0, 2000.0, points)
    return Curve(
        x=frequencies,
        steps={
            "physical": np.array(
                [
                    stick_slip.settled_step(
                        stick_slip.Actuator(), stick_slip.Sawtooth(period=1.0 / frequency)
                    )
                    for frequency in frequencies
                ]
            )
        },
    )
