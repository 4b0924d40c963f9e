"""``gapscope bandwidth mast``: table, figure and JSON, our simulation beside what is printed."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from ...models.belt_axis import MANUFACTURER
from ..files import write_folder
from .mast_bandwidth import MOTIONS, PRINTED, PRINTED_BANDWIDTH, Response
from .mast_study import Study
from .mast_variants import FRICTION_BOUND, Variant, printed_bandwidth


def document(study: Study) -> dict[str, Any]:
    """``bandwidth.json``: responses, printed numbers, and what does not agree."""
    return {
        "source": "Roldan, section 4.2.4, Figs. 4.20-4.26",
        "assumed": {
            **asdict(study.gains),
            "amplitudes": {name: size for name, (_, size) in MOTIONS.items()},
            "belt_m_per_rev": MANUFACTURER.lead,
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
            "minus_3_dB_Hz_of_gains_and_phases": printed_bandwidth(),
            "resonance_Hz": 900.0,
            "torque_at_0.4_Hz": "manufacturers' values about 70 % off, 0.10 N m",
            "torque_at_10_Hz": "manufacturers' values 0.1 N m too high",
        },
        "resonance_Hz": {"load_on_held_motor": study.resonances[0], "free": study.resonances[1]},
        "torques": [{**asdict(t), "relative": t.relative} for t in study.torques],
        "variants": [_variant(v) for v in study.variants],
        "inertia_spread": study.inertia_spread,
        "remarks": remarks(study),
    }


def _variant(v: Variant) -> dict[str, Any]:
    gain, phase = v.loaded.misfit
    return {
        "name": v.name,
        "minus_3_dB_Hz": _number(v.loaded.bandwidth),
        "minus_3_dB_Hz_axes_alone": _number(v.alone.bandwidth),
        "gain_at_5_Hz": _at_5_hz(v.loaded),
        "largest_gain_error": gain,
        "largest_phase_error_deg": phase,
    }


def remarks(study: Study) -> list[str]:
    """What the numbers say, in sentences."""
    loaded = next(r for r in study.responses if r.motion == "z" and r.load == "with the table")
    alone = next(r for r in study.responses if r.load == "axes alone")
    slow, *_, fast = study.torques
    gain, phase = loaded.misfit
    shifts = [v.shift for v in study.variants if v.name != FRICTION_BOUND and _same_axes(v)]
    return [
        f"Gains and phases at 0.4, 5 and 10 Hz: within {100 * gain:.1f} % of the command and {phase:.1f}° of the printed "
        "ones with the gains stated.",
        f"-3 dB in z at {alone.bandwidth:.2f} Hz for the axes alone (printed: about 4 Hz) and {loaded.bandwidth:.2f} Hz with "
        "the table (printed: 3.5 Hz).",
        f"The printed gains and phases, measured with the table, have -3 dB at {printed_bandwidth():.2f} Hz between them: they "
        "fit the printed 4 Hz and exclude the printed 3.5 Hz.",
        "The table's inertia, reflected through belt and 15:1, is a few per cent of what the motors turn, and more inertia "
        f"makes such a loop resonate: over the variants it moves -3 dB by {min(shifts):+.2f} to {max(shifts):+.2f} Hz, "
        "never by the printed -0.5 Hz.",
        *_by_friction(study),
        f"Torque at {slow.frequency:g} Hz: the manufacturers' values give {100 * slow.relative:+.0f} % "
        f"({2 * (slow.manufacturer - slow.identified):+.3f} N m from peak to peak); printed: about 70 % off, 0.10 N m: Coulomb "
        "friction is larger than stated.",
        f"Torque at {fast.frequency:g} Hz: {fast.manufacturer - fast.identified:+.3f} N m in amplitude with the "
        "manufacturers' values; printed 0.1 N m too high: J_1 is smaller than stated.",
        f"The table's inertia was held at the home posture; over the motions it changes by "
        f"{100 * study.inertia_spread:.2g} % of what the motors turn.",
    ]


def _same_axes(v: Variant) -> bool:
    return "axes alone" not in v.name


def _by_friction(study: Study) -> list[str]:
    """The one assumption that has both printed bandwidths, if it was simulated."""
    found = [v for v in study.variants if v.name == FRICTION_BOUND]
    return [
        f"Friction could: a speed loop without integral action (printed for the 3-PRS's drives) has {v.loaded.bandwidth:.2f} Hz "
        f"with identified friction and {v.alone.bandwidth:.2f} Hz for axes with the manufacturers' friction, as printed; but it "
        f"misses the printed gains by up to {100 * v.loaded.misfit[0]:.0f} % of the command and the phases by up to "
        f"{v.loaded.misfit[1]:.0f}°. No variant has all eight numbers."
        for v in found
    ]


def variant_table(study: Study) -> Table:
    """What each assumption does to z, for the terminal."""
    out = Table(title="z motion: one assumption changed at a time")
    for heading in ("assumption", "-3 dB [Hz]", "alone [Hz]", "5 Hz", "largest misfit"):
        out.add_column(heading)
    for v in study.variants:
        gain, phase = v.loaded.misfit
        out.add_row(
            v.name,
            f"{v.loaded.bandwidth:.2f}",
            f"{v.alone.bandwidth:.2f}",
            f"{100 * _at_5_hz(v.loaded):.1f} %",
            f"{100 * gain:.1f} %, {phase:.1f}°",
        )
    out.add_row("printed", "3.5", "4", "65.4 %", "")
    return out


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
