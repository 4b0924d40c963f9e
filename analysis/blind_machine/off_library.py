"""Gaps that no id of the effect table explains: the right answer is ``unknown``."""

import numpy as np

from .c_drive import Machine
from .drive_effects import Draw, Effect, log_uniform


def hardening_spring(rng: np.random.Generator, m: Machine) -> Draw:
    """A cubic spring that resists the ends of the stroke."""
    end_force = log_uniform(rng, 12.0, 60.0)
    stiffness = end_force / abs(m.middle) ** 3
    return m._replace(hardening=stiffness), {"force_at_end_N": end_force}


def rough_patch(rng: np.random.Generator, m: Machine) -> Draw:
    """Dry friction on one short stretch of the stroke only."""
    force, centre = log_uniform(rng, 40.0, 150.0), float(rng.uniform(-0.075, -0.025))
    width = log_uniform(rng, 0.004, 0.015)
    changed = m._replace(patch=force, patch_centre=centre, patch_width=width)
    return changed, {"force_N": force, "centre_m": centre, "width_m": width}


def hum(rng: np.random.Generator, m: Machine) -> Draw:
    """A disturbance periodic in time, from a machine next door."""
    frequency, size = log_uniform(rng, 3.3, 60.0), log_uniform(rng, 0.08, 0.35)
    along = bool(rng.random() < 0.5)
    wave = (size * 200.0, 0.0) if along else (0.0, 2 * size)
    return m._replace(wave=wave, wave_frequency=frequency), {
        "frequency_Hz": frequency,
        "where": "translation" if along else "rotation",
        "torque_Nm": size,
    }


def square_drag(rng: np.random.Generator, m: Machine) -> Draw:
    """Resistance with the square of the collar's speed."""
    along, about = log_uniform(rng, 60.0, 250.0), log_uniform(rng, 2e-3, 8e-3)
    return m._replace(drag=(along, about)), {"along_N_s2_per_m2": along, "about_Nm_s2": about}


def impacts(rng: np.random.Generator, m: Machine) -> Draw:
    """Knocks on the collar at random times, a few a second."""
    impulse, rate = log_uniform(rng, 0.4, 1.5), float(rng.uniform(2.0, 8.0))
    return m, {"impulse_N_s": impulse, "per_second": rate}


def lost_commands(rng: np.random.Generator, m: Machine) -> Draw:
    """Commands that never arrive: the drive holds the one before, in bursts."""
    return m, {"share": float(rng.uniform(0.1, 0.3)), "burst": int(rng.integers(2, 5))}


def hidden_resonance(rng: np.random.Generator, m: Machine) -> Draw:
    """A heavy part sprung on the collar that no log shows."""
    mass, frequency = m.mass * float(rng.uniform(0.15, 0.6)), log_uniform(rng, 6.0, 25.0)
    damping = float(rng.uniform(0.01, 0.05))
    changed = m._replace(hidden_mass=mass, hidden_frequency=frequency, hidden_damping=damping)
    return changed, {"mass_kg": mass, "frequency_Hz": frequency, "damping_ratio": damping}


OFF_LIBRARY: dict[str, Effect] = {
    "hardening spring": hardening_spring,
    "rough patch": rough_patch,
    "hum": hum,
    "square drag": square_drag,
    "impacts": impacts,
    "lost commands": lost_commands,
    "hidden resonance": hidden_resonance,
}
