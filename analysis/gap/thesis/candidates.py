"""Which effects of the catalogue RMS values of whole cycles can speak of, and their typical sizes."""

from collections.abc import Sequence

import numpy as np

from ....models import motion, thesis_tables
from ....models.benchmark import LSB
from ....models.motion import C_DRIVE_MOTIONS
from ..drive_machine import DriveMachine
from ..effects import Form, Scales, forms_for
from .experiment import METRICS, Experiment

# Left out: effects of the log (sensors) and drift over minutes, of which no table speaks, and torque
# ripple, whose period would be picked among many by 27 numbers.
CANDIDATES = (
    "actuator.delay",
    "actuator.lag",
    "actuator.saturation",
    "actuator.torque_constant",
    "friction.coulomb",
    "friction.load_dependent",
    "friction.presliding",
    "friction.stribeck",
    "friction.viscous",
    "inertia.payload",
    "load.bias",
    "transmission.backlash",
    "transmission.compliance",
)
SAMPLE_TIME = 1e-3  # [s], Table 5-3


def candidate_forms(
    machine: DriveMachine, experiment: Experiment, effects: Sequence[str] = CANDIDATES
) -> list[Form]:
    """Plain forms of the effects; richer ones have more parameters than the table can carry."""
    forms = forms_for(machine, scales(experiment))
    return [form for form in forms if form.effect in effects and not form.refined]


def scales(experiment: Experiment) -> Scales:
    """Typical sizes from the motion programs and the printed torques."""
    time = np.arange(0.0, 1.0 / experiment.rate, SAMPLE_TIME)
    samples = [
        motion.c_drive_motion(name, experiment.rate).sample(time) for name in C_DRIVE_MOTIONS
    ]
    position = np.concatenate([psi for psi, _, _ in samples])
    rate = np.concatenate([psi_rate for _, psi_rate, _ in samples])
    peaks = [
        row.thesis_exp
        for row in thesis_tables.maximum_rows()
        if row.metric == thesis_tables.TAU_MAX and row.thesis_exp is not None
    ]
    return Scales(
        effort=float(np.mean(experiment.measured[:, METRICS.index(thesis_tables.TAU_RMS)])),
        effort_peak=max(peaks),
        rate=float(np.sqrt(np.mean(rate**2))),
        rate_peak=float(np.max(np.abs(rate))),
        travel=float(np.ptp(position)),
        lsb=LSB,
        dt=SAMPLE_TIME,
        duration=1.0 / experiment.rate,
    )
