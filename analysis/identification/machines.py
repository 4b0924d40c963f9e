"""The machines of chapters 4 and 6 as objects of identification.

Limits, rates and filters of 2-PRR and RePlaLink are printed (6.1.4-6.1.5, 6.2.4-6.2.5). Assumed: the upper travel of the
2-PRR is 0.35 m (0.035 m is printed, below its own start of 0.2 m); joint spaces by ``joint_space.margin``; encoders of
500 lines (2-PRR, MAST, 3-PRS) and of 16 bit a turn; noise of forces; friction where none is printed.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import contourpy
import numpy as np
from numpy.typing import NDArray

from ...models.parallel import chains, energy, five_bar, prs, two_prr
from ...models.parallel.chain import Chain
from ...models.parallel.five_bar import FiveBar
from ...models.parallel.joint_space import margin
from ...models.parallel.mast import MAST
from ...models.parallel.prs import Table
from ...models.parallel.replalink import REPLALINK
from ...models.parallel.three_prs import THREE_PRS
from ...models.parallel.two_prr import TwoPRR
from ..errors import InputError
from .machine import Machine
from .polygon import inside

Floats = NDArray[np.float64]

BARS = ("m3", "m4", "m5", "I3", "I4", "I5")
TENSOR = ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")
TURN = 2.0 * np.pi


def machine(name: str) -> Machine:
    """The machine of that name; InputError lists the known ones."""
    if name not in MACHINES:
        raise InputError("machine", f"unknown name {name!r}", f"one of {', '.join(MACHINES)}")
    return MACHINES[name]()


def _two_prr() -> Machine:
    m = TwoPRR()
    columns = [0, 1, 2, 3, 4, 5, 8, 9, 10]

    def rigid(q: Floats, v: Floats, a: Floats) -> Floats:
        return energy.regressor(two_prr.motion(q, v, m), a, m.weight)[..., columns]

    def chain(values: Floats) -> Chain:
        masses, bars = tuple(values[:6].tolist()), values[6:].tolist()
        return chains.two_prr(replace(m, masses=masses, bar_inertias=(bars[0], bars[1], bars[2])))

    return Machine(
        name="2prr",
        title="2-PRR with parallelogram",
        parameters=("m1", "m2", "m3", "m4", "m5", "m6", "I3", "I4", "I5"),
        rigid=rigid,
        prior=np.array([*m.masses, *m.bar_inertias]),
        chain=chain,
        trusted=(*BARS, "m6"),
        lower=np.array([0.002, 0.047]),
        upper=np.array([0.35, 0.35]),
        speed=np.array([0.57, 0.57]),
        acceleration=np.array([5.0, 5.0]),
        start=np.array([0.2, 0.25]),
        frequency=0.4,
        harmonics=10,
        budget=80_000,
        at_rest=False,
        period=0.002,
        cutoff=15.0,
        resolution=0.07 / (14.0 * 2000.0),
        coulomb=np.array([44.6720, 41.8698]),
        viscous=np.array([6.6421, 2.4614]),
        noise=3.0,
        printed={
            "base_parameters": 8,
            "condition": {"gradient": 28.23, "pattern": 20.78},
            "completions": {"of": 21, "usable": 15},
            "source": "Roldan, 6.1",
        },
    )


def _five_bar(m: FiveBar, **more) -> Machine:  # type: ignore[no-untyped-def]
    columns = [0, 1, 2, 3, 4, 7, 8, 9, 10, 12, 13]

    def rigid(q: Floats, v: Floats, a: Floats) -> Floats:
        with np.errstate(invalid="ignore", divide="ignore"):  # NaN where the loop is open
            return energy.regressor(five_bar.motion(q, v, m), a, m.weight)[..., columns]

    def chain(values: Floats) -> Chain:
        x = values.tolist()
        changed = replace(m, masses=tuple(x[:5]), inertias=tuple(x[5:9]), rotors=(x[9], x[10]))
        return chains.five_bar(changed, home=(more["start"][0], more["start"][1]))

    return Machine(
        parameters=("m1", "m2", "m3", "m4", "m5", "I1", "I2", "I3", "I4", "I6", "I7"),
        rigid=rigid,
        prior=np.array([*m.masses, *m.inertias, *m.rotors]),
        chain=chain,
        trusted=("m1", "m2", "m3", "m4", "I1", "I2", "I3", "I4", "I6", "I7"),
        unit="rad",
        polygon=joint_space(m, more["lower"], more["upper"], more["start"]),
        **more,
    )


def _replalink() -> Machine:
    return _five_bar(
        REPLALINK,
        name="replalink",
        title="RePlaLink",
        lower=np.array([0.6981, -0.3142]),
        upper=np.array([3.6652, 2.4435]),
        speed=np.array([2.0, 2.0]),
        acceleration=np.array([30.0, 30.0]),
        start=np.array([2.0944, 1.0472]),
        frequency=0.45,
        harmonics=5,
        period=0.0012,
        cutoff=20.0,
        resolution=TURN / (10.0 * 2**16),
        coulomb=np.array([0.9342, 0.1672]),
        viscous=np.array([2.6334, 4.7132]),
        noise=0.3,
        printed={
            "base_parameters": 9,
            "condition": {"pattern": 62.21},
            "completions": {"of": 210, "usable": 64},
            "source": "Roldan, 6.2",
        },
    )


def _five_r() -> Machine:
    return _five_bar(
        replace(FiveBar(), rotors=(0.05, 0.05)),
        name="5r",
        title="5R",
        lower=np.array([np.deg2rad(40.0), np.deg2rad(-30.0)]),
        upper=np.array([np.deg2rad(210.0), np.deg2rad(140.0)]),
        speed=np.array([3.0, 3.0]),
        acceleration=np.array([30.0, 30.0]),
        start=np.array([1.95, 1.19]),
        frequency=0.5,
        harmonics=5,
        period=0.001,
        cutoff=20.0,
        resolution=TURN / (40.0 * 2**16),
        coulomb=np.array([12.0, 12.0]),
        viscous=np.array([5.0, 5.0]),
        noise=0.3,
    )


def _table(table: Table, build: Callable[[Table], Chain], **more) -> Machine:  # type: ignore[no-untyped-def]
    """Bars alike, carriages alike: four parameters of the legs and platform's mass, and its tensor."""

    def rigid(q: Floats, v: Floats, a: Floats) -> Floats:
        task = prs.forward(q, table)
        k = energy.spatial_regressor(prs.motion(task, v, table), a, table.weight)
        bar, carriage = k[..., :3].sum(-1), k[..., 4:7].sum(-1)
        turning = k[..., [7, 13, 19]].sum(-1)
        legs = np.stack([carriage, k[..., 3], bar, turning], axis=-1)
        return np.concatenate([legs, k[..., 25:31]], axis=-1)

    def chain(values: Floats) -> Chain:
        x = values.tolist()
        return build(
            replace(
                table,
                carriage_mass=x[0],
                platform_mass=x[1],
                bar_mass=x[2],
                bar_inertia=x[3],
                platform_inertia=tuple(x[4:10]),
            )
        )

    legs = (table.carriage_mass, table.platform_mass, table.bar_mass, table.bar_inertia)
    return Machine(
        parameters=("m_carriage", "m_platform", "m_bar", "I_bar", *TENSOR),
        rigid=rigid,
        prior=np.array([*legs, *table.platform_inertia]),
        chain=chain,
        trusted=("m_bar", "I_bar", "m_platform"),
        tensors=((4, 5, 6, 7, 8, 9),),
        start=np.zeros(3),
        harmonics=5,
        **more,
    )


def _mast() -> Machine:
    return _table(
        replace(MAST, carriage_mass=2.27),
        chains.mast,
        name="mast",
        title="2PRU-1PRS table",
        lower=np.full(3, -0.06),
        upper=np.full(3, 0.06),
        speed=np.full(3, 0.5),
        acceleration=np.full(3, 10.0),
        frequency=1.0,
        period=0.001,
        cutoff=40.0,
        resolution=0.07 / (15.0 * 2000.0),
        coulomb=np.array([12.0, 11.0, 13.0]),
        viscous=np.array([6.0, 7.0, 5.0]),
        noise=1.0,
    )


def _three_prs() -> Machine:
    return _table(
        THREE_PRS,
        chains.three_prs,
        name="3prs",
        title="3-PRS table, without the stiffness of its flexures",
        lower=np.full(3, -0.002),
        upper=np.full(3, 0.002),
        speed=np.full(3, 0.1),
        acceleration=np.full(3, 5.0),
        frequency=2.0,
        period=0.0005,
        cutoff=100.0,
        resolution=1e-8,
        coulomb=np.array([0.5, 0.4, 0.6]),
        viscous=np.array([2.0, 2.5, 1.5]),
        noise=0.01,
    )


def joint_space(m: FiveBar, lower: Floats, upper: Floats, around: Floats) -> Floats:
    """Polygon (vertices, 2) of safe crank angles inside the travel, the piece that holds ``around``."""
    grid = [np.linspace(lo - 0.02, hi + 0.02, 240) for lo, hi in zip(lower, upper)]
    one, four = np.meshgrid(*grid)
    q = np.stack([one, four], axis=-1)
    room = np.minimum((q - lower).min(axis=-1), (upper - q).min(axis=-1))
    value = np.minimum(margin(q, m), room)
    rings = contourpy.contour_generator(x=grid[0], y=grid[1], z=value).lines(0.0)
    holding = [
        np.asarray(ring)[:-1] for ring in rings if inside(around, np.asarray(ring)[:-1]) > 0.0
    ]
    if not holding:
        raise ValueError(
            f"{around.tolist()} is outside of the joint space; expected a start inside"
        )
    ring = max(holding, key=len)
    return np.asarray(ring[:: max(1, len(ring) // 160)])


MACHINES: dict[str, Callable[[], Machine]] = {
    "2prr": cache(_two_prr),
    "replalink": cache(_replalink),
    "5r": cache(_five_r),
    "mast": cache(_mast),
    "3prs": cache(_three_prs),
}
