"""Nominal model of one linear axis (``system.kind: slider``), such as the EMPS benchmark."""

from collections.abc import Mapping

import numpy as np

from ....models.drive import VISCOUS, ideal_drive
from ....models.drive_kernels import CASCADE, LoopController
from ...errors import InputError
from ..checks import shown
from ..description import FILE
from ..drive_machine import DriveMachine, DrivePlant, PayloadAxis
from ..logset import LogSet, Run
from ..machine import RunData, encoder_step, own_parameter
from .reference import derivatives
from .settings import (
    RunSettings,
    Settings,
    nominal_settings,
    require_units,
    run_settings,
    tolerance,
)

COLUMNS = {"q_ref": "m", "q": "m", "force": "N"}
RIPPLE_PERIODS = (0.001, 0.002, 0.004, 0.005, 0.01, 0.016, 0.02, 0.024, 0.03, 0.06)  # screws [m]
CASCADE_KEYS = {
    "kind", "law", "kp_per_s", "kv_V_per_m_per_s", "saturation_V", "force_per_volt_N",
    "encoder_lsb_m",
}  # fmt: skip
SIGN_WIDTH = 1e-3  # of the smoothed sign of dry friction [m/s]


def read(logset: LogSet) -> tuple[DriveMachine, list[RunData]]:
    """Machine and runs of a slider log set with the cascade P-P law of EMPS."""
    require_units(logset, COLUMNS)
    nominal = nominal_settings(logset, {"mass_kg", "viscous_N_s_per_m"})
    machine = slider_machine(
        nominal.number("mass_kg", positive=True),
        nominal.number("viscous_N_s_per_m", least=0.0),
        tolerance(logset),
    )
    controllers = {
        name: read_controller(f"{logset.folder / FILE}, controllers.{name}", settings)
        for name, settings in logset.controllers.items()
    }
    runs = [
        _run_data(run, run_settings(logset, run), logset.dt, controllers[run.controller])
        for run in logset.runs
    ]
    return machine, runs


def slider_machine(mass: float, viscous: float, relative: float) -> DriveMachine:
    """One axis of ``mass`` [kg] with viscous friction [N s/m]."""

    def build(values: Mapping[str, float]) -> DrivePlant:
        inertia = np.array([[values["mass"]]])
        plant = DrivePlant(
            inertia=inertia, drive=ideal_drive(inertia, np.ones((1, 1)), [0.0], SIGN_WIDTH)
        )
        plant.drive.element[0, VISCOUS] = values["viscous"]
        return plant

    return DriveMachine(
        kind="slider",
        joints=("axis",),
        elements=("axis",),
        task=("axis",),
        task_map=np.ones((1, 1)),
        position_unit="m",
        effort_unit="N",
        own=(
            own_parameter("mass", "kg", mass, relative),
            own_parameter("viscous", "N s/m", viscous, relative),
        ),
        payload=(
            PayloadAxis(
                name="mass", unit="kg", inertia=np.ones((1, 1)), own="mass", scale=0.2 * mass
            ),
        ),
        viscous_own=("viscous",),
        ripples={f"{1e3 * p:g} mm": 2.0 * np.pi / p for p in RIPPLE_PERIODS},
        motor_share=0.5,
        bandwidth=100.0,
        plant=build,
        load_encoders=True,
    )


def read_controller(where: str, values: Mapping[str, object]) -> LoopController:
    """Cascade P-P from its block of a log set; InputError for a bad key."""
    settings = Settings(where, values, CASCADE_KEYS)
    if values.get("kind") != "cascade_p_p":
        raise InputError(f"{where}.kind", shown(values.get("kind")), "cascade_p_p")
    force_per_volt = settings.number("force_per_volt_N", positive=True)
    zero = np.zeros((1, 1))
    return LoopController(
        kind=CASCADE,
        kp=np.array([[settings.number("kp_per_s", positive=True)]]),
        ki=zero,
        kd=zero,
        cutoff=1.0,
        output=zero,
        feedforward=0.0,
        friction=zero,
        transition=zero,
        from_position=zero,
        from_torque=zero,
        rate_from_state=zero,
        rate_from_position=zero,
        kv=settings.number("kv_V_per_m_per_s", positive=True) * force_per_volt,
        limit=settings.number("saturation_V", positive=True) * force_per_volt,
    )


def _run_data(run: Run, settings: RunSettings, dt: float, controller: LoopController) -> RunData:
    reference = run.stack("q_ref")
    rate, acceleration = derivatives(reference, dt)
    position = run.stack("q")
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
        command=run.stack("force"),
        controller=controller,
        period=settings.period(dt),
        lsb=encoder_step(position),
        start=settings.start,
    )
