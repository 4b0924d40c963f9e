r"""The physical actuators of the three joints: ``stick_slip.py`` behind each joint's lever.

A rotary joint acts at a contact radius r: slider mass :math:`M_{jj}/r^2`, load :math:`\tau_j/r`, angle
:math:`y/r` (chapter 3: only the diagonal inertia and the static load reach a joint that steps alone).

Constants are **chosen**, none is printed. Joint 3: unloaded step 0.94 um and its change under the weight
of link 3 near the printed a = 0.90-0.97 um, c = 0.38-0.44 um (Fig. 4.13). Joints 1 and 2: step near
90 urad and change with the extended arm's weight near d = 19-24 urad (Fig. 5.6). What follows from them -
the shape of the trends, the effect of inertia, voltage and frequency - is prediction, not fit.

What the physical actuator says about the step that shrinks with inertia (section 5.4). A light slider falls
back less the heavier it is, so its step grows, as the thesis expected; with these constants that holds
over the whole travel of joint 3, against the observation. A slider so heavy that it still swings on the
elastic contact when the next flyback comes has no trend at all: its step goes up and down with the phase
of that swing, by a fifth and more, and a decrease over the travel of joint 3 can be had by the choice of
inertia, contact stiffness and step period. The robust explanation within this model is friction that grows
as the arm overhangs its bearing: it has to grow by more than the inertia does. Step counts alone cannot tell.
The chapter's own guess, a stack that stretches less under inertia, is not it: along the slow ramp the
inertia force is below 1e-4 of the stack's. Nor does this model reproduce the smooth maximum over mass
that Peng and Chen measured (Fig. 2.4); theirs needs a contact stiffness that depends on the mass.

What it does not explain at all: the loss with the elbow angle (4.3), which takes a frame that recoils, and
steps that differ by direction without load.
"""

from dataclasses import dataclass, field
from typing import Any

from .. import stick_slip
from ..stick_slip import Actuator, Sawtooth
from . import dynamics
from .arm import Arm


@dataclass(frozen=True, kw_only=True)
class JointActuator:
    """An actuator, its drive and the radius at which it turns the joint (1 for a linear joint)."""

    actuator: Actuator = field(default_factory=Actuator)
    drive: Sawtooth = field(default_factory=Sawtooth)
    radius: float = 1.0  # [m], or 1 without unit

    def __post_init__(self) -> None:
        if not self.radius > 0.0:
            raise ValueError(f"joint actuator: radius is {self.radius}; expected a positive length")

    def step(self, direction: int, load: float, inertia: float, **options: Any) -> float:
        """Signed settled step [rad or m] under ``load`` [N m or N] and ``inertia`` [kg m^2 or kg]."""
        settled = stick_slip.settled_step(
            self.actuator,
            self.drive,
            direction=direction,
            load=load / self.radius,
            slider_mass=inertia / self.radius**2,
            **options,
        )
        return settled / self.radius


def prismatic_actuator() -> JointActuator:
    """Actuator of joint 3: the defaults of ``stick_slip.py``."""
    return JointActuator()


def elbow_actuator() -> JointActuator:
    """Actuator of joint 2, acting at 5 mm."""
    contact = Actuator(
        transduction=0.192,
        coulomb=0.30,
        breakaway=0.06,
        presliding_stiffness=4.0e6,
        presliding_damping=80.0,
    )
    return JointActuator(actuator=contact, drive=Sawtooth(flyback=2.0e-4), radius=0.005)


def shoulder_actuator() -> JointActuator:
    """Actuator of joint 1: as joint 2, preloaded to hold the whole arm on its side (0.65 N at 5 mm)."""
    contact = Actuator(
        piezo_mass=4.0e-3,
        piezo_damping=120.0,
        transduction=0.23,
        coulomb=2.0,
        breakaway=0.4,
        presliding_stiffness=1.2e7,
        presliding_damping=300.0,
    )
    return JointActuator(actuator=contact, drive=Sawtooth(flyback=2.0e-4), radius=0.005)


def joint_actuators() -> tuple[JointActuator, JointActuator, JointActuator]:
    """Actuators of joints 1, 2 and 3."""
    return shoulder_actuator(), elbow_actuator(), prismatic_actuator()


def physical_step(
    joint: int,
    direction: int,
    q: Any,
    gravity: Any,
    force: Any,
    arm: Arm,
    actuators: tuple[JointActuator, ...],
    **options: Any,
) -> float:
    """Signed settled step of ``joint`` (0, 1, 2) in posture ``q`` by its physical actuator [rad or m]."""
    load = dynamics.static_load(q, gravity, force, arm)[joint]
    inertia = dynamics.mass_diagonal(q, arm)[joint]
    return actuators[joint].step(direction, float(load), float(inertia), **options)
