"""``gapscope bandwidth mast``: table, figure and JSON, our simulation beside what is printed."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from ..files import write_folder
from .mast_bandwidth import MOTIONS, PRINTED, PRINTED_BANDWIDTH, Response, Study


def document(study: Study) -> dict[str, Any]:
    """``bandwidth.json``: responses, printed numbers, and what does not agree."""
    return {
        "source": "Roldan, section 4.2.4, Figs. 4.20-4.26",
        "assumed": {
            **asdict(study.gains),
            "amplitudes": {name: size for name, (_, size) in MOTIONS.items()},
            "belt_m_per_rev": 0.1,
        },
        "responses": [
            {
                "motion": r.motion,
                "load": r.load,
                "frequency_Hz": r.frequencies.tolist(),
                "gain": r.gain.tolist(),
                "phase_deg": r.phase.tolist(),
                "minus_3_dB_Hz": _number(r.bandwidth),
                "minus_45_deg_Hz": _number(r.phase_bandwidth),
            }
            for r in study.responses
        ],
        "printed": {
            "gain_and_phase_deg": {f"{f:g} Hz": list(v) for f, v in PRINTED.items()},
            "bandwidth_Hz": PRINTED_BANDWIDTH,
            "resonance_Hz": 900.0,
            "torque_at_0.4_Hz": "manufacturers' values about 70 % off, 0.10 N m",
            "torque_at_10_Hz": "manufacturers' values 0.1 N m too high",
        },
        "resonance_Hz": {"load_on_held_motor": study.resonances[0], "free": study.resonances[1]},
        "torques": [{**asdict(t), "relative": t.relative} for t in study.torques],
        "z_by_gain": [
            {
                "position_gain": k,
                "minus_3_dB_Hz": _number(r.bandwidth),
                "gain_at_5_Hz": _at_5_hz(r),
            }
            for k, r in study.by_gain.items()
        ],
        "inertia_spread": study.inertia_spread,
        "remarks": remarks(study),
    }


def remarks(study: Study) -> list[str]:
    """What the numbers say, in sentences."""
    loaded = next(r for r in study.responses if r.motion == "z" and r.load == "with the table")
    alone = next(r for r in study.responses if r.load == "axes alone")
    slow, *_, fast = study.torques
    return [
        f"-3 dB in z at {loaded.bandwidth:.2f} Hz with the table and {alone.bandwidth:.2f} Hz without; printed are "
        f"3.5 and 4 Hz. The printed 65.4 % at 5 Hz puts -3 dB above 4 Hz, so 3.5 Hz is not the -3 dB of the same response.",
        "A lower k_v moves -3 dB to the printed bandwidths but away from the printed 65.4 % at 5 Hz: "
        + ", ".join(
            f"{k:g} 1/s gives {r.bandwidth:.2f} Hz and {100 * _at_5_hz(r):.1f} %"
            for k, r in study.by_gain.items()
        )
        + f"; the {study.gains.position_gain:g} 1/s used, {loaded.bandwidth:.2f} Hz and {100 * _at_5_hz(loaded):.1f} %.",
        "The table adds a few per cent to what the motors turn (reflected through the belt and 15:1), and the speed loop "
        f"rejects it: it moves -3 dB by {loaded.bandwidth - alone.bandwidth:+.2f} Hz, not by the printed -0.5 Hz.",
        f"Torque at {slow.frequency:g} Hz: the manufacturers' values give {100 * slow.relative:+.0f} % "
        f"({2 * (slow.manufacturer - slow.identified):+.3f} N m from peak to peak); printed: about 70 % off, 0.10 N m: Coulomb "
        "friction is larger than stated.",
        f"Torque at {fast.frequency:g} Hz: {fast.manufacturer - fast.identified:+.3f} N m in amplitude with the "
        "manufacturers' values; printed 0.1 N m too high: J_1 is smaller than stated.",
        f"The table's inertia was held at the home posture; over the motions it changes by "
        f"{100 * study.inertia_spread:.2g} % of what the motors turn.",
    ]


def table(study: Study) -> Table:
    """Gains and phases at the printed frequencies, for the terminal."""
    out = Table(title="2PRU-1PRS table: closed position loop")
    for heading in ("motion", *(f"{f:g} Hz" for f in PRINTED), "-3 dB [Hz]", "-45° [Hz]"):
        out.add_column(heading)
    for r in study.responses:
        at = [int(np.argmin(np.abs(r.frequencies - f))) for f in PRINTED]
        cells = [f"{100 * r.gain[i]:.1f} %, {r.phase[i]:.1f}°" for i in at]
        name = f"{r.motion}, {r.load}"
        out.add_row(name, *cells, f"{r.bandwidth:.2f}", f"{r.phase_bandwidth:.2f}")
    printed = [f"{100 * g:.1f} %, {p:.1f}°" for g, p in PRINTED.values()]
    out.add_row("printed", *printed, "3.5 / 4 alone", "")
    return out


def write(study: Study, out: Path) -> list[Path]:
    """``bandwidth.json`` and ``bandwidth.png``."""
    text = json.dumps(document(study), indent=1, allow_nan=False)
    return write_folder(
        out,
        {
            "bandwidth.json": lambda path: path.write_text(text, encoding="utf-8"),
            "bandwidth.png": lambda path: plot(study.responses, path),
        },
    )


def plot(responses: list[Response], path: Path) -> None:
    """Gain and phase over frequency with the printed points."""
    from ..figures import BLUE, GREEN, ORANGE, VERMILION, plt, style

    with style():
        figure, (gain, phase) = plt.subplots(2, 1, sharex=True, figsize=(7.5, 6.5))
        colours = (BLUE, ORANGE, GREEN, VERMILION)
        for r, colour, dash in zip(responses, colours, ("-", "--", ":", "-.")):
            label = f"{r.motion}, {r.load}"
            gain.semilogx(r.frequencies, 20.0 * np.log10(r.gain), dash, color=colour, label=label)
            phase.semilogx(r.frequencies, r.phase, dash, color=colour)
        f = list(PRINTED)
        gain.plot(f, [20.0 * np.log10(g) for g, _ in PRINTED.values()], "ko", label="printed")
        phase.plot(f, [p for _, p in PRINTED.values()], "ko")
        gain.axhline(-3.01, color="0.5", linewidth=0.8)
        gain.annotate("-3 dB", (0.42, -2.7), color="0.35", fontsize="small")
        gain.set_ylabel("platform per command [dB]")
        phase.set_ylabel("phase [°]")
        phase.set_xlabel("frequency [Hz]")
        phase.set_xticks([0.4, 1, 2, 4, 10, 20], ["0.4", "1", "2", "4", "10", "20"])
        phase.minorticks_off()
        gain.legend(loc="lower left")
        gain.set_title("Up to which frequency does the table follow?")
        figure.savefig(path, dpi=130)
        plt.close(figure)


def _at_5_hz(response: Response) -> float:
    return float(response.gain[np.argmin(np.abs(response.frequencies - 5.0))])


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
