"""Predictions side by side are those one by one."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from gapscope.analysis.gap import batches
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine

# Forms that share no compiled size with each other, or that a kernel treats as a case of its own.
NAMES = [
    "smoothed sign",
    "Dahl",
    "dead zone",
    "two inertias",
    "delay",
    "period",
    "encoder",
    "order",
]
EXACT = 1e-9  # of the largest residual; impacts amplify the last bits


@pytest.fixture(scope="module")
def machine_and_runs(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    short = [
        replace(
            run,
            **{
                name: getattr(run, name)[:300]
                for name in ("t", "reference", "reference_rate", "reference_acceleration",
                             "position", "command")
            },
        )
        for run in runs
    ]  # fmt: skip
    return machine, short


def random_plants(machine, form, random, count):
    """Plants with a form at values near where a search of it starts."""
    for _ in range(count):
        values = {
            (form.effect, p.name): random.choice(p.starts) + 0.1 * p.scale * random.random()
            for p in form.parameters
        }
        yield Hypothesis(forms=(form,)).plant(machine, values)


@pytest.mark.parametrize("words", NAMES)
def test_blocks_are_predicted_as_single_runs_are(words, machine_and_runs):
    machine, runs = machine_and_runs
    form = next(f for f in machine.forms(runs) if words in f.name)
    plants = list(random_plants(machine, form, np.random.default_rng(5), 7))
    tasks = [(run, plant) for plant in plants for run in runs[:3]]
    with ThreadPoolExecutor(1) as pool:
        found = batches.predict_all(machine, tasks, pool.submit)
    for residual, task in zip(found, tasks, strict=True):
        alone = machine.predict(*task)
        np.testing.assert_allclose(residual, alone, rtol=0.0, atol=EXACT * np.abs(alone).max())


def test_only_tasks_of_one_structure_and_length_share_a_block(machine_and_runs, monkeypatch):
    machine, runs = machine_and_runs
    sizes = []
    block = batches._predict_block
    monkeypatch.setattr(
        batches, "_predict_block", lambda m, tasks: sizes.append(len(tasks)) or block(m, tasks)
    )
    plant = Hypothesis().plant(machine, {})
    finer = plant._replace(substeps=2)
    shorter = replace(runs[0], position=runs[0].position[:200], command=runs[0].command[:200])
    tasks = [(runs[0], plant)] * 20 + [(runs[0], finer)] * 5 + [(shorter, plant)] * 3
    with ThreadPoolExecutor(1) as pool:
        found = batches.predict_all(machine, tasks, pool.submit)
    assert sizes == [16, 4, 5]
    assert [len(r) for r in found] == [300] * 25 + [200] * 3
