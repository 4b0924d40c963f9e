"""Chapter 7: how well a step model predicts runs it was not calibrated on, against simpler ones.

Models compared, each from the same calibration runs:

- ``likelihood``, ``routine``: the empirical model by either estimator of chapter 6;
- ``constant``: the unloaded step of that direction, as in Figs. 7.1 and 7.2;
- ``none``: the coarse step of the manual (chapter 2), 4e-4 rad and 1 um, without any measurement.

With the empirical truth the model compared is the truth's own, so its error is that of calibration and
scatter alone; the physical truth shares no law with it and shows what its form cannot follow.

The thesis prints errors of 15 % (joint 3) and 2 % (joint 2) for its model and, for the constant step, 10 % and 1.3 %
"in the worst-case configurations". The latter cannot be: by its own parameters (Figs. 4.13, 5.6) a
constant step is off by 123 % for joint 3 pointing up and by 15 to 30 % for joint 2 with the arm extended.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...models.mm3a.arm import Arm
from ...models.mm3a.step_size import (
    STROKE,
    PrismaticStep,
    RotaryStep,
    StepModel,
    constant_steps,
)
from . import experiments, likelihood, routine
from .calibration import field_of
from .experiments import Environment, StepTruth
from .runs import Run, mean_of_inverse

MANUAL_STEP = (STROKE[0], STROKE[1], 1e-6)  # chapter 2: full piezo stroke, 1 um [rad, rad, m]
COMPARED = ((2, -1), (2, 1), (3, -1), (3, 1))  # joints and directions of Figs. 7.1 and 7.2
THESIS = {2: (0.02, 0.013), 3: (0.15, 0.10)}  # printed worst errors: model, constant step


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """Relative errors, predicted over measured less 1, on the validation runs of one joint and direction."""

    joint: int
    direction: int
    runs: Sequence[Run]
    errors: dict[str, NDArray[np.float64]]  # by model, (runs,)

    def rms(self, model: str) -> float:
        """Root mean square relative error."""
        return float(np.sqrt(np.mean(np.square(self.errors[model]))))

    def worst(self, model: str) -> float:
        """Largest magnitude of the relative error."""
        return float(np.abs(self.errors[model]).max())


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Models calibrated on one day and their errors on the other runs of that day."""

    models: dict[str, StepModel]
    predictions: Sequence[Prediction]


def validation_plan() -> list[Run]:
    """Configurations of Figs. 6.2, 6.6, 6.7: none is a calibration run of chapter 6."""
    return [
        *experiments.posture_plan(0.0),
        *experiments.posture_plan(-np.pi / 3),
        *experiments.interval_plan(0.0),
        *experiments.interval_plan(0.012),
        *experiments.interval_plan(0.0, -np.pi / 4),
    ]


def compare(
    truth: StepTruth, *, environment: Environment | None = None, seed: int = 0
) -> Comparison:
    """Calibrate on the plan of chapter 6, three repeats, and predict the validation runs of the same day.

    One random day for all runs: seeds are the generator's, and equal seeds give equal days.
    """
    calibration = experiments.calibration_plan()
    measured = experiments.perform(
        [*calibration, *validation_plan()], truth, repeats=3, environment=environment, seed=seed
    )
    per_repeat = len(measured) // 3
    fit = [run for i, run in enumerate(measured) if i % per_repeat < len(calibration)]
    held_out = [run for i, run in enumerate(measured) if i % per_repeat >= len(calibration)]
    models = calibrated_models(fit)
    return Comparison(
        models=models,
        predictions=[_predict(models, held_out, *key) for key in COMPARED],
    )


def calibrated_models(runs: Sequence[Run]) -> dict[str, StepModel]:
    """The four models of this comparison from calibration runs of all joints."""
    keys = [(joint, direction) for joint in (1, 2, 3) for direction in (-1, 1)]
    by_likelihood = StepModel(
        **{field_of(*key): likelihood.estimate(runs, *key).step() for key in keys}  # type: ignore[arg-type]
    )
    by_routine = StepModel(
        **{field_of(*key): routine.calibrate_by_routine(runs, *key, "exact") for key in keys}  # type: ignore[arg-type]
    )
    return {
        "likelihood": by_likelihood,
        "routine": by_routine,
        "constant": constant_steps(by_routine),
        "none": manual_steps(),
    }


def manual_steps() -> StepModel:
    """Steps of the manual in both directions, without load or recoil."""
    steps: dict[str, PrismaticStep | RotaryStep] = {}
    for joint, size in enumerate(MANUAL_STEP, start=1):
        for direction in (-1, 1):
            steps[field_of(joint, direction)] = (
                PrismaticStep(basic=size, recoil=0.0, load=0.0)
                if joint == 3
                else RotaryStep(
                    basic_retracted=size,
                    basic_extended=size,
                    load_retracted=0.0,
                    load_extended=0.0,
                )
            )
    return StepModel(**steps)  # type: ignore[arg-type]


def _predict(
    models: dict[str, StepModel], runs: Sequence[Run], joint: int, direction: int
) -> Prediction:
    chosen = [run for run in runs if (run.joint, run.direction) == (joint, direction)]
    errors = {}
    for name, model in models.items():
        sizes = experiments.empirical_truth(model, Arm())
        errors[name] = np.array(
            [mean_of_inverse(sizes(run)) / run.mean_step - 1.0 for run in chosen]
        )
    return Prediction(joint=joint, direction=direction, runs=chosen, errors=errors)
