"""The experiment that would tell most next."""

from collections.abc import Mapping
from typing import Any

from .base import Material, Section
from .words import listed, number


def context(material: Material) -> dict[str, Any]:
    """A sentence for a run worth repeating; whatever else the diagnosis says, as a list."""
    planned = dict(material.diagnosis.next_experiment)
    repeat = planned.pop("repeat", None)
    sentence = ""
    if isinstance(repeat, Mapping):
        separates = planned.pop("separates", [])
        difference, unit = planned.pop("prediction_difference", None), planned.pop("unit", "")
        rest = ", ".join(f"{key} {value}" for key, value in repeat.items() if key != "run")
        pair = listed([_label(ids) for ids in separates])
        sentence = f"Repeat the motion of {repeat.get('run')}" + (f" ({rest})." if rest else ".")
        if pair and difference is not None:
            sentence += (
                f" Of all logged motions the two best hypotheses, {pair}, differ most on this one: by "
                f"{number(float(difference), str(unit))} rms in what they predict."
            )
    return {
        "sentence": sentence,
        "others": [(str(key).replace("_", " "), _text(value)) for key, value in planned.items()],
    }


def _label(ids: Any) -> str:
    return " + ".join(ids) if ids else "the retuned nominal model"


def _text(value: Any) -> str:
    if isinstance(value, float):
        return number(value)
    if isinstance(value, Mapping):
        return "; ".join(f"{key} {_text(v)}" for key, v in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(_text(v) for v in value)
    return str(value)


SECTION = Section(key="next_experiment", title="Next experiment", context=context)
