"""What can be wrong with the signals of a log, as corrections that give what the controller saw."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .machine import Array, Machine, RunData

TURN = 180.0 / np.pi  # readings in degrees that are said to be radians
UNITS = 1.0, TURN, 1.0 / TURN, 1e3, 1e-3  # by which a signal may be off when its unit is another
EXACT = 0.01  # relative error of a factor that is taken for one of them
OTHER_UNIT = "positions and reference in another unit"
LARGEST_SHIFT = 8.0  # samples


@dataclass(frozen=True, kw_only=True)
class Fault:
    """One fault, with ``n`` parameters in units of ``scale``, and how a run with it is corrected."""

    effect: str
    form: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    scale: Array
    starts: tuple[Array, ...]  # of a search, in units of the scale
    bound: float  # of the parameters' size, in units of the scale
    in_model: bool  # whether the machine's prediction changes with it, and must become better
    corrected: Callable[[RunData, Array], RunData]  # the run at the parameters in their units

    def correct(self, run: RunData, x: Array) -> RunData:
        """The run as the controller saw it, at the parameters ``x`` in units of ``scale``."""
        return self.corrected(run, self.scale * x)

    def is_unit(self, x: Array) -> bool:
        """Whether the parameters are the factor between two units, by which no scale is off by chance."""
        factor = 1.0 + float(self.scale[0] * x[0])
        return any(abs(factor / unit - 1.0) < EXACT for unit in UNITS if unit != 1.0)


def log_faults(machine: Machine, runs: Sequence[RunData], lsb: float) -> list[Fault]:
    """Faults of the positions, the reference and the command; ``lsb`` is the encoder's step [position unit].

    Searches for an offset start from none and from the mean distance of the runs from their references: a replay that
    an offset saturates has no slope.
    """
    dt, scale = runs[0].dt, 10.0 * lsb
    away = np.mean([np.mean((r.position - r.reference)[r.window], axis=0) for r in runs], axis=0)
    n, joints = len(machine.joints), machine.joints
    shifts = tuple(np.array([s]) for s in (-3.0, -1.0, 1.0, 3.0))

    def timing(
        form: str, name: str, corrected: Callable[[RunData, Array], RunData], in_model: bool = False
    ) -> Fault:
        return Fault(
            effect="sensor.timing", form=form, names=(name,), units=("s",), scale=np.array([dt]),
            starts=shifts, bound=LARGEST_SHIFT, in_model=in_model, corrected=corrected,
        )  # fmt: skip

    def gain(
        form: str,
        names: tuple[str, ...],
        corrected: Callable[[RunData, Array], RunData],
        in_model: bool,
    ) -> Fault:
        factors = (*UNITS, -1.0)  # or with the other sign
        starts = tuple(np.full(len(names), 1e3 * (factor - 1.0)) for factor in factors)
        return Fault(
            effect="sensor.scale", form=form, names=names, units=("-",) * len(names),
            scale=np.full(len(names), 1e-3), starts=starts, bound=np.inf,
            in_model=in_model, corrected=corrected,
        )  # fmt: skip

    return [
        timing("positions late", "late", _position_earlier),
        timing("reference early", "late", _reference_later),
        timing("command early", "early", _command_later, in_model=True),
        Fault(
            effect="sensor.offset", form="offset in the log",
            names=tuple(f"offset_{s}" for s in joints), units=(machine.position_unit,) * n,
            scale=np.full(n, scale), starts=(np.zeros(n), away / scale), bound=np.inf,
            in_model=False, corrected=_without_offset,
        ),
        gain("scale in the log", tuple(f"scale_error_{s}" for s in joints), _without_scale, False),
        gain("scale of the command in the log", ("scale_error",), _command_without_scale, True),
        gain(OTHER_UNIT, ("scale_error",), _in_its_unit, True),
    ]  # fmt: skip


def _position_earlier(run: RunData, value: Array) -> RunData:
    moved = advanced(run.position, value[0], run.t)
    return replace(run, position=moved, shifted=value[0] / run.dt)


def _reference_later(run: RunData, value: Array) -> RunData:
    return replace(
        run,
        reference=advanced(run.reference, -value[0], run.t),
        reference_rate=advanced(run.reference_rate, -value[0], run.t),
        reference_acceleration=advanced(run.reference_acceleration, -value[0], run.t),
    )


def _command_later(run: RunData, value: Array) -> RunData:
    return replace(run, command=advanced(run.command, -value[0], run.t))


def _without_offset(run: RunData, value: Array) -> RunData:
    return replace(run, position=np.ascontiguousarray(run.position - value))


def _without_scale(run: RunData, value: Array) -> RunData:
    position = np.ascontiguousarray(run.position / (1.0 + value))
    return replace(run, position=position, lsb=run.lsb / float(np.mean(np.abs(1.0 + value))))


def _in_its_unit(run: RunData, value: Array) -> RunData:
    names = "reference", "reference_rate", "reference_acceleration"
    wanted = {name: getattr(run, name) / (1.0 + value[0]) for name in names}
    return replace(_without_scale(run, value), **wanted)


def _command_without_scale(run: RunData, value: Array) -> RunData:
    return replace(run, command=run.command / (1.0 + value[0]))


def advanced(signal: Array, shift: float, t: Array) -> Array:
    """The signal ``shift`` seconds earlier, by linear interpolation; its ends are held."""
    moved = [np.interp(t + shift, t, column) for column in signal.T]
    return np.ascontiguousarray(np.column_stack(moved))
