"""Many parameter sets of one drive at once: the loops of ``drive_kernels``, each instruction for several sets.

A block of ``lanes.LANES`` sets goes through ``drive_kernels.simulate``'s own loop as if it were one drive; chunks of blocks
go to threads. Only what is asked for is kept of a block, so that memory grows with neither sets nor samples beyond it.

All sets have the same friction elements, couplings and shafts, and in the same places: dry bristles, clearances, lags
and whole samples of delay are in all sets or in none (``require_alike``).
"""

import os
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import compilation, drive, drive_kernels, drive_stack, stack
from .drive import Drive
from .drive_kernels import LoopController
from .lanes import LANES, in_lanes

Floats = NDArray[np.float64]
BLOCKS = 16  # that a thread takes at once


class Tracking(NamedTuple):
    """What is kept of each set's closed loop: arrays (sets, n)."""

    error_rms: Floats  # of reference less reading [position unit]
    error_peak: Floats  # largest magnitude [position unit]
    command_rms: Floats  # [unit of the command]
    command_peak: Floats  # largest magnitude [unit of the command]


def repeated(plant: Drive, sets: int) -> Drive:
    """``sets`` copies of a drive as one whose arrays have a first axis of sets; ``elements`` is shared."""
    copies = Drive(*(np.repeat(np.asarray(field)[None], sets, axis=0) for field in plant))
    return copies._replace(elements=np.array(plant.elements))


def stacked(plants: Sequence[Drive]) -> Drive:
    """Drives of equal sizes side by side, as ``repeated`` has copies.

    Raises ValueError if their friction elements belong to other shafts, and without any drive.
    """
    if not plants:
        raise ValueError("there is no drive; expected at least one")
    fields = {name: np.stack([getattr(p, name) for p in plants]) for name in Drive._fields}
    if not np.all(fields["elements"] == fields["elements"][0]):
        raise ValueError("the drives differ in `elements`; expected the same friction elements")
    return Drive(**{**fields, "elements": fields["elements"][0]})


def require_alike(plants: Drive, dt: float) -> None:
    """Raise ValueError, naming the constant, where the sets do not have in common what they must."""
    for name, values in _common(plants, dt).items():
        if not np.all(values == values[:1]):
            raise ValueError(f"parameter sets differ in: {name}; expected the same in all sets")


def likeness(plant: Drive, dt: float) -> Hashable:
    """Equal for drives that can be sets of one batch."""
    shared = plant.elements.shape, plant.elements.tobytes()
    return shared, *(values.tobytes() for values in _common(repeated(plant, 1), dt).values())


def _common(plants: Drive, dt: float) -> dict[str, Any]:
    """What the sets must have in common, arrays (sets, ...) by name."""
    element, shaft, coupling = plants.element, plants.shaft, plants.coupling
    return {
        "presliding stiffness, zero or not": element[:, :, drive.STIFFNESS] != 0.0,
        "whole samples of delay": np.floor(shaft[:, :, drive.DELAY] / dt),
        "lag, zero or not": shaft[:, :, drive.LAG] != 0.0,
        "stages of the lag": shaft[:, :, drive.STAGES],
        "shafts of a coupling": coupling[:, :, : drive.COUPLING_STIFFNESS],
        "clearance of a coupling, zero or not": coupling[:, :, drive.GAP] != 0.0,
    }


def simulate(
    reference: Floats,
    reference_acceleration: Floats,
    plants: Drive,
    controller: LoopController,
    dt: float,
    substeps: int,
    lsb: float,
    start: Floats,
    threads: int | None = None,
    first_sensed: int = 0,
) -> Tracking:
    """Closed loops from rest at ``start`` (n,): ``drive_kernels.simulate`` of each set of ``plants``.

    ``plants`` has arrays (sets, ...) as ``stacked`` makes them, the other arguments are those of one loop.
    ``threads`` are as many as there are cores by default. Raises ValueError as ``require_alike`` does.
    """
    require_alike(plants, dt)
    sizes, sensors = _sizes(plants), stack.axis(reference.shape[1])
    memory, before = drive_kernels.initial_memory(controller, start), stack.axis(first_sensed)

    def chunk(blocks: Drive) -> Floats:
        kept = np.empty((len(blocks.shaft), len(Tracking._fields), len(sensors), LANES))
        _simulate(
            reference, reference_acceleration, blocks, sizes, sensors, controller, dt, substeps, lsb,
            memory, start, kept, before,
        )  # fmt: skip
        return kept.transpose(0, 3, 1, 2).reshape(-1, *kept.shape[1:3])

    kept = np.concatenate(_on_threads(chunk, _chunks(plants), threads))[: len(plants.shaft)]
    return Tracking(*kept.transpose(1, 0, 2))


def predict(
    position: Floats,
    command: Floats,
    plants: Drive,
    dt: float,
    substeps: int,
    bandwidth: float,
    threads: int | None = None,
    first_sensed: int = 0,
) -> Floats:
    """``drive_kernels.predict`` of each set of ``plants``: errors (sets, samples, n).

    ``position`` and ``command`` are (samples, n) for all sets, or (sets, samples, n).
    """
    require_alike(plants, dt)
    sizes, sensors = _sizes(plants), stack.axis(position.shape[-1])
    before, sets = stack.axis(first_sensed), len(plants.shaft)
    shape = (sets, *position.shape[-2:])
    position, command = np.broadcast_to(position, shape), np.broadcast_to(command, shape)

    def chunk(part: tuple[int, Drive]) -> Floats:
        first, blocks = part
        chosen = slice(first, first + len(blocks.shaft) * LANES)
        seen, driven = (np.ascontiguousarray(a[chosen], float) for a in (position, command))
        residual = np.empty_like(seen)
        _predict(seen, driven, blocks, sizes, sensors, dt, substeps, bandwidth, residual, before)
        return residual

    starts = range(0, sets, BLOCKS * LANES)
    return np.concatenate(_on_threads(chunk, zip(starts, _chunks(plants)), threads))


def _sizes(plants: Drive) -> drive_stack.Sizes:
    return drive_stack.sizes(plants._replace(coupling=plants.coupling[0]))


def _on_threads(
    work: Callable[[Any], Floats], chunks: Iterable[Any], threads: int | None
) -> list[Floats]:
    if threads == 1:
        return [work(chunk) for chunk in chunks]
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        return list(pool.map(work, chunks))


def _chunks(plants: Drive) -> Iterator[Drive]:
    """Chunks of blocks: arrays (blocks, ..., LANES). The last set fills the last block."""
    size, sets = BLOCKS * LANES, len(plants.shaft)
    for first in range(0, sets, size):
        last = min(first + size, sets)
        chosen = np.minimum(np.arange(first, first - (first - last) // LANES * LANES), sets - 1)
        yield Drive(
            _blocks(plants.inertia_inverse, chosen),
            plants.elements,
            _blocks(plants.element, chosen),
            _blocks(plants.shaft, chosen),
            _blocks(plants.coupling, chosen),
        )


def _blocks(values: Floats, chosen: Any) -> Floats:
    blocks = values[chosen].reshape(len(chosen) // LANES, LANES, *values.shape[1:])
    return np.ascontiguousarray(np.moveaxis(blocks, 1, -1))


@compilation.inlined
def _block(plants: Drive, b: int) -> Drive:
    """Block ``b``, in lanes."""
    return Drive(
        in_lanes(plants.inertia_inverse[b]),
        plants.elements,
        in_lanes(plants.element[b]),
        in_lanes(plants.shaft[b]),
        in_lanes(plants.coupling[b]),
    )


@compilation.kernel
def _simulate(
    reference: Any,
    reference_acceleration: Any,
    plants: Drive,
    sizes: drive_stack.Sizes,
    sensors: stack.Axis,
    controller: LoopController,
    dt: float,
    substeps: int,
    lsb: float,
    memory: Any,
    start: Any,
    kept: Any,
    before: stack.Axis,
) -> None:
    samples, n = reference.shape
    position: Any = in_lanes(np.zeros((samples, n, LANES)))
    command = in_lanes(np.zeros((samples, n, LANES)))
    delivered = in_lanes(np.zeros((samples, n, LANES)))
    for b in range(kept.shape[0]):
        for j in range(n):
            position[0, j] = start[j]
        drive_kernels.closed_loop(
            reference, reference_acceleration, _block(plants, b), sizes, sensors, controller, dt,
            substeps, lsb, memory, position, command, delivered, before,
        )  # fmt: skip
        _summarise(reference, position, command, in_lanes(kept[b]))


@compilation.part
def _summarise(reference: Any, position: Any, command: Any, kept: Any) -> None:
    """Write the rows of ``Tracking``."""
    samples, n = reference.shape
    for j in range(n):
        for i in range(4):
            kept[i, j] = 0.0
        for k in range(samples):
            error, effort = reference[k, j] - position[k, j], command[k, j]
            kept[0, j] += error * error
            kept[1, j] = max(kept[1, j], np.abs(error))
            kept[2, j] += effort * effort
            kept[3, j] = max(kept[3, j], np.abs(effort))
        kept[0, j] = np.sqrt(kept[0, j] / samples)
        kept[2, j] = np.sqrt(kept[2, j] / samples)


@compilation.kernel
def _predict(
    position: Any,
    command: Any,
    plants: Drive,
    sizes: drive_stack.Sizes,
    sensors: stack.Axis,
    dt: float,
    substeps: int,
    bandwidth: float,
    residual: Any,
    before: stack.Axis,
) -> None:
    sets, samples, n = residual.shape
    seen, driven = np.empty((samples, n, LANES)), np.empty((samples, n, LANES))
    error = np.empty((samples, n, LANES))
    for b in range(len(plants.shaft)):
        for lane in range(LANES):
            _copy_run(position[min(b * LANES + lane, sets - 1)], seen[:, :, lane])
            _copy_run(command[min(b * LANES + lane, sets - 1)], driven[:, :, lane])
        drive_kernels.prediction(
            in_lanes(seen), in_lanes(driven), _block(plants, b), sizes, sensors, dt, substeps,
            bandwidth, in_lanes(error), before,
        )  # fmt: skip
        for lane in range(min(LANES, sets - b * LANES)):
            _copy_run(error[:, :, lane], residual[b * LANES + lane])


@compilation.inlined
def _copy_run(source: Any, target: Any) -> None:
    for k in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[k, j] = source[k, j]
