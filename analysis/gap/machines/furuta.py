"""Nominal model of a rotary inverted pendulum (``system.kind: furuta``), such as the QUBE-Servo 2.

Columns ``theta_ref alpha_ref theta alpha`` [rad] and ``u`` [V], with ``u_ff`` where the law has a
feedforward; the pendulum's angle is 0 upright. ``system.nominal`` may replace any of
``models.furuta.FurutaParameters`` by its name. The motor drives the arm, the pendulum's axis is free:
its equation holds without any effort, which tells its friction and inertia from the motor's.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace

import numpy as np

from ....models import furuta, furuta_kernels
from ....models.furuta import FurutaParameters
from ....models.furuta_kernels import Balancer
from ....models.joint import VISCOUS, WIDTH, ideal_joints
from ...errors import InputError
from ..checks import shown
from ..clock import ReplayCheck
from ..description import FILE
from ..effects.base import Form, Values, everywhere, parameter
from ..logset import LogSet, Run
from ..machine import Array, RunData, encoder_step, own_parameter, rms
from ..rigid_effects import SIGN_WIDTH, joint_forms
from ..rigid_machine import RigidMachine, RigidPlant, RigidRun, bandwidth_for, prepared
from .reference import derivatives
from .settings import RunSettings, nominal_settings, require_units, run_settings, tolerance

JOINTS = ("arm", "pendulum")
MOST_BANDWIDTH = 100.0  # rad/s
SUBSTEPS = 4
LAW = re.compile(
    r"u_fb=-\((?P<kp1>[\d.]+)\*e_t\+(?P<kd1>[\d.]+)\*D\(e_t\)\)"
    r"-\((?P<kp2>[\d.]+)\*e_a\+(?P<kd2>[\d.]+)\*D\(e_a\)\).*?D=(?P<cutoff>[\d.]+)s/\(s\+"
    r".*?clip\(u_fb\+u_ff,-(?P<limit>[\d.]+),"
)


def read(logset: LogSet) -> tuple[RigidMachine, list[RunData]]:
    """Machine and runs of a rotary pendulum."""
    units = {"theta_ref": "rad", "alpha_ref": "rad", "theta": "rad", "alpha": "rad", "u": "V"}
    require_units(logset, units | ({"u_ff": "V"} if "u_ff" in logset.units else {}))
    names = {f.name for f in fields(FurutaParameters)}
    settings = nominal_settings(logset, names)
    stated = logset.system.get("nominal", {})
    try:
        nominal = FurutaParameters(**{n: settings.number(n) for n in stated if n in names})
    except ValueError as error:
        raise InputError(
            f"{logset.folder / FILE}, system.nominal", str(error), "positive constants"
        ) from None
    laws = {
        name: None if settings.get("law") is None
        else read_law(f"{logset.folder / FILE}, controllers.{name}.law", settings["law"])
        for name, settings in logset.controllers.items()
    }  # fmt: skip
    runs = [
        _run_data(run, run_settings(logset, run), logset.dt, laws[run.controller])
        for run in logset.runs
    ]
    steps = np.full(2, max(run.lsb for run in runs))
    bandwidth = bandwidth_for([r.position for r in runs], logset.dt, steps, MOST_BANDWIDTH)
    made = [_released(prepared(run, furuta.equation_columns, bandwidth)) for run in runs]
    return furuta_machine(nominal, made, bandwidth, tolerance(logset)), list(made)


def furuta_machine(
    nominal: FurutaParameters, runs: Sequence[RigidRun], bandwidth: float, relative: float
) -> RigidMachine:
    """The machine; ``runs`` give the speeds over which signs are smoothed."""
    rate = np.concatenate([run.rate[run.window] for run in runs])
    width = SIGN_WIDTH * np.sqrt(np.mean(rate**2, axis=0))

    def plant(values: Mapping[str, float]) -> RigidPlant:
        p = replace(nominal, **dict(values))
        joints = ideal_joints(2, 1, 1.0)
        joints.law[:, WIDTH] = width
        joints.law[:, VISCOUS] = p.D_r + p.k * p.k / p.R, p.D_p
        return RigidPlant(
            phi=np.array(p.groups),
            joints=joints,
            inputs=np.array([[p.k / p.R], [0.0]]),
            offset=np.zeros(2),
            scale=np.ones(2),
        )

    # R and L_r are left out: their share of a few per cent cannot be told from that of k and m.
    units = {"k": "N m/A", "J_r": "kg m^2", "m": "kg", "L_p": "m", "D_r": "N m s/rad",
             "D_p": "N m s/rad"}  # fmt: skip
    return RigidMachine(
        kind="furuta",
        joints=JOINTS,
        actuated=("arm",),
        position_unit="rad",
        effort_unit="N m",
        command_unit="V",
        own=tuple(
            own_parameter(name, unit, getattr(nominal, name), relative)
            for name, unit in units.items()
        ),
        damping={"arm": "D_r", "pendulum": "D_p"},
        bandwidth=bandwidth,
        plant=plant,
        effects=lambda machine, runs: [*joint_forms(machine, runs), *_mass_forms(nominal)],
        loop=_simulate,
        replayed=_replays,
    )


def _released(run: RigidRun) -> RigidRun:
    """The run from when its reference first moves: before that a hand may hold the pendulum upright."""
    moved = np.any(run.reference != run.reference[0], axis=1)
    first = max(int(np.argmax(moved)), run.window.start)
    if run.window.stop - first < len(run.t) // 2:
        return run
    return replace(run, window=slice(first, run.window.stop))


def _mass_forms(nominal: FurutaParameters) -> list[Form]:
    """More mass or inertia than the nominal one: on the arm, on the pendulum, or at its tip."""
    J, P, _, _ = nominal.groups
    l = 0.5 * nominal.L_p  # noqa: E741

    def arm(plant: RigidPlant, values: Values) -> None:
        plant.phi[0] += values.get("inertia_arm", 0.0)

    def tip(plant: RigidPlant, values: Values) -> None:
        m, place = values["mass"], values["place"]
        plant.phi += m * np.array([nominal.L_r**2, place**2, place * nominal.L_r, furuta.G * place])

    def form(
        effect: str, name: str, free: tuple, apply: object, joint: str, **more: object
    ) -> Form:
        return Form(
            effect=effect, name=name, parameters=free, apply=apply,  # type: ignore[arg-type]
            where=everywhere("joints", [joint]), **more,  # type: ignore[arg-type]
        )  # fmt: skip

    mass = parameter("mass", "kg", 0.2 * nominal.m, lower=-0.9 * nominal.m)
    place = parameter("place", "m", l, lower=0.0, upper=2.0 * nominal.L_p, starts=(2.0 * l, l))
    inertia = parameter("inertia_arm", "kg m^2", 0.2 * J, lower=-0.9 * J)
    return [
        form("inertia.payload", "inertia of the arm", (inertia,), arm, "arm",
             replaces=frozenset({"J_r"})),
        form("inertia.payload", "mass on the pendulum", (mass, place), tip, "pendulum",
             own_start=True, shapes=frozenset({"place"})),
        _pendulum_length(nominal, P),
    ]  # fmt: skip


def _pendulum_length(nominal: FurutaParameters, P: float) -> Form:
    """A pendulum of another effective length: its inertia differs, its weight's moment does not."""

    def apply(plant: RigidPlant, values: Values) -> None:
        plant.phi[1] += values["inertia_pendulum"]

    return Form(
        effect="geometry.parameter",
        name="mass distribution of the pendulum",
        parameters=(parameter("inertia_pendulum", "kg m^2", 0.2 * P, lower=-0.9 * P),),
        apply=apply,
        where=everywhere("joints", ["pendulum"]),
        replaces=frozenset({"L_p"}),
    )


def read_law(where: str, text: object) -> Balancer:
    """The law that a text states; InputError if it is unreadable."""
    found = LAW.search(re.sub(r"\s+", "", str(text)))
    if found is None:
        raise InputError(
            where, shown(text),
            "u_fb=-(KP*e_t+KD*D(e_t))-(KP*e_a+KD*D(e_a)), D=N s/(s+N), u=clip(u_fb+u_ff,-L,L)",
        )  # fmt: skip
    g = {name: float(value) for name, value in found.groupdict().items()}
    return Balancer(
        np.array([g["kp1"], g["kp2"]]), np.array([g["kd1"], g["kd2"]]), g["cutoff"], g["limit"]
    )


def _run_data(run: Run, settings: RunSettings, dt: float, law: Balancer | None) -> RunData:
    reference = run.stack("theta_ref", "alpha_ref")
    rate, acceleration = derivatives(reference, dt)
    position = run.stack("theta", "alpha")
    feedforward = run.columns.get("u_ff", np.zeros(len(position)))
    return RunData(
        name=run.name,
        use=run.use,
        settings=run.settings,
        dt=dt,
        t=run.columns["t"],
        reference=reference,
        reference_rate=rate,
        reference_acceleration=acceleration,
        position=position,
        command=run.stack("u"),
        controller=None if law is None else (law, feedforward),
        period=settings.period(dt),
        lsb=encoder_step(position),
        start=settings.start,
    )


def _raw(run: RunData) -> RunData:
    return run.raw if isinstance(run, RigidRun) else run


def _replays(runs: Sequence[RunData]) -> list[ReplayCheck]:
    checks = []
    for run in map(_raw, runs):
        if run.controller is None:
            continue
        law, feedforward = run.controller
        command = np.empty_like(run.command)
        furuta_kernels.balance(run.reference, run.position, feedforward, law, run.dt, command)
        size = rms([run.command]) or 1.0
        checks.append(ReplayCheck(run=run.name, disagreement=rms([command - run.command]) / size))
    return checks


def _simulate(run: RunData, plant: RigidPlant) -> tuple[Array, Array] | None:
    if run.controller is None:
        return None
    assert isinstance(run, RigidRun)
    block = run.window.start or 0
    start = np.concatenate([run.smooth[block], run.rate[block]])
    first = run.block * block + run.block // 2
    run = run.raw
    law, feedforward = run.controller
    position, command = run.position.copy(), np.zeros_like(run.command)
    furuta_kernels.simulate(
        run.reference, feedforward, first, start, plant.phi, plant.joints, float(plant.inputs[0, 0]), law,
        run.lsb, run.dt, SUBSTEPS, position, command,
    )  # fmt: skip
    return position, command


def horizon_errors(
    runs: Sequence[RigidRun], plant: RigidPlant, horizon: float, every: float = 0.1
) -> Array:
    """Rms position errors (2,) [rad] after ``horizon`` [s] of free prediction on the logged command.

    The pendulum falls without control: a long simulation says little of the model. Predictions start
    every ``every`` seconds from the smoothed measured state.
    """
    errors = []
    for run in runs:
        b, blocks = run.block, round(horizon / run.dt)
        path = np.empty((b * blocks, 2))
        for s in range(run.window.start, run.window.stop - blocks - 1, round(every / run.dt)):
            # The state of a block is that of its middle.
            furuta_kernels.predict(
                run.raw.command, b * s + b // 2, np.concatenate([run.smooth[s], run.rate[s]]),
                plant.phi, plant.joints, float(plant.inputs[0, 0]), run.raw.dt, SUBSTEPS, path,
            )  # fmt: skip
            errors.append(path[-1] - run.smooth[s + blocks])
    return np.asarray(np.sqrt(np.mean(np.square(errors), axis=0)))
