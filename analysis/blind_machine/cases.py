"""Cases of a blind run: which effects, which nuisance, which excitation, decided by the seed alone.

Cases come in decks of 40: ten with no effect, every library mechanism once, six pairs and five
off-library effects, shuffled. Case ``i`` of a seed is the same however many are made.
"""

from typing import Any

import numpy as np

from . import logset, slider_effects
from .c_drive import Machine
from .case import DOUBLE, NONE, OFF, SINGLE, AnyMachine, Case
from .drive_effects import EFFECTS
from .off_library import OFF_LIBRARY
from .slider import Slider

PAIRS, OFFS, NONES = 6, 5, 10
SPEEDS = (0.8, 1.0, 1.0, 1.25, 1.25)  # on the thesis' rates: cycles stay whole milliseconds
ATTEMPTS = 20
SLIDERS = 0.2  # share of the cases a slider can show
DECK = NONES + len(EFFECTS) + PAIRS + OFFS
# Two effects of one group would hide each other or are the same law twice.
GROUPS = (
    {"friction.coulomb", "friction.stribeck", "friction.presliding", "friction.thermal_drift"},
    {"friction.viscous", "friction.thermal_drift"},
    {"transmission.backlash", "transmission.compliance"},
    {"actuator.delay", "actuator.lag", "sensor.timing"},
    {"actuator.torque_constant", "sensor.scale", "inertia.payload"},
    {"load.bias", "sensor.offset"},
)


def draw(seed: int, index: int) -> Case:
    """Case ``index`` of ``seed``.

    A pair with which the machine always runs away, such as a soft transmission behind a slow torque loop, gives
    way to another one.
    """
    deck, card = divmod(index, DECK)
    shuffled = _deck(np.random.default_rng([seed, deck, 0]))
    kind, causes = shuffled[card]
    others = np.random.default_rng([seed, index, 2])
    for _ in range(ATTEMPTS):
        case = _steady_case(seed, index, kind, causes)
        if case is not None:
            return case
        if kind != DOUBLE:
            break
        causes = _pair(others)
    raise RuntimeError(f"seed {seed}, case {index}: {2 * ATTEMPTS} draws of {causes} all ran away")


def _steady_case(seed: int, index: int, kind: str, causes: tuple[str, ...]) -> Case | None:
    """The first draw with which the machine runs, or None."""
    stream = np.random.SeedSequence(seed, spawn_key=(index,))  # child ``index`` of the seed
    slides = _slides(seed, index, kind, causes)
    for number, attempt in enumerate(stream.spawn(2 * ATTEMPTS)):
        # A slider that runs away at every draw, clipped below what its friction asks for, gives way.
        slider = slides and number < ATTEMPTS
        case = _draw(seed, index, kind, causes, slider, np.random.default_rng(attempt))
        if steady(case):
            return case
    return None


def steady(case: Case) -> bool:
    """Whether the machine runs: one that runs away is switched off, not diagnosed."""
    layout = logset.layout(case)
    tables = logset.simulate(case, case.machine)
    commands = [table[len(table) // 3 :, layout.COMMANDS] for table in tables]
    return bool(max(np.abs(command).max() for command in commands) < layout.RUNAWAY)


def _slides(seed: int, index: int, kind: str, causes: tuple[str, ...]) -> bool:
    """Whether the case is a slider's: a share of those that a slider can show."""
    shown = kind != OFF and set(causes) <= set(slider_effects.EFFECTS)
    return bool(shown and np.random.default_rng([seed, index, 1]).random() < SLIDERS)


def _draw(
    seed: int,
    index: int,
    kind: str,
    causes: tuple[str, ...],
    slides: bool,
    rng: np.random.Generator,
) -> Case:
    stated = Slider() if slides else Machine()
    nominal = nuisance(rng, stated)
    machine, parameters, partial = _apply(causes, nominal, rng)
    speed = float(rng.choice(SPEEDS))
    return Case(
        seed=seed,
        index=index,
        kind=kind,
        answer=("unknown",) if kind == OFF else causes,
        cause=causes,
        nominal=nominal,
        machine=machine,
        partial=partial,
        parameters=parameters,
        speed=1.0 if "actuator.saturation" in causes else speed,
        soft=bool(rng.random() < 0.4),
        encoder_noise=_noise(stated, float(rng.choice((0.0, 0.2, 0.5)))),
        torque_noise=float(rng.choice((0.001, 0.002, 0.004))),
        noise_seed=int(rng.integers(2**63)),
    )


def _noise(stated: AnyMachine, level: float) -> float:
    """Encoder noise: ``level`` counts; a slider counts so finely that vibration is never less."""
    return (0.1 + level) * 1e-6 if isinstance(stated, Slider) else level * stated.lsb


def nuisance(
    rng: np.random.Generator, stated: AnyMachine, spread: float | None = None
) -> AnyMachine:
    """The stated machine with every physical parameter off by up to ``spread`` (1 to 3 %)."""
    spread = float(rng.uniform(0.01, 0.03)) if spread is None else spread
    mass, second, rotor, left, right, gamma = (1 + rng.uniform(-spread, spread, 6)).tolist()
    if isinstance(stated, Slider):
        return stated._replace(mass=stated.mass * mass, viscous=stated.viscous * second)
    return stated._replace(
        mass=stated.mass * mass,
        turning_inertia=stated.turning_inertia * second,
        rotor_inertia=stated.rotor_inertia * rotor,
        beta=(stated.beta[0] * left, stated.beta[1] * right),
        gamma=stated.gamma * gamma,
    )


def _apply(
    causes: tuple[str, ...], nominal: AnyMachine, rng: np.random.Generator
) -> tuple[AnyMachine, dict[str, Any], dict[str, AnyMachine]]:
    """The machine with all causes, their parameters, and for pairs the machine without each."""
    seeds = rng.integers(2**63, size=2)
    slides = isinstance(nominal, Slider)
    table: dict[str, Any] = slider_effects.EFFECTS if slides else {**EFFECTS, **OFF_LIBRARY}

    def build(wanted: tuple[str, ...]) -> tuple[AnyMachine, dict[str, Any]]:
        machine: AnyMachine = nominal
        parameters: dict[str, Any] = {}
        for cause, seed in zip(causes, seeds):
            if cause in wanted:
                machine, parameters[cause] = table[cause](np.random.default_rng(seed), machine)
        return machine, parameters

    machine, parameters = build(causes)
    partial = {c: build(tuple(o for o in causes if o != c))[0] for c in causes[:2]}
    return machine, parameters, partial if len(causes) == 2 else {}


def _deck(rng: np.random.Generator) -> list[tuple[str, tuple[str, ...]]]:
    cards: list[tuple[str, tuple[str, ...]]] = [(NONE, ())] * NONES
    cards += [(SINGLE, (name,)) for name in EFFECTS]
    cards += [(DOUBLE, _pair(rng)) for _ in range(PAIRS)]
    off = rng.permutation(list(OFF_LIBRARY))[:OFFS]
    cards += [(OFF, (str(name),)) for name in off]
    return [cards[i] for i in rng.permutation(len(cards))]


def _pair(rng: np.random.Generator) -> tuple[str, ...]:
    while True:
        pair = tuple(sorted(str(name) for name in rng.choice(list(EFFECTS), 2, replace=False)))
        if not any(set(pair) <= group for group in GROUPS):
            return pair
