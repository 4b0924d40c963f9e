"""Moves by the empirical step law, with effects planted in it: the law that hypotheses use, too."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...models.mm3a import stepper
from ...models.mm3a.arm import Arm, gravity_in_base
from ...models.mm3a.step_size import STEP_TIME, PrismaticStep, RotaryStep, StepModel
from ...models.mm3a.stepper import Conditions
from ..errors import InputError
from .moves import Series

Step = PrismaticStep | RotaryStep
FIELDS = ("joint_2_negative", "joint_2_positive", "joint_3_negative", "joint_3_positive")
ASYMMETRY = 0.08  # of step.direction
PAYLOAD = 0.5e-3  # of inertia.payload [kg]
DAY = 0.06  # factor of the second session less 1
WARMING, WARM_UP = 0.05, 40_000.0  # growth, and steps to 63 % of it
REVERSAL_LOSS = 0.9  # of the first step back


@dataclass(frozen=True, kw_only=True)
class Planted:
    """A step law that moves the arm, the one that is stated, and the conditions of the sessions."""

    true: StepModel
    stated: StepModel
    sessions: tuple[Conditions, ...]  # by session, the last for all further ones
    payload: float = 0.0  # [kg]

    def nominal(self) -> dict[str, Any]:
        """``system.nominal`` of the log set."""
        return {name: _stated(getattr(self.stated, name)) for name in FIELDS}


def plant(*effects: str) -> Planted:
    """The printed step model with ``effects`` between it and what is stated. InputError for others."""
    planted = Planted(true=StepModel(), stated=StepModel(), sessions=(Conditions(), Conditions()))
    for effect in effects:
        if effect not in EFFECTS:
            raise InputError(
                "--effect", f"unknown effect {effect!r}", f"one of {', '.join(EFFECTS)}"
            )
        planted = EFFECTS[effect](planted)
    return planted


class EmpiricalMover:
    """Plays every step by ``models/mm3a/stepper.py``."""

    def __init__(self, planted: Planted) -> None:
        self._planted, self._arm = planted, Arm()
        self._table = planted.true.table()
        self._conditions = planted.sessions[-1]
        self._begun = 0

    def begin(self, session: str) -> None:
        """Take the conditions of the next session."""
        sessions = self._planted.sessions
        self._conditions = sessions[min(self._begun, len(sessions) - 1)]
        self._begun += 1
        self._last = np.zeros(3, dtype=np.int64)
        self._taken = np.zeros(3, dtype=np.int64)

    def move(self, series: Series, q: NDArray[np.float64], steps: int, t: float) -> float:
        """Displacement of the logged steps, after the run-in."""
        joint, direction = series.joint - 1, 1 if steps > 0 else -1
        tilted = replace(self._conditions, theta=series.theta)
        weight: Any = np.multiply(gravity_in_base(series.theta, 0.0), self._planted.payload)
        session = tilted.session()._replace(force=(weight[0], weight[1], weight[2]))
        # Heat comes with time; at one step in STEP_TIME it is counted in steps.
        self._taken[joint] = round(t / STEP_TIME)
        if series.run_in:
            self._last[joint] = direction
        here = q.copy()
        for _ in range(abs(steps)):
            stepper.coarse_step(
                joint,
                direction,
                here,
                self._last,
                self._taken,
                self._table,
                session,
                self._arm,
                self._arm.lower,
                self._arm.upper,
            )
        return float(here[joint] - q[joint])


def _stated(step: Step) -> dict[str, float]:
    return {name: float(value) for name, value in vars(step).items()}


def _changed(model: StepModel, **changes: Any) -> StepModel:
    return replace(model, **changes)


def _without(model: StepModel, *terms: str) -> StepModel:
    """The model with these terms zero, in every joint that has them."""
    steps = {}
    for name in FIELDS:
        step: Any = getattr(model, name)
        known = {term: 0.0 for term in terms if hasattr(step, term)}
        steps[name] = replace(step, **known)
    return _changed(model, **steps)


def _load(p: Planted) -> Planted:
    return replace(p, stated=_without(p.stated, "load", "load_retracted", "load_extended"))


def _recoil(p: Planted) -> Planted:
    return replace(p, stated=_without(p.stated, "recoil"))


def _direction(p: Planted) -> Planted:
    steps: dict[str, Any] = {}
    for name in FIELDS:
        factor = 1.0 + (ASYMMETRY if name.endswith("positive") else -ASYMMETRY)
        step: Any = getattr(p.true, name)
        basic = {k: v * factor for k, v in vars(step).items() if k != "recoil"}
        steps[name] = replace(step, **basic)
    return replace(p, true=_changed(p.true, **steps))


def _drift(p: Planted) -> Planted:
    first, second = p.sessions
    both = (1.0 + DAY, 1.0 + DAY)
    return replace(p, sessions=(first, replace(second, scale=(both, both, both))))


def _warming(p: Planted) -> Planted:
    return replace(
        p,
        sessions=tuple(
            replace(c, heating=(WARMING, WARMING, WARMING), heating_steps=WARM_UP)
            for c in p.sessions
        ),
    )


def _payload(p: Planted) -> Planted:
    return replace(p, payload=p.payload + PAYLOAD)


def _hysteresis(p: Planted) -> Planted:
    return replace(
        p,
        sessions=tuple(
            replace(c, reversal_loss=(REVERSAL_LOSS, REVERSAL_LOSS, REVERSAL_LOSS))
            for c in p.sessions
        ),
    )


EFFECTS = {
    "step.load": _load,
    "step.recoil": _recoil,
    "step.direction": _direction,
    "step.drift": _drift,
    "step.drift:warming": _warming,
    "inertia.payload": _payload,
    "actuator.hysteresis": _hysteresis,
}
