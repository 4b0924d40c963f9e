"""``gapscope import FILE...``: a wizard that turns logs of any format into a log set."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import places

if TYPE_CHECKING:
    from ..gap.importing import Plan


def import_logs(
    files: Annotated[
        list[Path],
        typer.Argument(
            help="CSV, Parquet, MATLAB, HDF5, MCAP files or ROS bags; one run each, the same columns."
        ),
    ],
    out: Annotated[
        Path, typer.Option(callback=places.folder, help="Folder of the log set to write.")
    ],
    model: Annotated[
        Path | None,
        typer.Option(help="logset.yaml (or its folder) with system, controller and columns."),
    ] = None,
    kind: Annotated[
        str | None, typer.Option(help="Machine, instead of --model: slider, c_drive ...")
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            help="NAME=COLUMN[:UNIT] instead of a guess, t=COLUMN for the time; repeatable."
        ),
    ] = None,
    controller: Annotated[
        list[str] | None,
        typer.Option(
            help="Which controller of --model was running: ID, or FILE=ID for one file; repeatable."
        ),
    ] = None,
    validate: Annotated[
        list[Path] | None, typer.Option(help="A file kept for validation; repeatable.")
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help="Sample rate of logs without times [Hz].")
    ] = None,
    sample_time: Annotated[
        float | None, typer.Option(help="Sample time of the log set [s]; default that of the log.")
    ] = None,
    resample: Annotated[
        bool, typer.Option("--resample", help="Interpolate uneven or several clocks to one.")
    ] = False,
    form: Annotated[
        str, typer.Option("--format", help="Tables to write: csv, csv.gz or parquet.")
    ] = "csv",
    yes: Annotated[
        bool, typer.Option("--yes", "-y", help="Take the guesses, ask nothing.")
    ] = False,
) -> None:
    """Turn logs into a log set: guess time, units and roles, show the guesses, ask, write."""
    from rich.console import Console

    from ..errors import InputError
    from ..gap import importing

    for option, number in (("--rate", rate), ("--sample-time", sample_time)):
        if number is not None and not 0.0 < number < float("inf"):
            raise InputError(option, f"{number}", "a positive number")
    if form not in importing.FORMATS:
        raise InputError("--format", repr(form), f"one of {', '.join(importing.FORMATS)}")
    described, wanted = _model(model, kind)
    paths = [*files, *(path for path in validate or [] if path not in files)]
    plan = importing.make_plan(paths[0], wanted, rate)
    for text in column or []:
        plan = plan.state(*_assignment(text))
    console = Console()
    _show(console, plan)
    for name in sorted(plan.columns.keys() - (wanted or plan.columns).keys()):
        typer.echo(f"note: {name} is no column of this machine; it is kept as one more.")
    asking = _interactive() and not yes
    if asking:
        plan = _ask(plan)
        resample = resample or _wants_resampling(plan)
    elif plan.doubts and not yes:
        plan.require_all()
        raise InputError(
            plan.path, f"not sure of {'; '.join(plan.doubts)}", "guesses that are confirmed",
            "Look at the table above; pass --yes to take them, or --column NAME=COLUMN[:UNIT].",
        )  # fmt: skip
    imported = importing.carry_out(
        plan, paths, name=out.resolve().name, system=importing.description(described, kind),
        validate=validate or [], controllers=controller or [], sample_time=sample_time, rate=rate,
        resample=resample, form=form,
    )  # fmt: skip
    for remark in imported.document.get("remarks", []):
        console.print(f"note: {remark}", markup=False, highlight=False)
    for path in imported.save(out):
        typer.echo(path)
    if described is None:
        typer.echo(
            f"Before `gapscope diagnose {out}`: state system (kind, nominal parameters) and controller "
            f"in {out / 'logset.yaml'}."
        )


def _interactive() -> bool:
    return sys.stdin.isatty()


def _model(
    model: Path | None, kind: str | None
) -> tuple[dict[str, Any] | None, dict[str, str] | None]:
    """Description of the machine, and the columns (name -> unit) that its log set must have."""
    from ..errors import InputError

    if model is not None:
        from ..gap.description import FILE, read_description

        path = model / FILE if model.is_dir() else model
        described = read_description(path)
        return described, {n: text for n, text in described["columns"].items() if n != "t"}
    if kind is None:
        return None, None
    from ..gap.machines import columns_of

    wanted = columns_of(kind)
    if wanted is None:
        raise InputError(
            "--kind", f"{kind!r} has no fixed columns", "--model LOGSET that names them"
        )
    return None, dict(wanted)


def _assignment(text: str) -> tuple[str, str, str]:
    """NAME=COLUMN[:UNIT]; a colon that is followed by no unit belongs to the column."""
    from ..errors import InputError
    from ..gap.importing.units import known_unit

    name, equals, source = text.partition("=")
    if not (name and equals and source):
        raise InputError("--column", repr(text), "NAME=COLUMN[:UNIT]")
    column, _, unit = source.rpartition(":")
    return (name, column, unit) if column and known_unit(unit) else (name, source, "")


def _show(console: Any, plan: "Plan") -> None:
    from rich.table import Table
    from rich.text import Text

    from ..gap.importing import SURE

    table = Table("log set", title=plan.path.name)
    table.add_column("from the log", overflow="fold")  # --column takes the whole name
    for head in ("unit of the log", "sure", "why"):
        table.add_column(head)
    taken = {"t": plan.time, **plan.columns} if plan.time else dict(plan.columns)
    for name, guess in taken.items():
        assert guess is not None
        sure = Text(f"{100 * guess.sure:.0f} %", "" if guess.sure >= SURE else "bold yellow")
        unit = guess.unit or f"taken as {plan.texts.get(name, '')}"
        table.add_row(*(Text(c) for c in (name, str(guess.source), unit)), sure, Text(guess.why))
    for name in plan.missing:
        table.add_row(Text(name), Text("nothing found", "bold red"), "", "", "")
    console.print(table)


def _ask(plan: "Plan") -> "Plan":
    """Go through what is missing or in doubt, then offer to change the rest."""
    from rich.prompt import Confirm, Prompt

    from ..errors import InputError

    unsure = [
        n for n, g in plan.columns.items() if any(d.startswith(f"{n} from") for d in plan.doubts)
    ]
    for name in [*plan.missing, *unsure]:
        default = str(plan.columns[name].source) if name in plan.columns else None
        answer = Prompt.ask(f"{name} ({plan.texts[name]}): COLUMN[:UNIT]", default=default)
        if answer:
            plan = plan.state(*_assignment(f"{name}={answer}"))
    while not Confirm.ask("Write the log set like this?", default=True):
        text = Prompt.ask("NAME=COLUMN[:UNIT] to change, empty to stop", default="")
        if not text:
            raise typer.Abort
        try:
            plan = plan.state(*_assignment(text))
        except InputError as error:
            typer.echo(f"{error}")
    return plan


def _wants_resampling(plan: "Plan") -> bool:
    """Ask where the clock of the first file is uneven or there are several."""
    from rich.prompt import Confirm

    from ..gap.importing.plan import clock_trouble

    trouble = clock_trouble(plan)
    return bool(trouble) and Confirm.ask(
        f"{trouble} Interpolate to one uniform clock?", default=False
    )
