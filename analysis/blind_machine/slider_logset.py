"""Runs a slider case; tables and description in the layout of the EMPS log set, with repeats."""

from typing import Any

import numpy as np

from . import slider
from .case import Case
from .motion import FINE_TIME, SAMPLE_TIME, Array, out_and_back

CYCLES = 3
PAUSE = 60.0  # s
RUNS = (  # stroke [m], rate [Hz], use; half-cycles of the 4-5-6-7 polynomial, out and back
    (0.20, 0.25, "fit"),
    (0.20, 0.50, "fit"),
    (0.08, 0.80, "fit"),
    (0.15, 0.40, "validate"),
    (0.10, 0.625, "validate"),
)
COLUMNS = {
    "t": "s",
    "q_ref": "m",
    "q": "m",
    "u": "V, drive command",
    "force": f"N = {slider.FORCE_PER_VOLT:.5f}*u",
}
SIGNALS, COMMANDS = slice(2, 4), slice(3, 4)  # of a table: compared ones, volts
RUNAWAY = 9.5  # drive command after the first cycle [V]; the drive clips at 10 V
FORMATS = ["%.4f", "%.8f", "%.8f", "%.6f", "%.4f"]


def start_times() -> list[float]:
    """Running time of the machine before each run [s]."""
    lengths = [CYCLES / rate + PAUSE for _, rate, _ in RUNS]
    return [round(sum(lengths[:number]), 3) for number in range(len(RUNS))]


def simulate(case: Case, machine: slider.Slider, *, events: bool = True) -> list[Array]:
    """The logged tables of ``machine``, (n, 5) each; a slider has no ``events``."""
    tables = []
    for number, ((stroke, rate, _), start) in enumerate(zip(RUNS, start_times())):
        t, share, _ = out_and_back(rate, CYCLES)
        rng = np.random.default_rng([case.noise_seed, number])
        noise = case.encoder_noise * rng.standard_normal(len(t))
        readings, commands, fine = slider.run(machine, stroke * share, noise, start)
        q, u = _log(machine, readings, commands, fine, noise)
        tables.append(np.column_stack([t, stroke * share, q, u, slider.FORCE_PER_VOLT * u]))
    return tables


def _log(
    m: slider.Slider, readings: Array, commands: Array, fine: Array, noise: Array
) -> tuple[Array, Array]:
    if m.log_clock != 0.0:
        stamps = SAMPLE_TIME * np.arange(len(readings)) - m.log_clock
        true = np.interp(stamps, FINE_TIME * np.arange(len(fine)), fine)
        readings = np.round((m.scale * true + m.offset + noise) / m.lsb) * m.lsb
    readings = m.log_scale * readings + m.log_offset
    if m.log_late:
        late = m.log_late
        readings = np.concatenate([np.repeat(readings[:1], late), readings[:-late]])
        commands = np.concatenate([np.repeat(commands[:1], late), commands[:-late]])
    return readings, commands


def description(case: Case) -> dict[str, Any]:
    """The content of ``logset.yaml``."""
    m = slider.Slider()
    return {
        "format": 1,
        "name": case.name,
        "source": "blind machine, independent of the toolbox",
        "system": {
            "kind": "slider",
            "description": "motor + ball screw + carriage, position on the load side",
            "nominal": {"mass_kg": m.mass, "viscous_N_s_per_m": m.viscous},
        },
        "controller": {
            "kind": "cascade_p_p",
            "law": "u = kv*(kp*(q_ref-q) - dqf); dqf=(qf[k]-qf[k-1])/dt; qf=0.5*(q[k]+q[k-1])",
            "kp_per_s": slider.KP,
            "kv_V_per_m_per_s": slider.KV,
            "saturation_V": slider.SATURATION,
            "force_per_volt_N": slider.FORCE_PER_VOLT,
            "encoder_lsb_m": slider.ENCODER_LSB,
        },
        "sample_time_s": SAMPLE_TIME,
        "columns": COLUMNS,
        "runs": [
            {"file": f"run{i}.csv", "use": use, "rate_Hz": rate, "start_s": start}
            for i, ((_, rate, use), start) in enumerate(zip(RUNS, start_times()), 1)
        ],
    }
