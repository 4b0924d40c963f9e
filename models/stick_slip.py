r"""A piezo stick-slip actuator: stack, friction contact and sliding mass.

.. math::
    m_p \ddot x + c \dot x + k x &= T (V - v) - f \\
    m \ddot y &= f - F

1. stack: length change :math:`x`, second order, driven by the voltage less the hysteresis :math:`v`
   of ``hysteresis.py`` (Goldfarb and Celanovic's form, section 2.2 of Damani 2013);
2. contact: :math:`f = \sigma_0 z + \sigma_1 e \dot z + \sigma_2 v_r` at contact speed :math:`v_r = \dot x - \dot y`,
   bristle :math:`z` by ``presliding.py``, level :math:`g = F_c + (F_s - F_c) e`, :math:`e = 1/(1 + (v_r/v_s)^2)`
   (the Stribeck curve of Hess and Soom 1990, without the costly exponential);
3. slider: position :math:`y`, load :math:`F` along the axis, positive against positive motion;
4. sawtooth: slow ramp and fast flyback, ramp first for a positive step, flyback first for a negative.

The bristle damping fades with the Stribeck factor e: constant, it would add a spurious impulse to every
breakaway. Chang and Li's model (section 2.2) is the same contact without hysteresis and presliding.
A rotary joint is the same actuator at a contact radius: mass J/r^2, load tau/r, angle y/r. Not modelled:
creep and self-heating of the stack, flexibility of the frame, wear.
"""

from collections import namedtuple
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import friction, hysteresis, presliding

ELEMENTS = 3  # Maxwell elements
SETTLING = 0.4e-3  # from a flyback until the contact has stopped ringing [s]
QUIET_STEP = 7.0  # time step of the fixed-step loop when quiet, over that while ringing [-]
STATES = 5 + ELEMENTS  # x, x', y, y', z, hysteresis voltages
NONE, BOUC_WEN, MAXWELL = 0, 1, 2
HYSTERESES = {"none": NONE, "bouc_wen": BOUC_WEN, "maxwell": MAXWELL}


@dataclass(frozen=True, kw_only=True)
class Actuator:
    """Constants of one actuator; defaults are a stack and slider like joint 3 of the MM3A.

    **Chosen**, not printed: a stack of about 20 kHz, and stroke, friction level and flyback time such that
    the unloaded step and its load slope are near Fig. 4.13. Raises ValueError for constants out of range.
    """

    piezo_mass: float = 1.0e-3  # m_p, moving end of the stack [kg]
    piezo_damping: float = 60.0  # c [N s/m]
    piezo_stiffness: float = 1.6e7  # k [N/m]
    transduction: float = 0.472  # T [N/V]
    capacitance: float = 5.0e-8  # C [F]
    hysteresis: str = "bouc_wen"  # none, bouc_wen or maxwell
    bouc_wen: tuple[float, float, float] = (0.35, 0.02, 0.005)  # alpha [-], beta, gamma [1/V]
    maxwell_slope: tuple[float, float, float] = (6.0e6, 3.0e6, 1.5e6)  # kappa_i [V/C]
    maxwell_limit: tuple[float, float, float] = (3.0, 6.0, 9.0)  # v-bar_i [V]
    slider_mass: float = 2.0e-3  # m [kg]
    coulomb: float = 0.10  # F_c [N]
    breakaway: float = 0.02  # F_s - F_c [N]
    stribeck_speed: float = 2.0e-3  # v_s [m/s]
    presliding_stiffness: float = 1.0e6  # sigma_0 [N/m]
    presliding_damping: float = 20.0  # sigma_1 [N s/m]
    viscous: float = 0.0  # sigma_2 [N s/m]
    elastic_share: float = 0.6  # elastic limit over sliding deflection, 0 for LuGre [-]

    def __post_init__(self) -> None:
        if self.hysteresis not in HYSTERESES:
            raise ValueError(
                f"actuator: unknown hysteresis {self.hysteresis!r}; expected one of "
                f"{', '.join(HYSTERESES)}"
            )
        positive = [
            "piezo_mass",
            "piezo_stiffness",
            "transduction",
            "capacitance",
            "slider_mass",
            "coulomb",
            "stribeck_speed",
            "presliding_stiffness",
        ]
        for name in positive:
            if not getattr(self, name) > 0.0:
                raise ValueError(
                    f"actuator: {name} is {getattr(self, name)}; expected a positive number in SI "
                    "units"
                )
        for name in ("piezo_damping", "breakaway", "presliding_damping", "viscous"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"actuator: {name} is {getattr(self, name)}; expected >= 0")
        if not 0.0 <= self.elastic_share < 1.0:
            raise ValueError(f"actuator: elastic_share is {self.elastic_share}; expected [0, 1)")

    def constants(self) -> Any:
        """Take the same fields as a named tuple, which compiled kernels accept."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        values["hysteresis"] = HYSTERESES[self.hysteresis]
        return ActuatorConstants(**values)


# Generated from the fields above so that they are listed once; mypy cannot follow that.
ActuatorConstants: Any = namedtuple(  # type: ignore[misc]
    "ActuatorConstants", [field.name for field in fields(Actuator)]
)


@dataclass(frozen=True, kw_only=True)
class Sawtooth:
    """Drive voltage of one step: up to ``amplitude`` along the ramp, back along the flyback."""

    amplitude: float = 80.0  # [V]
    period: float = 0.010  # [s], section 4.1.2
    flyback: float = 1.3e-4  # [s]

    def __post_init__(self) -> None:
        if not (0.0 < self.flyback < self.period):
            raise ValueError(
                f"sawtooth: flyback {self.flyback} s, period {self.period} s; expected "
                "0 < flyback < period"
            )

    def segments(self, direction: int) -> list["Segment"]:
        """Straight pieces of one step in ``direction`` (-1 or 1); the ramp is cut where it turns quiet.

        The contact rings for some 0.1 ms after a flyback, which in a positive step is the one before.
        """
        duration = self.period - self.flyback
        up, down = self.amplitude / duration, -self.amplitude / self.flyback
        slope, start = (up, 0.0) if direction > 0 else (-up, self.amplitude)
        settling = min(SETTLING, duration)
        ramp = [Segment(start, slope, settling, False)]
        if duration > settling:
            ramp.append(Segment(start + slope * settling, slope, duration - settling, True))
        if direction > 0:
            return [*ramp, Segment(self.amplitude, down, self.flyback, False)]
        return [Segment(0.0, -down, self.flyback, False), *ramp]


class Segment(NamedTuple):
    """A straight piece of the drive voltage."""

    start: float  # [V]
    slope: float  # [V/s]
    duration: float  # [s]
    quiet: bool  # long after the last flyback


def fade(speed: Any, actuator: Any) -> Any:
    """Stribeck factor e (2) at contact ``speed`` [m/s]: 1 at rest, 0 when sliding fast."""
    ratio = speed / actuator.stribeck_speed
    return 1.0 / (1.0 + ratio * ratio)


def level(rest: Any, actuator: Any) -> Any:
    """Friction level g [N] (2) at Stribeck factor ``rest``."""
    return actuator.coulomb + actuator.breakaway * rest


def sliding_deflection(speed: Any, actuator: Any) -> Any:
    """Bristle deflection g/sigma_0 [m] of steady sliding at ``speed`` [m/s]."""
    return level(fade(speed, actuator), actuator) / actuator.presliding_stiffness


def contact(speed: Any, deflection: Any, actuator: Any) -> tuple[Any, Any, Any]:
    """Friction on the slider [N], bristle rate [m/s] and plastic share at contact ``speed`` (2)."""
    rest = fade(speed, actuator)
    limit = level(rest, actuator)
    steady = limit / actuator.presliding_stiffness
    share = presliding.plastic_share(speed, deflection, actuator.elastic_share * steady, steady)
    rate = friction.bristle_rate(speed, deflection, share * actuator.presliding_stiffness, limit)
    force = friction.bristle_force(
        deflection, rate, actuator.presliding_stiffness, actuator.presliding_damping * rest
    ) + friction.viscous(speed, actuator.viscous)
    return force, rate, share


def derivatives(
    state: Any, voltage: Any, slope: Any, load: Any, actuator: Any
) -> tuple[Any, Any, Any, Any, Any, Any, Any, Any]:
    """Time derivative of (x, x', y, y', z, v_1, v_2, v_3) under ``voltage`` [V], ``slope`` [V/s]."""
    x, dx, _, dy, z, v1, v2, v3 = state
    force, dz, _ = contact(dx - dy, z, actuator)
    lost = v1 + v2 + v3
    ddx = (
        actuator.transduction * (voltage - lost)
        - force
        - actuator.piezo_damping * dx
        - actuator.piezo_stiffness * x
    ) / actuator.piezo_mass
    ddy = (force - load) / actuator.slider_mass
    r1, r2, r3 = _hysteresis_rates(v1, v2, v3, slope, dx, actuator)
    return dx, ddx, dy, ddy, dz, r1, r2, r3


def _hysteresis_rates(
    v1: Any, v2: Any, v3: Any, slope: Any, length_rate: Any, actuator: Any
) -> tuple[Any, Any, Any]:
    if actuator.hysteresis == BOUC_WEN:
        alpha, beta, gamma = actuator.bouc_wen
        return hysteresis.bouc_wen_rate(v1, slope, alpha, beta, gamma), 0.0, 0.0
    if actuator.hysteresis != MAXWELL:
        return 0.0, 0.0, 0.0
    # Whatever sticks, the charge moves the way the drive and the stack's length push it.
    direction = slope + actuator.transduction * length_rate / actuator.capacitance
    k, limit = actuator.maxwell_slope, actuator.maxwell_limit
    k1 = k[0] if hysteresis.element_sticks(v1, limit[0], direction) else 0.0
    k2 = k[1] if hysteresis.element_sticks(v2, limit[1], direction) else 0.0
    k3 = k[2] if hysteresis.element_sticks(v3, limit[2], direction) else 0.0
    rate = hysteresis.charge_rate(
        slope, length_rate, actuator.transduction, actuator.capacitance, k1 + k2 + k3
    )
    return k1 * rate, k2 * rate, k3 * rate


@dataclass(frozen=True, kw_only=True)
class Response:
    """Motion of the slider over consecutive steps of the drive."""

    steps: NDArray[np.float64]  # (n,) signed net motion per step [m]
    time: NDArray[np.float64]  # (samples,) [s]
    states: NDArray[np.float64]  # (samples, 8) x, x', y, y', z, v_1, v_2, v_3
    final: NDArray[np.float64]  # (8,) state at the end


def simulate(
    actuator: Actuator,
    drive: Sawtooth,
    *,
    steps: int = 12,
    direction: int = 1,
    load: float = 0.0,
    slider_mass: float | None = None,
    time_step: float = 2.0e-6,
    every: int = 0,
    initial: NDArray[np.float64] | None = None,
) -> Response:
    """Play ``steps`` sawtooth periods from rest, compiled, by RK4 at ``time_step`` or just below.

    Long after a flyback, where nothing rings, the step is ``QUIET_STEP`` times that.
    ``load`` [N] opposes positive motion; ``slider_mass`` [kg] replaces that of the actuator; with ``every`` > 0
    each such sample of the state is kept; ``initial`` (8,) is a state to go on from, at 0 V. The first periods settle bristle and hysteresis: use
    ``settled_step`` for a step size. Raises ValueError for a load beyond the friction, and if the motion diverges, which
    ``time_step`` causes.
    """
    from . import stick_slip_kernel

    if not abs(load) < actuator.coulomb:
        raise ValueError(
            f"load {load} N exceeds the friction {actuator.coulomb} N; expected a load the contact holds"
        )
    if slider_mass is not None:
        actuator = replace(actuator, slider_mass=slider_mass)
    pieces = [_cut(segment, time_step) for segment in drive.segments(direction)]
    per_period = int(sum(count for *_, count in pieces))
    samples = 1 + (steps * per_period) // every if every else 1
    time, states = np.zeros(samples), np.zeros((samples, STATES))
    final = np.zeros(STATES) if initial is None else np.array(initial, dtype=float)
    states[0] = final
    motion = stick_slip_kernel.play(
        np.array(pieces), steps, float(load), actuator.constants(), every, time, states, final
    )
    if not np.all(np.isfinite(motion)):
        raise ValueError(
            f"the actuator diverges at time_step {time_step} s; expected a time step well below "
            f"{2.8 * np.sqrt(actuator.piezo_mass / actuator.piezo_stiffness):.1e} s, RK4's limit for "
            "this stack"
        )
    return Response(steps=motion, time=time, states=states, final=final)


def _cut(segment: Segment, time_step: float) -> tuple[float, float, float, int]:
    """Start [V], slope [V/s], step [s] and number of steps of one segment."""
    longest = QUIET_STEP * time_step if segment.quiet else time_step
    count = max(1, int(np.ceil(segment.duration / longest - 1e-9)))
    return segment.start, segment.slope, segment.duration / count, count


def settled_step(actuator: Actuator, drive: Sawtooth, **conditions: Any) -> float:
    """Mean step [m] of the last four of twelve, signed; ``conditions`` are those of ``simulate``."""
    return float(simulate(actuator, drive, steps=12, **conditions).steps[-4:].mean())


LAW_MODULES = (friction, hysteresis, presliding)
