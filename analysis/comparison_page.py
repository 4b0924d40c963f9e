"""``comparison.json``, ``comparison.md`` and ``comparison.html`` of a controller comparison."""

import json
from importlib.resources import files as package_files
from pathlib import Path

import jinja2

from ..models import thesis_tables
from . import comparison_figures
from .comparison import ComparedRow, Comparison
from .figures import inline_svg
from .files import output_folder, write_whole

RMS = (thesis_tables.TAU_RMS, thesis_tables.E_U_RMS, thesis_tables.E_THETA_RMS)
ENDPOINTS = (thesis_tables.E_U_END, thesis_tables.E_THETA_END)
MAXIMA = (thesis_tables.TAU_MAX, thesis_tables.E_U_MAX, thesis_tables.E_THETA_MAX)
TABLES = (
    ("rms-2", "RMS, 2 Hz (Table 5-4)", RMS, 2.0, ""),
    (
        "ends-2",
        "Mean error at cycle endpoints, 2 Hz (Table 5-7)",
        ENDPOINTS,
        2.0,
        "A few encoder counts (0.0037 mm, 0.0004 rad); the instant of an endpoint and the sign of u are "
        "not printed. Ours is signed, at the sample where a cycle starts. Not reproduced.",
    ),
    (
        "max-2",
        "Mean of the maxima over each cycle, 2 Hz (Table 5-8)",
        MAXIMA,
        2.0,
        "The printed table contradicts Table 5-4: PD's rotation errors have maxima below their own RMS, and "
        "in pure rotation all three controllers share one translation error of 0.1972 mm whose RMS is "
        "0.0000. Shown for completeness; nothing is fitted to it.",
    ),
    (
        "rms-1",
        "RMS, 1 Hz (Table 5-9, experiment only)",
        RMS,
        1.0,
        "",
    ),
)
HEADER = (
    "motion",
    "controller",
    "metric",
    "ours",
    "sampled",
    "thesis sim",
    "thesis exp",
    "ours/sim",
)


def write_comparison(comparison: Comparison, folder: Path) -> list[Path]:
    """Write the three files into ``folder`` (made if missing), each whole or not at all."""
    folder = output_folder(folder)
    contents = {
        "comparison.json": json.dumps(comparison.as_json(), indent=2) + "\n",
        "comparison.md": markdown(comparison),
        "comparison.html": page(comparison),
    }
    for name, content in contents.items():
        write_whole(folder / name, content)
    return [folder / name for name in contents]


def markdown(comparison: Comparison) -> str:
    """All tables as Markdown."""
    lines = ["# C-drive: controllers beside the printed results", "", _summary(comparison)]
    for _, title, metrics, rate, note in TABLES:
        lines += ["", f"## {title}", ""] + ([note, ""] if note else [])
        lines += ["| " + " | ".join(HEADER) + " |", "|" + "---|" * len(HEADER)]
        lines += [
            "| " + " | ".join(cells(row)) + " |"
            for row in comparison.select(metrics=metrics, rate_Hz=rate)
        ]
    return "\n".join(lines) + "\n"


def page(comparison: Comparison) -> str:
    """The self-contained HTML page with its figures."""
    rows = comparison.select(metrics=RMS, rate_Hz=2.0)
    figures = (
        (
            "reproduction",
            "How close do our simulations come to the printed one?",
            lambda: comparison_figures.reproduction(rows),
        ),
        ("programs", "Motion programs, 2 Hz (Fig. 5-1 a–d)", comparison_figures.motion_programs),
        (
            "helical",
            "Which controller errs least in helical motion? (Fig. 5-1 e–f; simulated)",
            lambda: comparison_figures.helical_errors(rows),
        ),
        (
            "tests",
            "Torques and errors of the three tests of Fig. 5-2",
            lambda: comparison_figures.selected_tests(rows),
        ),
    )
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined)
    source = package_files("gapscope.analysis").joinpath("templates/comparison.html").read_text()
    return environment.from_string(source).render(
        summary=_summary(comparison),
        figures=[
            (title, inline_svg(draw, name=name, description=title)) for name, title, draw in figures
        ],
        header=HEADER,
        tables=[
            (name, title, note, [cells(row) for row in comparison.select(metrics=m, rate_Hz=rate)])
            for name, title, m, rate, note in TABLES
        ],
        provenance=json.dumps(comparison.provenance, indent=2),
    )


def cells(row: ComparedRow) -> list[str]:
    """One table row as text, in the order of ``HEADER``."""
    return [
        row.motion,
        row.controller.upper(),
        row.metric,
        _four(row.ours),
        _four(row.ours_sampled),
        _four(row.thesis_sim),
        _four(row.thesis_exp),
        "–" if row.relative_error is None else f"{100.0 * row.relative_error:+.1f} %",
    ]


def _four(value: float | None) -> str:
    return "–" if value is None else f"{round(value, 4) + 0.0:.4f}"


def _summary(comparison: Comparison) -> str:
    rows = [row for row in comparison.select(metrics=RMS, rate_Hz=2.0) if row.relative_error]
    others = [row for row in rows if not row.within_print]
    worst = max(others, key=_deviation)
    return (
        f"Of the {len(rows)} non-zero RMS values the thesis prints of its simulation, ours equals "
        f"{len(rows) - len(others)} to the last printed digit; the largest deviation of the others is "
        f"{100.0 * _deviation(worst):.1f} % ({worst.controller.upper()}, {worst.motion}, "
        f"{worst.metric}). Ours: controllers as continuous blocks under ODE4 at 1 ms, 5 % taken off M and "
        "D in the controller's model, and a dead zone of one encoder count on the error, which "
        "the thesis does not mention (see gapscope compare ct-errors). "
        "Sampled: the torque held over 1 ms, 5 % added to M and D, no dead zone."
    )


def _deviation(row: ComparedRow) -> float:
    return abs(row.relative_error or 0.0)
