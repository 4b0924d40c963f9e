"""Diagrams to draw: those of the toolbox by name, and a user's own by file and function."""

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import InputError


def diagram(name: str) -> Any:
    """The Drake diagram of this name, or what ``FILE.py:FUNCTION`` returns.

    InputError for an unknown name, and for a file or function that gives no Drake system.
    """
    if ":" in name:
        return _own(name)
    if name not in DIAGRAMS:
        raise InputError(
            "view --blocks",
            f"no diagram of {name!r}",
            f"one of {', '.join(DIAGRAMS)}, or FILE.py:FUNCTION of your own",
        )
    return DIAGRAMS[name]()


def _own(name: str) -> Any:
    file, _, function = name.rpartition(":")
    path = Path(file)
    if not path.is_file():
        raise InputError(path, "no such file", "a Python file, as in my_robot.py:build")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise InputError(path, "no Python file", "a name that ends with .py")
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(path.resolve().parent))  # its own neighbours
    try:
        spec.loader.exec_module(module)
        built = getattr(module, function)()
    except AttributeError as error:
        if hasattr(module, function):
            raise InputError(path, f"{function}: {error}", "a function that runs") from error
        raise InputError(
            path, f"no function {function!r}", "the name of one that returns a diagram"
        ) from None
    except Exception as error:
        raise InputError(
            path,
            f"{type(error).__name__}: {error}",
            f"a file that runs, {function} without arguments",
        ) from error
    finally:
        sys.path.pop(0)
    if not hasattr(built, "GetGraphvizString"):
        raise InputError(
            path, f"{function} returns a {type(built).__name__}", "a Drake Diagram or other System"
        )
    return built


def _c_drive(controller: str) -> Callable[[], Any]:
    def build() -> Any:
        from ...diagrams.c_drive_config import CONTROLLERS, CDriveLoopConfig
        from ...diagrams.c_drive_loop import c_drive_loop

        return c_drive_loop(CDriveLoopConfig(controller=CONTROLLERS[controller]()))

    return build


def _pmc(controller: str) -> Callable[[], Any]:
    def build() -> Any:
        from ...diagrams.pmc_loop import PMCLoopConfig, pmc_loop

        return pmc_loop(PMCLoopConfig(controller=controller))

    return build


def _servo(machine: str, scheme: str, **settings: Any) -> Callable[[], Any]:
    def build() -> Any:
        from ...diagrams.servo_loop import Scheme
        from ...diagrams.servo_loop import build as loop
        from ..mechatronic.servo_machines import motion, servo_machine

        made = {key: value() for key, value in settings.items()}
        chosen = servo_machine(machine)
        return loop(chosen.loop(scheme=Scheme(scheme), **made), motion(chosen, None)[1])

    return build


def _coupled() -> Any:
    from ...diagrams.servo_loop import Coupling

    return Coupling.plant


def _current_loop() -> Any:
    from ...systems.servo.current_loop import CurrentLoop

    return CurrentLoop()


def _mm3a() -> Any:
    from ...diagrams.mm3a import teleoperation
    from ...systems.mm3a.stepper import EmpiricalStepper

    start = (0.0, -1.5, 0.006)
    return teleoperation(EmpiricalStepper(start), start)


def _stick_slip() -> Any:
    from ...diagrams.stick_slip import stick_slip_simulator
    from ...models.mm3a.actuators import joint_actuators

    part = joint_actuators()[2]
    return stick_slip_simulator(part.actuator, part.drive).get_system()


DIAGRAMS: dict[str, Callable[[], Any]] = {
    "c-drive": _c_drive("pd"),
    "c-drive-ts": _c_drive("ts"),
    "c-drive-ct": _c_drive("ct"),
    "c-drive-ra": _c_drive("ra"),
    "pmc": _pmc("ts"),
    "pmc-pd": _pmc("pd"),
    "pmc-ct": _pmc("ct"),
    "5r": _servo("5r", "joint-space"),
    "5r-workspace": _servo("5r", "workspace"),
    "5r-computed-torque": _servo("5r", "computed-torque"),
    "5r-computed-torque-workspace": _servo("5r", "computed-torque-workspace"),
    "5r-plant": _servo("5r", "joint-space", coupling=_coupled),
    "5r-current-loop": _servo("5r", "joint-space", current_loop=_current_loop),
    "2prr": _servo("2prr", "joint-space"),
    "replalink": _servo("replalink", "joint-space"),
    "mast": _servo("mast", "joint-space"),
    "3prs": _servo("3prs", "joint-space"),
    "mm3a": _mm3a,
    "stick-slip": _stick_slip,
}
