"""Runs a C-drive case; tables and description in the layout of the open sets, without the answer."""

from typing import Any

import numpy as np

from . import c_drive, controllers
from .case import Case
from .motion import AMPLITUDE, FINE_TIME, SAMPLE_TIME, Array, out_and_back

CYCLES = 3
RUNS = (  # controller, motion, thesis rate [Hz], use
    ("pd", "translation", 1.0, "fit"),
    ("pd", "rotation", 2.0, "fit"),
    ("pd", "helical", 2.0, "fit"),
    ("ct", "helical", 1.0, "fit"),
    ("pd", "translation", 2.0, "validate"),
    ("ts", "helical", 2.0, "validate"),
)
PAUSE = 60.0  # s of running between two logged runs
STIFF = {  # Table 5-1
    "pd": controllers.Controller(controllers.PD, (45.0, 45.0), (0.1, 0.1), 600.0),
    "ct": controllers.Controller(controllers.COMPUTED_TORQUE, (35e3, 35e3), (55.0, 55.0), 600.0),
    "ts": controllers.Controller(controllers.TASK_SPACE, (45.0, 112.5), (0.1, 0.25), 600.0),
}
SOFT = {  # bears twice the delay and lets a gap move the positions twice as far
    "pd": controllers.Controller(controllers.PD, (20.0, 20.0), (0.1, 0.1), 600.0),
    "ct": controllers.Controller(controllers.COMPUTED_TORQUE, (15e3, 15e3), (55.0, 55.0), 600.0),
    "ts": controllers.Controller(controllers.TASK_SPACE, (20.0, 50.0), (0.1, 0.25), 600.0),
}
COLUMNS = {
    "t": "s",
    "psi_L_ref": "rad",
    "psi_R_ref": "rad",
    "psi_L": "rad, 13-bit encoder",
    "psi_R": "rad, 13-bit encoder",
    "tau_L": "Nm, commanded",
    "tau_R": "Nm, commanded",
}
SIGNALS, COMMANDS = slice(3, 7), slice(5, 7)  # of a table: compared ones, torques
RUNAWAY = 12.0  # commanded torque after the first cycle [Nm]; 2.9 Nm is the thesis' largest
FORMATS = ["%.3f"] + ["%.6f"] * 4 + ["%.4f"] * 2


def simulate(case: Case, machine: c_drive.Machine, *, events: bool = True) -> list[Array]:
    """The six logged tables of ``machine`` under the case's excitation and noise, (n, 7) each.

    ``events`` allows the knocks and lost commands that belong to the case's effect.
    """
    tables = []
    starts = start_times(case)
    gains = SOFT if case.soft else STIFF
    for number, (controller, motion, rate, _) in enumerate(RUNS):
        t, stroke, curvature = out_and_back(case.speed * rate, CYCLES)
        amplitude = np.array(AMPLITUDE[motion])
        # One stream per purpose: a change of one noise level leaves every other draw in place.
        encoder, torque, chance = np.random.SeedSequence([case.noise_seed, number]).spawn(3)
        noise = np.random.default_rng(encoder).standard_normal((len(t), 2))
        program = c_drive.Program(
            reference=stroke[:, None] * amplitude,
            acceleration=curvature[:, None] * amplitude,
            encoder_noise=case.encoder_noise * noise,
            start=starts[number],
            **_events(case, len(t), np.random.default_rng(chance), events),
        )
        readings, commands, fine = c_drive.run(machine, gains[controller], program)
        commands = commands + case.torque_noise * np.random.default_rng(torque).standard_normal(
            commands.shape
        )
        logged = _log(machine, readings, commands, fine, program.encoder_noise)
        tables.append(np.column_stack([t, program.reference, *logged]))
    return tables


def start_times(case: Case) -> list[float]:
    """Running time of the machine before each run [s]; between runs it keeps moving, unlogged."""
    lengths = [CYCLES / (case.speed * rate) + PAUSE for _, _, rate, _ in RUNS]
    return [round(sum(lengths[:number]), 3) for number in range(len(RUNS))]


def _events(case: Case, n: int, rng: np.random.Generator, allowed: bool) -> dict[str, Array]:
    """Lost commands and knocks, if this case has them."""
    dropped, kicks = np.zeros(n), np.zeros(n)
    if allowed and "lost commands" in case.parameters:
        lost = case.parameters["lost commands"]
        starts = rng.random(n) < lost["share"] / lost["burst"]
        for shift in range(lost["burst"]):
            dropped[shift:] = np.maximum(dropped[shift:], starts[: n - shift])
    if allowed and "impacts" in case.parameters:
        knock = case.parameters["impacts"]
        hit = rng.random(n) < knock["per_second"] * SAMPLE_TIME
        kicks = hit * rng.choice((-1.0, 1.0), n) * knock["impulse_N_s"] / SAMPLE_TIME
    return {"dropped": dropped, "kicks": kicks}


def _log(
    machine: c_drive.Machine, readings: Array, commands: Array, fine: Array, noise: Array
) -> tuple[Array, Array]:
    """Positions and torques as they reach the file: clock, gain and zero of the log."""
    if machine.log_clock != 0.0:
        stamps = SAMPLE_TIME * np.arange(len(readings)) - machine.log_clock
        grid = FINE_TIME * np.arange(len(fine))
        for i in range(2):
            angle = machine.scale[i] * np.interp(stamps, grid, fine[:, i]) + machine.offset[i]
            readings[:, i] = np.round((angle + noise[:, i]) / machine.lsb) * machine.lsb
    readings = readings * np.array(machine.log_scale) + np.array(machine.log_offset)
    late = machine.log_late
    if late:
        readings = np.concatenate([np.repeat(readings[:1], late, axis=0), readings[:-late]])
        commands = np.concatenate([np.repeat(commands[:1], late, axis=0), commands[:-late]])
    return readings, commands


def description(case: Case) -> dict[str, Any]:
    """The content of ``logset.yaml``."""
    m = c_drive.Machine()
    pd, ct, ts = (SOFT if case.soft else STIFF).values()
    runs = [
        {
            "file": f"run{number}.csv",
            "controller": controller,
            "motion": motion,
            "rate_Hz": rate * case.speed,
            "use": use,
            "start_s": start,
        }
        for number, ((controller, motion, rate, use), start) in enumerate(
            zip(RUNS, start_times(case)), 1
        )
    ]
    return {
        "format": 1,
        "name": case.name,
        "source": "blind machine, independent of the toolbox",
        "system": {
            "kind": "c_drive",
            "nominal": {
                "beta_N_m_s": m.beta[0],
                "gamma_N_m_s": m.gamma,
                "note": "inertia and geometry as in the thesis",
            },
        },
        "controllers": {
            "pd": {
                "kind": "pd",
                "kp_Nm_per_rad": pd.kp[0],
                "kd_Nms_per_rad": pd.kd[0],
                "derivative_filter_rad_per_s": pd.cutoff,
            },
            "ct": {
                "kind": "computed_torque",
                "kp_per_s2": ct.kp[0],
                "kd_per_s": ct.kd[0],
                "derivative_filter_rad_per_s": ct.cutoff,
                "observer_pole_rad_per_s": ct.pole,
                "friction_compensation": ct.compensation,
            },
            "ts": {
                "kind": "task_space_pd",
                "kp_trans_Nm_per_rad": ts.kp[0],
                "kp_rot_Nm_per_rad": ts.kp[1],
                "kd_trans_Nms_per_rad": ts.kd[0],
                "kd_rot_Nms_per_rad": ts.kd[1],
                "derivative_filter_rad_per_s": ts.cutoff,
            },
        },
        "sample_time_s": SAMPLE_TIME,
        "columns": COLUMNS,
        "runs": runs,
    }
