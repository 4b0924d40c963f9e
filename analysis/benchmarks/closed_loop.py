"""Group ``closed-loop``: the C-drive's helical program under PD, one run of 0.5 s.

PD every 1 ms with zero-order hold and 13-bit encoders, dry friction by tanh, one ODE4 step a sample. Each
contender writes what the encoders read and what the controller commands, (samples, 2) each.
gapscope's diagram of blocks computes the reference while it runs; the others get it as samples.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import FunctionType, ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...diagrams.c_drive_config import PD, CDriveLoopConfig, Machine
from ...diagrams.c_drive_loop import actuated_drive
from ...models import drive_kernels, encoder
from ...models.c_drive_controllers import loop_controller
from . import drake_peers, jaxonomy_peer, other_peers
from .c_loop import NoCompilerError, c_loop
from .peer_laws import Constants
from .rounds import Contender, Group, Skipped, measure, rows

NAME = "closed-loop"
SAMPLES = 500
# The same laws in other orders of sums, relative to each signal's largest value; a count of an
# encoder is 7.7e-4 rad and would show as 1e-5.
TOLERANCE = 1e-11
OURS, DRAKE, BLOCKS, PYTHON, C = (
    "gapscope compiled",
    "gapscope Drake diagram",
    "gapscope Drake diagram of blocks",
    "plain Python",
    "C -O3 -march=native",
)

PEERS = {
    "Drake, plain Python leaves": drake_peers.python_leaves,
    "Drake C++ primitives": drake_peers.primitives,
    "MuJoCo, friction in Python": other_peers.mujoco,
    "python-control": other_peers.python_control,
    "PathSim": other_peers.pathsim,
    "bdsim": other_peers.bdsim,
    "jaxonomy": jaxonomy_peer.jaxonomy,
}

Signals = tuple[NDArray[np.float64], NDArray[np.float64]]


def task() -> CDriveLoopConfig:
    """The loop that all contenders run, with dry friction at motors and collar."""
    return CDriveLoopConfig(motion="helical", rate=2.0, machine=Machine(delta=0.12, eta=0.05))


def closed_loop(rounds: int, samples: int = SAMPLES) -> Group:
    """Time all contenders on ``samples`` samples over ``rounds`` interleaved rounds."""
    config = task()
    contenders, skipped = _contenders(config, samples)
    reference = C if C in [contender.name for contender in contenders] else OURS
    # Whole counts hide small differences, so that the loops are compared with an exact encoder, too.
    exact, _ = _contenders(replace(config, encoder_bits=0), samples)
    checks = agreement([contenders, exact], reference)
    seconds, repeats = measure(contenders, rounds)
    return Group(
        name=NAME,
        task=f"C-drive, helical 2 Hz, PD at 1 ms, encoder, tanh friction, ODE4, {samples} samples",
        rounds=rounds,
        reference=reference,
        agreement=f"position and command within {TOLERANCE:g} of their largest value, with 13-bit and "
        f"with exact encoders, to {reference}",
        rows=rows(contenders, seconds, repeats, checks, reference),
        skipped=tuple(skipped),
    )


def difference(signals: Signals, reference: Signals) -> float:
    """Largest difference of two results, each signal relative to its largest reference value."""
    return max(float(np.max(np.abs(a - b)) / np.max(np.abs(b))) for a, b in zip(signals, reference))


def agreement(variants: Sequence[Sequence[Contender]], reference: str) -> list[tuple[str, bool]]:
    """In words, and whether it is within tolerance: the worst of all variants for each contender."""
    worst = [0.0] * len(variants[0])
    for contenders in variants:
        results = {contender.name: contender.run() for contender in contenders}
        for j, signals in enumerate(results.values()):
            worst[j] = max(worst[j], difference(signals, results[reference]))
    return [(f"differs by {found:.1e}", found <= TOLERANCE) for found in worst]


def _contenders(config: CDriveLoopConfig, samples: int) -> tuple[list[Contender], list[Skipped]]:
    loop = drive_kernels.simulate
    found = [
        Contender(name=OURS, run=_sampled(loop, config, samples)),
        Contender(name=DRAKE, run=_drake(_encoded(config, samples), config, samples)),
        Contender(name=BLOCKS, run=_drake(_blocks(config), config, samples)),
        Contender(
            name=PYTHON, run=_sampled(interpreted(drive_kernels, "simulate"), config, samples)
        ),
    ]
    skipped = []
    reference = config.program().sample(config.sample_time * np.arange(samples))[0]
    constants = c_constants(config)
    for name, peer in PEERS.items():
        try:
            run = peer(Constants(*constants.tolist()), reference)
        except ImportError as error:
            skipped.append(Skipped(name=name, reason=f"{error}; pip install 'gapscope[bench]'"))
        else:
            found.append(Contender(name=name, run=run))
    try:
        found.append(Contender(name=C, run=c_loop(reference, constants)))
    except NoCompilerError as error:
        skipped.append(Skipped(name=C, reason=str(error)))
    return found, skipped


def c_constants(config: CDriveLoopConfig) -> NDArray[np.float64]:
    """Constants (12,) in the order of the struct in ``c_drive_loop.c``, SI units."""
    machine, pd = config.machine, config.controller
    if not isinstance(pd, PD):
        raise TypeError(f"the controller is {type(pd).__name__}; expected PD")
    return np.array(
        [
            *(machine.m11, machine.m12, machine.beta, machine.gamma),
            *(machine.delta, machine.eta, machine.sign_width),
            *(pd.kp, pd.kd, pd.cutoff, config.sample_time, _lsb(config)),
        ]
    )


def interpreted(module: ModuleType, name: str) -> Callable[..., Any]:
    """The kernel ``name`` of ``module`` as plain Python, with every function that it calls there."""
    space = dict(vars(module))
    for key, value in vars(module).items():
        plain = getattr(value, "py_func", value)
        if isinstance(plain, FunctionType) and plain.__module__ == module.__name__:
            space[key] = FunctionType(plain.__code__, space, key, plain.__defaults__)
        elif isinstance(plain, FunctionType):  # from another module, whose own calls are of laws
            space[key] = plain
    return space[name]


def _sampled(loop: Callable[..., Any], config: CDriveLoopConfig, samples: int) -> Any:
    """One run of ``drive_kernels.simulate``, compiled or not."""
    dt = config.sample_time
    reference, _, acceleration = config.program().sample(dt * np.arange(samples))
    controller = loop_controller(config.controller.settings(), config.believed(), dt)
    plant, lsb = actuated_drive(config), _lsb(config)

    def run() -> Signals:
        position, command, delivered = (np.zeros((samples, 2)) for _ in range(3))
        memory = drive_kernels.initial_memory(controller, position[0])
        loop(
            reference, acceleration, plant, controller, dt, 1, lsb,
            memory, position, command, delivered,
        )  # fmt: skip
        return position, command

    return run


def _encoded(config: CDriveLoopConfig, samples: int) -> Any:
    from ...diagrams.c_drive_sampled_loop import c_drive_sampled_loop

    return c_drive_sampled_loop(config, config.sample_time * samples)


def _blocks(config: CDriveLoopConfig) -> Any:
    from ...diagrams.c_drive_loop import c_drive_loop

    return c_drive_loop(config)


def _drake(diagram: Any, config: CDriveLoopConfig, samples: int) -> Callable[[], Signals]:
    """One simulation of the loop's Diagram with two logs; building the Diagram is not in it."""
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    loop = builder.AddSystem(diagram)
    ports = [loop.GetOutputPort(name) for name in ("measured", "command")]
    return drake_peers.logged(builder, ports, config.sample_time, samples)


def _lsb(config: CDriveLoopConfig) -> float:
    return encoder.resolution(config.encoder_bits) if config.encoder_bits else 0.0
