"""Nominal models of closed chains (``five_bar``, ``replalink``, ``two_prr``, ``mast``, ``three_prs``) and their logs.

Columns of joint i: ``q{i}_ref`` and ``q{i}`` (rad, or m on a guide), and the motor's ``current{i}`` in A.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....models.dc_motor import joint_per_motor
from ....models.drive import BACKWARD, FORWARD, WIDTH, ideal_drive
from ....models.parallel.five_bar import FiveBar
from ....models.parallel.machine import (
    FiveBarMachine,
    ParallelMachine,
    TableMachine,
    TwoPRRMachine,
)
from ....models.parallel.mast import MAST
from ....models.parallel.prs import Table
from ....models.parallel.replalink import REPLALINK
from ....models.parallel.three_prs import FLEXURES, THREE_PRS, Flexures
from ....models.parallel.two_prr import TwoPRR
from ...errors import InputError
from ..chain_machine import ChainMachine, ChainPlant, ChainRun, chain_plant, tables
from ..description import FILE
from ..logset import LogSet, Run
from ..machine import RunData, encoder_step, own_parameter
from .reference import derivatives
from .settings import Settings, nominal_settings, require_units, run_settings, tolerance

AXIS_KEYS = frozenset({
    "gear_ratio", "lead_m_per_rev", "torque_constant_Nm_per_A", "rotor_inertia_kg_m2",
    "viscous_Nms_per_rad", "coulomb_Nm", "sign_width_rad_per_s",
})  # fmt: skip
SIGN_WIDTH = 0.1  # of the nominal dry friction, 1/beta of Table 4.1 [rad/s]


@dataclass(frozen=True, kw_only=True)
class Kind:
    """How one kind of closed chain is read."""

    unit: str  # of a joint
    keys: frozenset[str]  # of the geometry, in system.nominal
    build: Callable[[Settings], ParallelMachine]


def _five_bar(nominal: Settings) -> ParallelMachine:
    return _linkage(nominal, FiveBar())


def _replalink(nominal: Settings) -> ParallelMachine:
    # Its printed rotors are those of the axes here, which have them from ``rotor_inertia_kg_m2``.
    return _linkage(nominal, replace(REPLALINK, rotors=(0.0, 0.0)))


def _linkage(nominal: Settings, d: FiveBar) -> ParallelMachine:
    masses: Any = tuple(
        nominal.number(f"mass{i}_kg", default, least=0.0)
        for i, default in enumerate(d.masses, start=1)
    )
    geometry = replace(
        d,
        base=nominal.number("base_m", d.base, positive=True),
        crank1=nominal.number("crank1_m", d.crank1, positive=True),
        rod2=nominal.number("rod2_m", d.rod2, positive=True),
        rod3=nominal.number("rod3_m", d.rod3, positive=True),
        crank4=nominal.number("crank4_m", d.crank4, positive=True),
        tool=nominal.number("tool_m", d.tool, positive=True),
        masses=masses,
    )
    return FiveBarMachine(geometry=geometry)


def _two_prr(nominal: Settings) -> ParallelMachine:
    d = TwoPRR()
    # Table 6.2 counts the axes in its masses of the sliders, here they are those of the rotors.
    sliders = (nominal.number("mass1_kg", least=0.0), nominal.number("mass2_kg", least=0.0))
    bars = [nominal.number(f"mass{i}_kg", d.masses[i - 1], least=0.0) for i in (3, 4, 5, 6)]
    inertias: Any = tuple(
        nominal.number(f"inertia{i}_kg_m2", d.bar_inertias[i - 3], least=0.0) for i in (3, 4, 5)
    )
    geometry = TwoPRR(
        span=nominal.number("span_m", d.span, positive=True),
        bar=nominal.number("bar_m", d.bar, positive=True),
        offset=nominal.number("offset_m", d.offset, positive=True),
        masses=(*sliders, *bars),
        bar_inertias=inertias,
    )
    return TwoPRRMachine(geometry=geometry)


def _mast(nominal: Settings) -> ParallelMachine:
    return TableMachine(table=_table(nominal, MAST))


def _three_prs(nominal: Settings) -> ParallelMachine:
    flexures = Flexures(**{
        name: nominal.number(f"{name}_stiffness_Nm_per_rad", default, least=0.0)
        for name, default in vars(FLEXURES).items()
    })  # fmt: skip
    return TableMachine(table=_table(nominal, THREE_PRS), flexures=flexures)


def _table(nominal: Settings, table: Table) -> Table:
    """The table with other masses; inertias go with them."""
    mass = nominal.number("platform_mass_kg", table.platform_mass, positive=True)
    inertia: Any = tuple(mass / table.platform_mass * i for i in table.platform_inertia)
    bar = nominal.number("bar_mass_kg", table.bar_mass, positive=True)
    return replace(
        table,
        platform_mass=mass,
        platform_inertia=inertia,
        bar_mass=bar,
        bar_inertia=table.bar_inertia * bar / table.bar_mass,
        carriage_mass=nominal.number("carriage_mass_kg", table.carriage_mass, least=0.0),
    )


LINKAGE_KEYS = frozenset(
    {"base_m", "crank1_m", "rod2_m", "rod3_m", "crank4_m", "tool_m"}
    | {f"mass{i}_kg" for i in range(1, 6)}
)
TABLE_KEYS = frozenset({"platform_mass_kg", "bar_mass_kg", "carriage_mass_kg"})
KINDS = {
    "five_bar": Kind(unit="rad", keys=LINKAGE_KEYS, build=_five_bar),
    "replalink": Kind(unit="rad", keys=LINKAGE_KEYS, build=_replalink),
    "two_prr": Kind(
        unit="m",
        keys=frozenset(
            {"span_m", "bar_m", "offset_m"}
            | {f"mass{i}_kg" for i in range(1, 7)}
            | {f"inertia{i}_kg_m2" for i in (3, 4, 5)}
        ),
        build=_two_prr,
    ),
    "mast": Kind(unit="m", keys=TABLE_KEYS, build=_mast),
    "three_prs": Kind(
        unit="m",
        keys=TABLE_KEYS | {f"{name}_stiffness_Nm_per_rad" for name in vars(FLEXURES)},
        build=_three_prs,
    ),
}


def reader(kind: str) -> Callable[[LogSet], tuple[ChainMachine, list[RunData]]]:
    """``read`` of one kind of closed chain."""

    def read(logset: LogSet) -> tuple[ChainMachine, list[RunData]]:
        chosen = KINDS[kind]
        nominal = nominal_settings(logset, set(chosen.keys | AXIS_KEYS))
        try:
            chain = chosen.build(nominal)
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            where = f"{logset.folder / FILE}, system.nominal"
            raise InputError(where, str(error), "a machine that can be built") from None
        numbers = range(1, len(chain.joints) + 1)
        positions = {f"q{i}{end}": chosen.unit for i in numbers for end in ("", "_ref")}
        require_units(logset, positions | {f"current{i}": "A" for i in numbers})
        machine = chain_machine(kind, chain, nominal, tolerance(logset))
        constant = nominal.number("torque_constant_Nm_per_A", positive=True)
        return machine, [_run(run, logset, machine, constant) for run in logset.runs]

    return read


def chain_machine(
    kind: str, chain: ParallelMachine, nominal: Settings, relative: float
) -> ChainMachine:
    """The machine for the instrument; its own parameters are those of its axes and its inertia as a whole."""
    joints, n = chain.joints, len(chain.joints)
    viscous = nominal.number("viscous_Nms_per_rad", least=0.0)
    coulomb, width = (
        nominal.number("coulomb_Nm", 0.0, least=0.0),
        nominal.number("sign_width_rad_per_s", SIGN_WIDTH, positive=True),
    )
    rotor = nominal.number("rotor_inertia_kg_m2", positive=True)
    drive = ideal_drive(rotor * np.eye(n), np.eye(n), np.zeros(n), width)
    drive.element[:, (FORWARD, BACKWARD)] = coulomb
    drive.element[:, WIDTH] = width
    parts = tuple(chain.parts())
    lead = nominal.number("lead_m_per_rev", 0.0, least=0.0)
    ratio = nominal.number("gear_ratio", 1.0, positive=True)

    def build(values: Mapping[str, float]) -> ChainPlant:
        plant = chain_plant(values, drive, parts, joints)
        if coulomb:
            plant.drive.element[:, (FORWARD, BACKWARD)] = values["coulomb"]
        return plant

    own = [
        own_parameter("rotor_inertia", "kg m^2", rotor, relative),
        own_parameter("machine_inertia", "-", 1.0, relative),
        *(own_parameter(f"viscous_{j}", "N m s/rad", viscous, relative) for j in joints),
    ]
    if coulomb:
        own.append(own_parameter("coulomb", "N m", coulomb, relative))
    return ChainMachine(
        kind=kind,
        joints=joints,
        elements=joints,
        task=joints,
        task_map=np.eye(n),
        position_unit="rad",
        effort_unit="N m",
        own=tuple(own),
        payload=(),
        viscous_own=tuple(f"viscous_{j}" for j in joints),
        ripples={f"1/{k} turn" if k > 1 else "1 turn": float(k) for k in (1, 2, 3, 4, 6, 8, 12)},
        motor_share=0.8,
        bandwidth=100.0,
        plant=build,
        chain=chain,
        per_motor=joint_per_motor(ratio, lead or None),
    )


def _run(run: Run, logset: LogSet, machine: ChainMachine, constant: float) -> ChainRun:
    settings = run_settings(logset, run)
    numbers = range(1, len(machine.joints) + 1)
    joints = run.stack(*(f"q{i}" for i in numbers))
    terms = tables(machine.chain, joints, machine.per_motor)
    if not np.isfinite(terms.inertia).all():
        row = int(np.argmin(np.isfinite(terms.inertia).all(axis=(1, 2, 3))))
        raise InputError(
            f"{logset.folder / run.name}, row {row + 2}",
            f"no posture of a {machine.kind} has the joint coordinates {joints[row].tolist()}",
            "positions inside the workspace of system.nominal",
            "Check the zero and the direction of the joints, and the geometry.",
        )
    reference = run.stack(*(f"q{i}_ref" for i in numbers)) / machine.per_motor
    rate, acceleration = derivatives(reference, logset.dt)
    position = np.ascontiguousarray(joints / machine.per_motor)
    return ChainRun(
        name=run.name,
        use=run.use,
        settings=run.settings,
        dt=logset.dt,
        t=run.columns["t"],
        reference=reference,
        reference_rate=rate,
        reference_acceleration=acceleration,
        position=position,
        command=np.ascontiguousarray(constant * run.stack(*(f"current{i}" for i in numbers))),
        controller=None,
        period=settings.period(logset.dt),
        lsb=encoder_step(position),
        start=settings.start,
        tables=terms,
    )
