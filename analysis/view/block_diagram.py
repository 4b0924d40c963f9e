"""Block diagrams of Drake diagrams as SVG, without a program beside Python.

Drake describes a diagram in Graphviz's language; the wheel of ``pygraphviz`` holds the layout engine itself.
"""

import re
import warnings
from typing import Any

from ..errors import InputError


def svg(diagram: Any, *, depth: int = 1) -> str:
    """A diagram as standalone SVG, ``depth`` levels of subsystems shown.

    InputError if the optional extra is not installed, ValueError for a negative depth.
    """
    if depth < 0:
        raise ValueError(f"depth is {depth}; expected 0 or more")
    try:
        import pygraphviz
    except ImportError:
        raise InputError(
            "block diagram",
            "pygraphviz is not installed",
            "the extra `view`",
            "pip install 'gapscope[view]'",
        ) from None
    graph = pygraphviz.AGraph(string=_plain(diagram.GetGraphvizString(max_depth=depth)))
    graph.graph_attr.update(fontname="sans-serif", nodesep="0.3", ranksep="0.7")
    graph.node_attr.update(fontname="sans-serif", fontsize="12")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # Graphviz's remarks on fonts
        drawn = graph.draw(prog="dot", format="svg").decode()
    graph.close()
    title = diagram.get_name() or "diagram"
    label = (
        f'role="img" aria-label="Block diagram of {title}" style="max-width: 100%; height: auto" '
    )
    return drawn.replace("<svg ", f"<svg {label}", 1)


def _plain(text: str) -> str:
    """Drake's description with bare names: no memory addresses, no modules of classes."""
    text = re.sub(r"@[0-9a-f]{16}", "", text)
    text = re.sub(r"<B>(?:\w+\.)+(\w+)</B>", r"<B>\1</B>", text)
    return re.sub(r"^name=", "", text, flags=re.MULTILINE)
