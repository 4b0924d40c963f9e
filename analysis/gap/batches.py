"""Predictions of a drive side by side: runs and parameter sets of one structure share instructions."""

from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Future
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models import drive_batch
from ...models.lanes import LANES
from .machine import Array, RunData

if TYPE_CHECKING:
    from .drive_machine import DriveMachine, FinishedPlant

WORTH = 4  # predictions of one structure that take longer one by one than as one block
WORTH_ALONE = 9  # as WORTH, where one of two cores has nothing else to do


def predict_all(
    machine: "DriveMachine",
    tasks: "Sequence[tuple[RunData, FinishedPlant]]",
    submit: Callable[..., Future[Any]],
) -> list[Array]:
    """Prediction errors of every task, in its order: in blocks where enough tasks are alike."""
    groups: dict[Hashable, list[int]] = {}
    likeness: dict[int, Hashable] = {}
    for i, (run, plant) in enumerate(tasks):
        if id(plant) not in likeness:
            likeness[id(plant)] = _structure(plant, run.dt)
        groups.setdefault((likeness[id(plant)], run.dt, run.position.shape), []).append(i)
    worth = WORTH if len(tasks) > LANES else WORTH_ALONE
    pending: list[tuple[Sequence[int], Future[Any]]] = []
    for group in groups.values():
        blocks = [group[i : i + LANES] for i in range(0, len(group), LANES)]
        for block in blocks:
            chosen = [tasks[i] for i in block]
            if len(block) >= worth:
                pending.append((block, submit(_predict_block, machine, chosen)))
            else:
                pending += [([i], submit(_predict_one, machine, tasks[i])) for i in block]
    residuals: list[Array] = [np.zeros(0)] * len(tasks)
    for places, future in pending:
        for i, residual in zip(places, future.result(), strict=True):
            residuals[i] = residual
    return residuals


def _structure(plant: "FinishedPlant", dt: float) -> Hashable:
    """Equal for plants that can be predicted in one block."""
    return plant.substeps, plant.first_sensed, drive_batch.likeness(plant.drive, dt)


def _predict_one(machine: "DriveMachine", task: "tuple[RunData, FinishedPlant]") -> list[Array]:
    return [machine.predict(*task)]


def _predict_block(
    machine: "DriveMachine", tasks: "Sequence[tuple[RunData, FinishedPlant]]"
) -> list[Array]:
    """``machine.predict`` of each task, in lanes."""
    run, plant = tasks[0]
    scales = [1.0 if p.sensor_scale is None else p.sensor_scale for _, p in tasks]
    residuals = drive_batch.predict(
        np.stack([r.position / scale for (r, _), scale in zip(tasks, scales)]),
        np.stack([r.command for r, _ in tasks]),
        drive_batch.stacked([p.drive for _, p in tasks]),
        run.dt,
        plant.substeps,
        machine.bandwidth,
        threads=1,
        first_sensed=plant.first_sensed,
    )
    return [(e * scale)[r.window] for e, scale, (r, _) in zip(residuals, scales, tasks)]
