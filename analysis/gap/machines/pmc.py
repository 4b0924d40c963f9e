"""Nominal model of PepperMill-Carrier log sets (``system.kind: pmc``), as ``gapscope simulate pmc`` writes them."""

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ....models.pmc.control import Controller
from ....models.pmc.controllers import CONTROLLERS, Settings, controller
from ....models.pmc.parameters import PMCParameters
from ....models.pmc.prediction import MOTORS
from ...errors import InputError
from ..carrier_machine import CarrierMachine, CarrierRun, joints_of, own_parameters, poses_of
from ..logset import FILE, LogSet, Run
from ..machine import RunData, encoder_step
from .reference import derivatives
from .settings import Settings as Keys
from .settings import require_units, tolerance

RIPPLES_PER_TURN = (1, 2, 4, 6, 8, 12)  # torque ripple periods of a motor to look for
RUN_KEYS = {"motion", "speed", "placement", "rate_Hz", "period_s", "start_s", "note"}


def read(logset: LogSet) -> tuple[CarrierMachine, list[RunData]]:
    """Machine and runs of a PepperMill-Carrier log set."""
    units = {f"psi_{m}{end}": "rad" for m in MOTORS for end in ("", "_ref")}
    require_units(logset, units | {f"tau_{m}": "N m" for m in MOTORS})
    where = f"{logset.folder / FILE}, system"
    known = {"kind", "nominal", "home", "tolerance", "limits", "description", "note"}
    Keys(where, logset.system, known)
    parameters = _parameters(logset.system.get("nominal", {}), where)
    home = _home(logset.system.get("home"), where)
    laws = {
        name: _controller(
            values, f"{logset.folder / FILE}, controllers.{name}", parameters, home, logset.dt
        )
        for name, values in logset.controllers.items()
    }
    runs = [_run(run, logset, laws[run.controller], home, parameters) for run in logset.runs]
    reached = np.concatenate([joints_of(run.position, home, parameters) for run in runs])
    machine = CarrierMachine(
        kind="pmc",
        joints=MOTORS,
        position_unit="rad",
        effort_unit="N m",
        own=own_parameters(parameters, tolerance(logset)),
        parameters=parameters,
        home=home,
        middle=0.5 * (reached.min(axis=0) + reached.max(axis=0)),
        ripples={f"1/{k} turn" if k > 1 else "1 turn": float(k) for k in RIPPLES_PER_TURN},
    )
    return machine, list(runs)


def _parameters(nominal: Any, where: str) -> PMCParameters:
    if not isinstance(nominal, Mapping):
        raise InputError(f"{where}.nominal", f"{nominal!r}", "a mapping of parameters")
    values = {key: value for key, value in nominal.items() if key != "note"}
    try:
        return PMCParameters.from_mapping(values, f"{where}.nominal")
    except (ValueError, TypeError) as error:
        raise InputError(
            f"{where}.nominal", str(error), "fields of PMCParameters, each with its number"
        ) from None


def _home(values: Any, where: str) -> Any:
    numbers = values if isinstance(values, list) else []
    if len(numbers) != 4 or not all(isinstance(v, int | float) for v in numbers):
        raise InputError(
            f"{where}.home", f"{values!r}", "four joints d1, d2 [m], theta1, theta2 [rad]",
            "They are the joints at which all motor angles are logged as zero.",
        )  # fmt: skip
    return np.array(numbers, dtype=float)


def _controller(
    values: Mapping[str, Any], where: str, parameters: PMCParameters, home: Any, dt: float
) -> Controller:
    kind = values.get("kind")
    if kind not in CONTROLLERS:
        raise InputError(f"{where}.kind", f"{kind!r}", f"one of {', '.join(CONTROLLERS)}")
    default = CONTROLLERS[kind]
    keys = Keys(
        where, values, {item.name for item in fields(default)} | {"kind", "model_error", "note"}
    )
    gains: dict[str, Any] = {
        item.name: tuple(values[item.name])
        if isinstance(values[item.name], list)
        else values[item.name]
        for item in fields(default)
        if item.name in values
    }
    try:
        law: Any = type(default)  # whose defaults are those of CONTROLLERS
        settings: Settings = law(**gains)
        believed = parameters.heavier(keys.number("model_error", 0.0))
        return controller(settings, believed, home, dt)
    except (ValueError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(where, str(error), "gains of this controller") from None


def _run(
    run: Run, logset: LogSet, law: Controller, home: Any, parameters: PMCParameters
) -> CarrierRun:
    where = f"{logset.folder / FILE}, run {run.name}"
    keys = Keys(where, run.settings, RUN_KEYS)
    period = run.settings.get("period_s")
    reference = run.stack(*(f"psi_{m}_ref" for m in MOTORS))
    position = run.stack(*(f"psi_{m}" for m in MOTORS))
    rate, acceleration = derivatives(reference, logset.dt)
    joints = joints_of(reference, home, parameters)
    pose = poses_of(joints, parameters)
    for what, reached in (
        ("psi_*_ref", pose),
        ("psi_*", poses_of(joints_of(position, home, parameters), parameters)),
    ):
        lost = np.flatnonzero(~np.isfinite(reached).all(axis=1))
        if lost.size:
            raise InputError(
                f"{where}, row {lost[0] + 2}, columns {what}",
                "motor angles outside the reach of the limbs",
                "angles counted from system.home by a robot of system.nominal",
            )
    return CarrierRun(
        name=run.name,
        use=run.use,
        settings=run.settings,
        dt=logset.dt,
        t=run.columns["t"],
        reference=reference,
        reference_rate=rate,
        reference_acceleration=acceleration,
        position=position,
        command=run.stack(*(f"tau_{m}" for m in MOTORS)),
        controller=law,
        period=round(keys.number("period_s", positive=True) / logset.dt) if period else None,
        lsb=encoder_step(position),
        start=keys.number("start_s", 0.0),
        joints=joints,
        joint_acceleration=derivatives(joints, logset.dt)[1],
        pose=pose,
        pose_acceleration=derivatives(pose, logset.dt)[1],
    )
