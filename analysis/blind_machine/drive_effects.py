"""What may be wrong with a C-drive: one draw per mechanism, named by the ids of the effect table.

Every function takes a random generator and a machine and returns the changed machine with the
parameters that were drawn (SI units, in their names). Sizes run from just visible to severe; the
measured excitation of each case, not the intention here, decides what a score counts.
"""

from collections.abc import Callable

import numpy as np

from .c_drive import ENCODER_LSB, Machine

Draw = tuple[Machine, dict[str, object]]
Effect = Callable[[np.random.Generator, Machine], Draw]


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A number as likely in one octave of its range as in another."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def either_sign(rng: np.random.Generator) -> float:
    """Plus or minus one."""
    return float(rng.choice((-1.0, 1.0)))


def sides(rng: np.random.Generator, low: float, high: float) -> tuple[str, tuple[float, float]]:
    """A side and its factors: both (equal), left or right."""
    size = log_uniform(rng, low, high)
    side = str(rng.choice(("both", "left", "right")))
    return side, (0.0 if side == "right" else size, 0.0 if side == "left" else size)


def viscous(rng: np.random.Generator, m: Machine) -> Draw:
    """More (or less) velocity-proportional friction in bearings, nuts or one bearing."""
    place = str(rng.choice(("bearings", "nuts", "left", "right")))
    factor = log_uniform(rng, 1.8, 4.0) if rng.random() < 0.8 else float(rng.uniform(0.1, 0.5))
    if place == "nuts":
        return m._replace(gamma=m.gamma * factor), {"where": place, "factor": factor}
    left = m.beta[0] * (factor if place != "right" else 1.0)
    right = m.beta[1] * (factor if place != "left" else 1.0)
    return m._replace(beta=(left, right)), {"where": place, "factor": factor}


def coulomb(rng: np.random.Generator, m: Machine) -> Draw:
    """Dry friction in both bearings, one of them, the collar, or more one way than the other."""
    place = str(rng.choice(("both", "left", "right", "collar", "directional")))
    size = log_uniform(rng, 0.09, 0.4)
    even, none = (size, size), (0.0, 0.0)
    limits = {
        "both": (even, even, none),
        "left": (even, none, none),
        "right": (none, even, none),
        "collar": (none, none, even),
        "directional": ((size, 0.4 * size), (size, 0.4 * size), none),
    }[place]
    return m._replace(coulomb=limits), {"where": place, "level_Nm": size}


def stribeck(rng: np.random.Generator, m: Machine) -> Draw:
    """Dry friction in both bearings that falls with speed."""
    level, ratio = log_uniform(rng, 0.06, 0.18), float(rng.uniform(2.0, 3.5))
    speed = log_uniform(rng, 3.0, 20.0)
    even = (level, level)
    changed = m._replace(
        coulomb=(even, even, (0.0, 0.0)), stribeck_ratio=ratio, stribeck_speed=speed
    )
    return changed, {"level_Nm": level, "breakaway_ratio": ratio, "speed_rad_per_s": speed}


def presliding(rng: np.random.Generator, m: Machine) -> Draw:
    """Elastic, hysteretic bearings: the dry torque builds up over a visible angle."""
    level, reach = log_uniform(rng, 0.1, 0.35), log_uniform(rng, 0.3, 2.0)
    even = (level, level)
    changed = m._replace(coulomb=(even, even, (0.0, 0.0)), presliding=reach)
    return changed, {"level_Nm": level, "reach_rad": reach}


def load_dependent(rng: np.random.Generator, m: Machine) -> Draw:
    """Friction in proportion to motor torque."""
    side, share = sides(rng, 0.1, 0.35)
    return m._replace(load_friction=share), {"where": side, "share": max(share)}


def thermal_drift(rng: np.random.Generator, m: Machine) -> Draw:
    """Stiff when cold: viscous and dry friction fade as the machine runs, over several of its runs."""
    time = float(rng.uniform(60.0, 300.0))
    thick = log_uniform(rng, 1.0, 3.0)
    dry = float(rng.choice((0.0, 1.0))) * log_uniform(rng, 0.05, 0.2)
    changed = m._replace(warm_viscous=thick, warm_coulomb=dry, warm_time=time)
    return changed, {"time_constant_s": time, "viscous_excess": thick, "coulomb_Nm": dry}


def backlash(rng: np.random.Generator, m: Machine) -> Draw:
    """Clearance in both nuts or one, closed by a stiff one-sided contact."""
    side, gap = sides(rng, 0.008, 0.04)
    changed = m._replace(gap=gap, stiffness=log_uniform(rng, 2000.0, 6000.0), coupling_damping=0.2)
    return changed, {"where": side, "gap_rad": max(gap)}


def compliance(rng: np.random.Generator, m: Machine) -> Draw:
    """Springs between screws and collar."""
    stiffness, ratio = log_uniform(rng, 15.0, 90.0), float(rng.uniform(0.12, 0.3))
    damping = 2 * ratio * np.sqrt(stiffness * m.rotor_inertia)
    changed = m._replace(stiffness=stiffness, coupling_damping=float(damping))
    return changed, {"stiffness_Nm_per_rad": stiffness, "damping_Nms_per_rad": float(damping)}


def delay(rng: np.random.Generator, m: Machine) -> Draw:
    """Transport delay of the command, not necessarily whole samples."""
    time = float(rng.choice((1e-3, 2e-3, rng.uniform(0.8e-3, 2.6e-3))))
    return m._replace(delay=time), {"delay_s": time}


def lag(rng: np.random.Generator, m: Machine) -> Draw:
    """Slow torque loop, of first or second order."""
    time, order = log_uniform(rng, 0.9e-3, 3.2e-3), int(rng.integers(1, 3))
    return m._replace(lag=time, lag_order=order), {"time_constant_s": time, "order": order}


def saturation(rng: np.random.Generator, m: Machine) -> Draw:
    """The amplifier gives no more than a limit below what the fastest runs ask for."""
    limit = float(rng.uniform(2.1, 2.62))
    return m._replace(limit=limit), {"limit_Nm": limit}


def torque_constant(rng: np.random.Generator, m: Machine) -> Draw:
    """One or both motors give more or less than commanded."""
    side, change = sides(rng, 0.1, 0.3)
    sign = either_sign(rng)
    gain = (1 + sign * change[0], 1 + sign * change[1])
    return m._replace(gain=gain), {"where": side, "gain": 1 + sign * max(change)}


def ripple(rng: np.random.Generator, m: Machine) -> Draw:
    """Torque periodic in motor angle."""
    side, size = sides(rng, 0.09, 0.35)
    order, phase = log_uniform(rng, 1.0, 12.0), float(rng.uniform(0, 2 * np.pi))
    changed = m._replace(ripple=size, ripple_order=order, ripple_phase=phase)
    return changed, {"where": side, "amplitude_Nm": max(size), "per_revolution": order}


def payload(rng: np.random.Generator, m: Machine) -> Draw:
    """More mass, or more inertia, or both, on the collar."""
    place = str(rng.choice(("mass", "inertia", "mass and inertia")))
    mass = m.mass * log_uniform(rng, 0.4, 1.4) if "mass" in place else 0.0
    share = log_uniform(rng, 0.15, 0.7) if "inertia" in place else 0.0
    inertia = m.turning_inertia * share
    changed = m._replace(mass=m.mass + mass, turning_inertia=m.turning_inertia + inertia)
    return changed, {"where": place, "mass_kg": mass, "inertia_kg_m2": inertia}


def bias(rng: np.random.Generator, m: Machine) -> Draw:
    """A constant force along the stroke, torque about it, or torque on one screw."""
    place = str(rng.choice(("translation", "rotation", "left", "right")))
    size = either_sign(rng) * log_uniform(rng, 0.09, 0.4)
    torque = {"left": (size, 0.0), "right": (0.0, size), "rotation": (size, size)}
    if place == "translation":
        return m._replace(bias_screw=(size, -size)), {"where": place, "torque_Nm": size}
    return m._replace(bias_screw=torque[place]), {"where": place, "torque_Nm": size}


def quantisation(rng: np.random.Generator, m: Machine) -> Draw:
    """An encoder 2 to 3.6 bits coarser than stated."""
    factor = float(rng.choice((4.0, 6.0, 8.0, 12.0)))
    return m._replace(lsb=factor * ENCODER_LSB), {"step_rad": factor * ENCODER_LSB}


def scale(rng: np.random.Generator, m: Machine) -> Draw:
    """Encoders that count too many or too few per turn, for loop and log or for the log alone."""
    alone = bool(rng.random() < 1 / 3)
    side, change = sides(rng, 0.0005, 0.003) if alone else sides(rng, 0.05, 0.14)
    sign = either_sign(rng)
    factors = (1 + sign * change[0], 1 + sign * change[1])
    changed = m._replace(log_scale=factors) if alone else m._replace(scale=factors)
    size = {"scale": 1 + sign * max(change)}
    return changed, {"where": side, "seen_by": "log" if alone else "loop and log", **size}


def offset(rng: np.random.Generator, m: Machine) -> Draw:
    """A zero that is off, in the log alone or for the controller too (a step at the start)."""
    alone = bool(rng.random() < 2 / 3)
    side, size = sides(rng, 0.003, 0.02) if alone else sides(rng, 0.03, 0.1)
    sign = either_sign(rng)
    offsets = (sign * size[0], sign * size[1])
    changed = m._replace(log_offset=offsets) if alone else m._replace(offset=offsets)
    seen = {"seen_by": "log" if alone else "loop and log", "offset_rad": sign * max(size)}
    return changed, {"where": side, **seen}


def timing(rng: np.random.Generator, m: Machine) -> Draw:
    """Positions logged early or late against torques, or both late against the reference."""
    if rng.random() < 0.5:
        late = int(rng.integers(1, 5))
        return m._replace(log_late=late), {"where": "positions and torques", "late_s": late * 1e-3}
    age = either_sign(rng) * log_uniform(rng, 0.3e-3, 3e-3)
    return m._replace(log_clock=age), {"where": "positions", "late_s": age}


EFFECTS: dict[str, Effect] = {
    "friction.viscous": viscous,
    "friction.coulomb": coulomb,
    "friction.stribeck": stribeck,
    "friction.presliding": presliding,
    "friction.load_dependent": load_dependent,
    "friction.thermal_drift": thermal_drift,
    "transmission.backlash": backlash,
    "transmission.compliance": compliance,
    "actuator.delay": delay,
    "actuator.lag": lag,
    "actuator.saturation": saturation,
    "actuator.torque_constant": torque_constant,
    "actuator.ripple": ripple,
    "inertia.payload": payload,
    "load.bias": bias,
    "sensor.quantisation": quantisation,
    "sensor.scale": scale,
    "sensor.offset": offset,
    "sensor.timing": timing,
}
