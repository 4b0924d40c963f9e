r"""Empirical step sizes of the MM3A's stick-slip joints (Damani 2013, chapters 4-6).

1. prismatic, :math:`\gamma_{3i} = (1 - b_i|\cos q_2|)(a_i - c_i \lambda_3)`        (4.5, 6.1)
2. rotary, :math:`\gamma_{ji} = \gamma_{ji}^0(q_3) + d_{ji}(q_3) \lambda_j`          (6.7, 6.10)
3. :math:`\gamma^0` and :math:`d` interpolate linearly in :math:`q_3`                (6.8, 6.9)

i is the direction. The load factor :math:`\lambda` is the static load on the joint over its load with the
link level in 1 g: positive opposes motion in positive direction. For :math:`q_1 = 0` and no force on the
tip it is what the thesis prints: :math:`\lambda_3 = \cos\zeta\cos\theta`, :math:`\lambda_2 =
\sin\zeta\cos\theta` with :math:`\zeta = \psi - q_2`. Written with the load it holds for every
:math:`q_1`, and for forces on the tip, which "joints are unable to distinguish" from weight (chapter 3).

Joint 1 follows (2) by the role swap of section 6.2: gravity loads it at theta = -pi/2 and leaves it
free at theta = 0, so :math:`\lambda_1 = \cos q_1 \sin\theta` (psi = 0). It refers to the level arm
(:math:`q_2 = -\pi/2`); in other postures it shrinks with the true lever, an extension of the thesis.

Sizes are magnitudes, in rad for joints 1 and 2 and m for joint 3. Direction-dependent signs are part of
the model: :math:`c_- < 0` and :math:`d_+ < 0` (Figs. 4.13, 5.6). Not modelled: step-to-step noise,
the speed of the joint within a step, coupling between joints (chapter 8 names it as open).
"""

from dataclasses import astuple, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import dynamics
from .arm import STANDARD_GRAVITY

STEP_TIME = 0.010  # one step, section 4.1.2 [s]

# Chapter 2: fine mode moves the tip 5 nm (1e-7 rad) or 0.25 nm per step, within the piezo stroke of
# 4e-4 rad. The stroke of joint 3 is not printed: its coarse step of 1 um is taken for it.
FINE_STEP = (1e-7, 1e-7, 0.25e-9)  # [rad, rad, m]
STROKE = (4e-4, 4e-4, 1e-6)  # [rad, rad, m]
LEVEL = (0.0, -0.5 * np.pi)  # q1, q2 of the outstretched arm

NEGATIVE, POSITIVE = 0, 1  # index of a direction in tables and arrays


@dataclass(frozen=True, kw_only=True)
class PrismaticStep:
    """Free parameters of (1) in one direction."""

    basic: float  # a, step without load and recoil loss [m]
    recoil: float  # b, share lost at right angles to the posture q2 = -pi/2 [-]
    load: float  # c, loss at the full weight of link 3 [m]

    def __post_init__(self) -> None:
        if not (self.basic > 0.0 and abs(self.recoil) < 1.0 and np.isfinite(self.load)):
            raise ValueError(
                f"prismatic step: {self}; expected basic > 0, |recoil| < 1 and a finite load"
            )


@dataclass(frozen=True, kw_only=True)
class RotaryStep:
    """Free parameters of (2, 3) in one direction, at both ends of the travel of joint 3."""

    basic_retracted: float  # step without load at q3 = 0 [rad]
    basic_extended: float  # the same at q3 = 12 mm [rad]
    load_retracted: float  # d at q3 = 0 [rad]
    load_extended: float  # d at q3 = 12 mm [rad]

    def __post_init__(self) -> None:
        for basic, load in (
            (self.basic_retracted, self.load_retracted),
            (self.basic_extended, self.load_extended),
        ):
            if not basic > abs(load):
                raise ValueError(
                    f"rotary step: {self}; expected every basic step to exceed its load term, or "
                    "the joint stands still at full load"
                )


# Fig. 5.6 prints d only. The basic steps are chosen inside the 75-115 urad of section 6.2, smaller
# extended than retracted as in Fig. 5.7 and larger downward than upward as in section 5.2.
_ROTARY_NEGATIVE = RotaryStep(
    basic_retracted=98e-6,
    basic_extended=91e-6,
    load_retracted=3.83e-6,
    load_extended=23.94e-6,
)
_ROTARY_POSITIVE = RotaryStep(
    basic_retracted=92e-6,
    basic_extended=86e-6,
    load_retracted=-8.15e-6,
    load_extended=-19.40e-6,
)


@dataclass(frozen=True, kw_only=True)
class StepModel:
    """Step sizes of the three joints in both directions; defaults of Figs. 4.13 and 5.6.

    Joint 1 takes the values of joint 2, as chapter 5 expects of the same motor.
    """

    joint_1_negative: RotaryStep = _ROTARY_NEGATIVE
    joint_1_positive: RotaryStep = _ROTARY_POSITIVE
    joint_2_negative: RotaryStep = _ROTARY_NEGATIVE
    joint_2_positive: RotaryStep = _ROTARY_POSITIVE
    joint_3_negative: PrismaticStep = PrismaticStep(basic=899e-9, recoil=0.25, load=-436e-9)
    joint_3_positive: PrismaticStep = PrismaticStep(basic=972e-9, recoil=0.27, load=375.55e-9)

    def table(self) -> NDArray[np.float64]:
        """Parameters as (joint, direction, 4), the form kernels take; prismatic rows end in 0."""
        rows = [astuple(getattr(self, field.name)) for field in fields(self)]
        padded = [row + (0.0,) * (4 - len(row)) for row in rows]
        return np.array(padded).reshape(3, 2, 4)


def constant_steps(model: StepModel) -> StepModel:
    """Take the comparison of chapter 7: the unloaded step everywhere, in each direction."""
    steps: dict[str, Any] = {}
    for field in fields(model):
        step = getattr(model, field.name)
        if isinstance(step, PrismaticStep):
            steps[field.name] = PrismaticStep(basic=step.basic, recoil=0.0, load=0.0)
        else:
            mean = 0.5 * (step.basic_retracted + step.basic_extended)
            steps[field.name] = RotaryStep(
                basic_retracted=mean, basic_extended=mean, load_retracted=0.0, load_extended=0.0
            )
    return StepModel(**steps)


def prismatic_step(q2: Any, load: Any, basic: Any, recoil: Any, slope: Any) -> Any:
    """Step size (1) [m] at elbow angle ``q2`` and load factor ``load``."""
    return (1.0 - recoil * np.abs(np.cos(q2))) * (basic - slope * load)


def interpolate(q3: Any, retracted: Any, extended: Any, travel: Any) -> Any:
    """Linear interpolation (3) between the ends of the travel of joint 3."""
    return retracted + (extended - retracted) * q3 / travel


def rotary_step(
    q3: Any,
    load: Any,
    basic_retracted: Any,
    basic_extended: Any,
    load_retracted: Any,
    load_extended: Any,
    travel: Any,
) -> Any:
    """Step size (2, 3) [rad] at extension ``q3`` [m] and load factor ``load``."""
    basic = interpolate(q3, basic_retracted, basic_extended, travel)
    return basic + interpolate(q3, load_retracted, load_extended, travel) * load


def load_factors(q: Any, gravity: Any, force: Any, arm: Any) -> tuple[Any, Any, Any]:
    """Load factors of the three joints under ``gravity`` and tip ``force`` [N], both in frame 0."""
    load = dynamics.static_load(q, gravity, force, arm)
    level = (LEVEL[0], LEVEL[1], q[2])
    return (
        load[0] / (STANDARD_GRAVITY * dynamics.moment_1(level, arm)),
        load[1] / (STANDARD_GRAVITY * dynamics.moment_2(q, arm)),
        load[2] / (STANDARD_GRAVITY * arm.mass_3),
    )


def step_size(joint: int, side: int, q: Any, load: Any, table: Any, travel: Any) -> Any:
    """Step of ``joint`` (0, 1, 2) in direction ``side`` at joints ``q`` and its load factor."""
    p = table[joint, side]
    if joint == 2:
        return prismatic_step(q[1], load, p[0], p[1], p[2])
    return rotary_step(q[2], load, p[0], p[1], p[2], p[3], travel)
