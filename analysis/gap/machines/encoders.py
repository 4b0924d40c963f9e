"""What a log set states of its encoders."""

import re

from ....models.encoder import resolution
from ...errors import InputError
from ..checks import finite_number, shown
from ..description import FILE
from ..logset import LogSet

MOST_BITS = 64  # of the finest encoder per turn
LARGEST_STEP = 1.0  # [m]
BITS = re.compile(r"(-?[\w.]*)[- ]bit encoder")


def stated_encoder_step(logset: LogSet) -> float | None:
    """Encoder step that the log set states [position unit]: in bits per turn, or as a length.

    Raises InputError for a step that no encoder has; a length of 0 states none.
    """
    where = logset.folder / FILE
    for column, text in logset.remarks.items():
        found = BITS.search(text)
        if found:
            return resolution(whole_bits(f"{where}, columns.{column}", found[1]))
    for name, settings in logset.controllers.items():
        if "encoder_lsb_m" in settings:
            key = f"{where}, controllers.{name}.encoder_lsb_m"
            step = finite_number(key, settings["encoder_lsb_m"], least=0.0)
            if step >= LARGEST_STEP:
                raise InputError(key, f"{step:g}", f"less than {LARGEST_STEP:g} m")
            return step or None
    return None


def whole_bits(where: str, text: str) -> int:
    """Bits of an encoder per turn."""
    bits = int(text) if text.isascii() and text.isdigit() and len(text) < 4 else 0
    if not 1 <= bits <= MOST_BITS:
        raise InputError(
            where, f"an encoder of {shown(text)} bits", f"a whole number from 1 to {MOST_BITS}"
        )
    return bits
