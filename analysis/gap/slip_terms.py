r"""What effects change in a stick-slip step, after how such a step comes about.

A step is the stroke D of the stack less what the slider falls back when the stack flies back (Chang and
Li 1999, ``models/chang_li.py``). Effects change one or the other, by an amount and not by a share of the step:

1. fallback      :math:`b(x, i) = B\,\frac{1 + x}{1 - x}\,/\,i`, load over friction x = s p / grip, inertia i
2. heavier tip   :math:`\Delta\gamma = b(x, i) - b(x', i')`, load and inertia with the mass on the tip
3. swing         :math:`\Delta\gamma = w + w_s\,s p`: a rotary joint's heavy slider still swings on its contact at the next
   flyback, in a phase that its inertia sets and with a size that load and direction set: a changed inertia shifts
   its steps, by amounts that change with the extension
4. flyback       :math:`\Delta\gamma = -c_s\,b(x, i)/B`, other flyback times by direction s
5. frame         :math:`\Delta\gamma = -R\,\frac{(1 + f)\cos^2 q_2}{1 + f\cos^2 q_2}` of joint 3: a frame in series with the stack
6. stroke        :math:`\Delta\gamma` by session, or :math:`w(1 - e^{-t/\tau})`: voltage, heat or age of the stack
7. reversal      :math:`(r_s + r_{p s}\,s p)/i`, once per move that reverses the one before it

p is the load and i the inertia of the joint, over those of the level, retracted arm (in 1 g): B, w and r are
amounts there [rad or m], and grip is the friction over that arm's weight.
"""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models import chang_li
from ...models.mm3a import dynamics, kinematics, step_size
from ...models.mm3a.arm import STANDARD_GRAVITY, Arm
from .machine import Array

if TYPE_CHECKING:
    from .step_machine import MoveRun

PRISMATIC = 2  # index of the joint that slides
LIGHTEST = 0.1  # inertia that is left at least, whatever a negative mass on the tip takes off
HOLDS = 0.95  # load over friction from which (1) is kept: beyond it the contact holds nothing


def _joints() -> Array:
    return np.zeros(3)


def _sides() -> Array:
    return np.zeros((3, 2))


@dataclass
class SlipTerms:
    """Amounts by joint, then side (-, +) or end of joint 3's travel; zero changes nothing."""

    mass: float = 0.0  # on the tip, by (2, 3) [kg]
    fallback: Array = field(default_factory=_joints)  # B [rad or m]
    grip: Array = field(default_factory=lambda: np.full(3, np.inf))  # p that slips [-]
    swing: Array = field(default_factory=_sides)  # w retracted, extended [rad or m]
    swing_load: Array = field(default_factory=lambda: np.zeros((3, 2, 2)))  # w_s by side, then end
    flyback: Array = field(default_factory=_sides)  # c [rad or m]
    flyback_grip: Array = field(default_factory=lambda: np.full(3, np.inf))  # as grip, in (4) [-]
    frame: float = 0.0  # R, stroke lost at cos q2 = 1 [m]
    compliance: float = 0.0  # f, of the frame over that of the stack [-]
    warming: Array = field(default_factory=_joints)  # w [rad or m]
    day: dict[tuple[int, int], float] = field(default_factory=dict)  # by session, joint [rad or m]
    reversal: Array = field(default_factory=_sides)  # r [rad or m]
    reversal_load: Array = field(default_factory=_sides)  # r_p [rad or m]


def burden(
    posture: tuple[Array, Array, Array], gravity: Array, force: Array, joint: int, arm: Arm
) -> dict[str, Any]:
    """Load and inertia of a joint over those of the level, retracted arm in 1 g, and what a kg on the tip adds.

    Arrays like those of ``posture``, by the name of their field of ``MoveRun``.
    """
    level, up = (*step_size.LEVEL, arm.lower_3), STANDARD_GRAVITY
    weight = (
        up * dynamics.moment_1(level, arm),
        up * dynamics.moment_2(level, arm),
        up * arm.mass_3,
    )
    load = dynamics.static_load(posture, gravity, force, arm)[joint]
    heavier = dynamics.static_load(posture, gravity, force + gravity, arm)[joint]
    inertia = dynamics.mass_diagonal(posture, arm)[joint]
    added = sum(np.square(row[joint]) for row in kinematics.jacobian(posture, arm))
    reference = float(dynamics.mass_diagonal(level, arm)[joint])
    nothing = np.zeros_like(posture[0])
    return {
        "pull": load / weight[joint] + nothing,
        "pull_per_kg": (heavier - load) / weight[joint] + nothing,
        "inertia": inertia / reference + nothing,
        "inertia_per_kg": added / reference + nothing,
    }


def step_change(run: "MoveRun", terms: SlipTerms, warm_up: float) -> Array:
    """Change (2) to (6) of a step along every move, (moves, nodes) [rad or m]."""
    j = run.joint
    change = np.full_like(run.pull, terms.day.get((run.session, j), 0.0))
    change += (terms.warming[j] * (1.0 - np.exp(-run.t / warm_up)))[:, None]
    if np.any(terms.flyback[j]):
        change -= terms.flyback[j, run.side][:, None] * _loss(run, terms.flyback_grip, 0.0)
    if j == PRISMATIC and terms.frame:
        square = np.cos(run.elbow) ** 2
        change -= terms.frame * (1 + terms.compliance) * square / (1 + terms.compliance * square)
    if terms.mass:
        change += terms.fallback[j] * (
            _loss(run, terms.grip, 0.0) - _loss(run, terms.grip, terms.mass)
        )
        change += _swing(run, terms)
    return change


def reversal_gain(run: "MoveRun", terms: SlipTerms) -> Array:
    """What moves that reverse the one before gain (7), (moves,) [rad or m]."""
    j = run.joint
    opposing = (2.0 * run.side - 1.0) * run.pull.mean(axis=1)
    gain = terms.reversal[j, run.side] + terms.reversal_load[j, run.side] * opposing
    return np.asarray(gain * run.reverses / run.inertia.mean(axis=1))


def _ratio(run: "MoveRun", grip: Array, mass: float) -> Array:
    """Load over friction x, positive where it opposes the move."""
    load = (run.pull + mass * run.pull_per_kg) * (2.0 * run.side - 1.0)[:, None]
    return np.asarray(np.clip(load / grip[run.joint], -HOLDS, HOLDS))


def _loss(run: "MoveRun", grip: Array, mass: float) -> Array:
    """Fallback (1) over B."""
    inertia = np.maximum(run.inertia + mass * run.inertia_per_kg, LIGHTEST)
    return np.asarray(chang_li.loss_factor(_ratio(run, grip, mass)) / inertia)


def _swing(run: "MoveRun", terms: SlipTerms) -> Array:
    """Shift (3) of a step, interpolated between the ends of the travel of joint 3."""
    ends = [1.0 - run.extension, run.extension]
    opposing = run.pull * (2.0 * run.side - 1.0)[:, None]
    slopes = terms.swing_load[run.joint, run.side]
    shift = [
        share * (terms.swing[run.joint, k] + slopes[:, k, None] * opposing)
        for k, share in enumerate(ends)
    ]
    return np.asarray(sum(shift))
