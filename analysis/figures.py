"""Figures for reports: inline SVG whose text and axes take the page's colour, light or dark."""

import io
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import matplotlib

matplotlib.use("Agg", force=False)
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

# Okabe and Ito's colour-blind-safe palette, without black and yellow, which vanish on a dark or light page.
BLUE, ORANGE, GREEN, VERMILION, SKY, PURPLE = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#D55E00",
    "#56B4E9",
    "#CC79A7",
)
_INK = "#010203"  # replaced by currentColor
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.size": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.2,
    "grid.color": _INK,
    "text.color": _INK,
    "axes.edgecolor": _INK,
    "axes.labelcolor": _INK,
    "axes.titlesize": 10.0,
    "xtick.color": _INK,
    "ytick.color": _INK,
    "axes.facecolor": "none",
    "figure.facecolor": "none",
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "figure.constrained_layout.use": True,
}


def style() -> AbstractContextManager[None]:
    """Context in which the project's figures are drawn."""
    return plt.rc_context(_STYLE)


def inline_svg(draw: Callable[[], Figure], *, name: str, description: str) -> str:
    """An ``<svg>`` element of the figure; ``name`` keeps its ids apart from other figures of the page."""
    with plt.rc_context({**_STYLE, "svg.hashsalt": name}):
        figure = draw()
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
        plt.close(figure)
    svg = buffer.getvalue()
    svg = svg[svg.index("<svg") :].replace(_INK, "currentColor")
    svg = (
        svg.replace('id="', f'id="{name}-')
        .replace('"#', f'"#{name}-')
        .replace("url(#", f"url(#{name}-")
    )
    return svg.replace("<svg ", f'<svg role="img" aria-label="{description}" ', 1)


def ink() -> Any:
    """The colour that becomes the page's text colour."""
    return _INK
