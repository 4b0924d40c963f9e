"""One case of a blind run: the machine, its excitation, its noise and the answer."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .c_drive import Machine
from .slider import Slider

AnyMachine = Machine | Slider

NONE, SINGLE, DOUBLE, OFF = "none", "single", "double", "off_library"


@dataclass(frozen=True, kw_only=True)
class Case:
    """One case with its answer; everything that is drawn for it."""

    seed: int
    index: int
    kind: str  # NONE, SINGLE, DOUBLE or OFF
    answer: tuple[str, ...]  # effect ids, ("unknown",) off the library, () for none
    cause: tuple[str, ...]  # ids, or the names of off-library effects
    nominal: AnyMachine  # with nuisance, without the effect
    machine: AnyMachine  # with the effect
    partial: Mapping[str, AnyMachine]  # for pairs: the machine without this one
    parameters: Mapping[str, Any] = field(default_factory=dict)  # cause -> drawn parameters
    speed: float = 1.0  # factor on the thesis' rates
    soft: bool = False  # controllers of lower gain, as the log set states
    encoder_noise: float = 0.0  # rad or m, standard deviation before the counter
    torque_noise: float = 0.002  # Nm, standard deviation in the log
    noise_seed: int = 0

    @property
    def name(self) -> str:
        """Folder and log-set name; it says nothing of the answer."""
        return case_name(self.index)


def case_name(index: int) -> str:
    """Folder and log-set name of a case."""
    return f"case_{index:04d}"
