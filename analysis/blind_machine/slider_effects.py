"""What may be wrong with a slider: one draw per mechanism, as for the drive.

Compliance is missing: with this controller and the encoder on the load, a screw soft enough to be
seen (below 80 Hz) makes the loop unstable.
"""

from collections.abc import Callable

import numpy as np

from .drive_effects import either_sign, log_uniform
from .slider import ENCODER_LSB, FORCE_PER_VOLT, Slider

Draw = tuple[Slider, dict[str, object]]
Random = np.random.Generator


def viscous(rng: Random, m: Slider) -> Draw:
    """More, or less, velocity-proportional friction."""
    factor = log_uniform(rng, 1.3, 2.5) if rng.random() < 0.7 else float(rng.uniform(0.3, 0.7))
    return m._replace(viscous=m.viscous * factor), {"factor": factor}


def coulomb(rng: Random, m: Slider) -> Draw:
    """Dry friction, the same both ways or less backward."""
    level, back = log_uniform(rng, 10.0, 50.0), float(rng.choice((1.0, 1.0, 0.4)))
    return m._replace(coulomb=(level, back * level)), {"level_N": level, "backward_share": back}


def stribeck(rng: Random, m: Slider) -> Draw:
    """Dry friction that falls with speed."""
    level, ratio = log_uniform(rng, 10.0, 30.0), float(rng.uniform(2.0, 3.5))
    speed = log_uniform(rng, 0.01, 0.06)
    changed = m._replace(coulomb=(level, level), stribeck_ratio=ratio, stribeck_speed=speed)
    return changed, {"level_N": level, "breakaway_ratio": ratio, "speed_m_per_s": speed}


def presliding(rng: Random, m: Slider) -> Draw:
    """Dry force that builds up over a visible distance."""
    level, reach = log_uniform(rng, 15.0, 50.0), log_uniform(rng, 2e-3, 15e-3)
    changed = m._replace(coulomb=(level, level), presliding=reach)
    return changed, {"level_N": level, "reach_m": reach}


def load_dependent(rng: Random, m: Slider) -> Draw:
    """Friction in proportion to motor force."""
    share = log_uniform(rng, 0.08, 0.3)
    return m._replace(load_friction=share), {"share": share}


def thermal_drift(rng: Random, m: Slider) -> Draw:
    """Stiff when cold: friction fades over several runs."""
    time, thick = float(rng.uniform(60.0, 300.0)), log_uniform(rng, 0.6, 2.0)
    dry = float(rng.choice((0.0, 1.0))) * log_uniform(rng, 8.0, 30.0)
    changed = m._replace(warm_viscous=thick, warm_coulomb=dry, warm_time=time)
    return changed, {"time_constant_s": time, "viscous_excess": thick, "coulomb_N": dry}


def backlash(rng: Random, m: Slider) -> Draw:
    """Clearance between screw and carriage."""
    gap = log_uniform(rng, 20e-6, 100e-6)
    changed = m._replace(gap=gap, stiffness=3e7, coupling_damping=2e4)
    return changed, {"gap_m": gap}


def delay(rng: Random, m: Slider) -> Draw:
    """Transport delay of the command."""
    time = float(rng.choice((2e-3, 4e-3, rng.uniform(2e-3, 5e-3))))
    return m._replace(delay=time), {"delay_s": time}


def lag(rng: Random, m: Slider) -> Draw:
    """Slow force loop."""
    time, order = log_uniform(rng, 2.5e-3, 5e-3), int(rng.integers(1, 3))
    return m._replace(lag=time, lag_order=order), {"time_constant_s": time, "order": order}


def saturation(rng: Random, m: Slider) -> Draw:
    """A force limit just below what the fastest run asks for."""
    limit = float(rng.uniform(0.92, 0.985)) * 198.0
    return m._replace(limit=limit), {"limit_N": limit}


def torque_constant(rng: Random, m: Slider) -> Draw:
    """More or less force per volt than stated."""
    gain = 1 + either_sign(rng) * log_uniform(rng, 0.08, 0.3)
    changed = m._replace(gain=gain)
    return changed, {"gain": gain, "force_per_volt_N": gain * FORCE_PER_VOLT}


def ripple(rng: Random, m: Slider) -> Draw:
    """Force periodic in position."""
    size, length = log_uniform(rng, 8.0, 40.0), log_uniform(rng, 4e-3, 4e-2)
    changed = m._replace(
        ripple=size, ripple_length=length, ripple_phase=float(rng.uniform(0, 2 * np.pi))
    )
    return changed, {"amplitude_N": size, "length_m": length}


def payload(rng: Random, m: Slider) -> Draw:
    """More mass on the carriage."""
    mass = m.mass * log_uniform(rng, 0.1, 0.6)
    return m._replace(mass=m.mass + mass), {"mass_kg": mass}


def bias(rng: Random, m: Slider) -> Draw:
    """A constant force."""
    size = either_sign(rng) * log_uniform(rng, 8.0, 40.0)
    return m._replace(bias=size), {"force_N": size}


def scale(rng: Random, m: Slider) -> Draw:
    """A logged position that counts too many or too few per metre."""
    factor = 1 + either_sign(rng) * log_uniform(rng, 2e-4, 3e-3)
    return m._replace(log_scale=factor), {"seen_by": "log", "scale": factor}


def offset(rng: Random, m: Slider) -> Draw:
    """A logged zero that is off."""
    size = either_sign(rng) * log_uniform(rng, 5e-5, 1e-3)
    return m._replace(log_offset=size), {"seen_by": "log", "offset_m": size}


def quantisation(rng: Random, m: Slider) -> Draw:
    """A much coarser encoder than stated."""
    lsb = ENCODER_LSB * float(rng.choice((100.0, 200.0, 400.0)))
    return m._replace(lsb=lsb), {"step_m": lsb}


def timing(rng: Random, m: Slider) -> Draw:
    """Positions logged early or late against the drive command, or both late against the reference."""
    if rng.random() < 0.5:
        late = int(rng.integers(1, 5))
        return m._replace(log_late=late), {"where": "position and command", "late_s": late * 1e-3}
    age = either_sign(rng) * log_uniform(rng, 0.3e-3, 3e-3)
    return m._replace(log_clock=age), {"where": "position", "late_s": age}


EFFECTS: dict[str, Callable[[Random, Slider], Draw]] = {
    "friction.viscous": viscous,
    "friction.coulomb": coulomb,
    "friction.stribeck": stribeck,
    "friction.presliding": presliding,
    "friction.load_dependent": load_dependent,
    "friction.thermal_drift": thermal_drift,
    "transmission.backlash": backlash,
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
