"""Diagrams to draw: those of the toolbox by name, and a user's own by file and function."""

import importlib.util
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..errors import InputError

PARALLEL = ("5r", "replalink", "2prr", "mast", "3prs")
SCHEMES = ("workspace", "computed-torque", "computed-torque-workspace")


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


def _servo(name: str, **settings: str) -> Callable[[], Any]:
    """The servo loop of a parallel machine on the first of its motions."""

    def build() -> Any:
        from ...diagrams import servo_loop
        from ..mechatronic.servo_machines import servo_machine

        machine = servo_machine(name)
        return servo_loop.build(machine.loop(**settings), next(iter(machine.motions.values())))

    return build


def _current_loop() -> Any:
    from ...diagrams.five_bar_loop import MOTIONS, FiveBarLoop, build
    from ...systems.servo.current_loop import CurrentLoop

    return build(FiveBarLoop(current_loop=CurrentLoop()), MOTIONS["circle"])


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
    **{name: _servo(name) for name in PARALLEL},
    **{f"{name}-{scheme}": _servo(name, scheme=scheme) for name in PARALLEL for scheme in SCHEMES},
    **{f"{name}-plant": _servo(name, coupling="plant") for name in PARALLEL},
    "5r-current-loop": _current_loop,
    "mm3a": _mm3a,
    "stick-slip": _stick_slip,
}
