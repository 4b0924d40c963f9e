"""``gapscope design LOGSET``: the motion that best separates the two best hypotheses."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def design(
    logset: Annotated[Path, typer.Argument(help="A log set folder.")],
    out: Annotated[
        Path | None,
        typer.Option(
            callback=places.folder,
            help="Folder for design.json, motion.yaml, design.png; default out/NAME-design.",
        ),
    ] = None,
    speed: Annotated[float | None, typer.Option(help="Largest shaft speed [rad/s or m/s].")] = None,
    effort: Annotated[float | None, typer.Option(help="Largest shaft effort [N m or N].")] = None,
    travel: Annotated[
        list[str] | None,
        typer.Option(help="Range of a task coordinate, such as translation=-0.2:0 [m]."),
    ] = None,
    controller: Annotated[
        str | None, typer.Option(help="Controller id of the log set; default: of the first run.")
    ] = None,
    period: Annotated[float, typer.Option(help="Length of one cycle [s].")] = 1.0,
    candidates: Annotated[int, typer.Option(help="Motions looked at.", min=20)] = 600,
    error: Annotated[
        float, typer.Option(help="Probability of the wrong choice that runs are stated for.")
    ] = 0.01,
    seed: Annotated[int, typer.Option(help="Of the bootstrap and the search.", min=0)] = 0,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress, no words.")] = False,
) -> None:
    """Design the next experiment: the motion inside the limits that tells most."""
    from rich.console import Console

    from ..errors import InputError
    from ..gap.design import design_experiment, limits_of
    from ..gap.diagnosis import diagnose

    if not 0.0 < error < 0.5:
        raise InputError("--error", f"{error}", "a probability between 0 and 0.5")
    ranges = dict(_range(text) for text in travel or [])
    folder = out or Path("out") / f"{logset.resolve().name}-design"
    places.folder(folder)
    with Console(stderr=True, quiet=quiet).status("reading") as status:
        diagnosis = diagnose(logset, seed=seed, progress=status.update)
        found = design_experiment(
            diagnosis,
            limits=limits_of(diagnosis, ranges=ranges, speed=speed, effort=effort),
            controller=controller,
            period=period,
            candidates=candidates,
            error=error,
            seed=seed,
            progress=status.update,
        )
    paths = found.save(folder)
    if quiet:
        return
    first, second = (r.fit.hypothesis.label for r in (found.pair.first, found.pair.second))
    typer.echo(f"{diagnosis.verdict.verdict}: {first} against {second}. {found.pair.remark}")
    typer.echo(
        f"Existing runs: {found.before:.3g} nats for the first, in sample. Repeating {found.repeat['run']}: "
        f"{found.repeat['nats']:.3g}. Designed motion: {found.nats:.3g} nats a run; {found.runs} "
        f"run(s) for {100 * error:g} % error. {found.simulations} simulations, "
        f"{found.seconds:.0f} s."
    )
    for path in paths:
        typer.echo(path)


def _range(text: str) -> tuple[str, tuple[float, float]]:
    from ..errors import InputError

    name, _, numbers = text.partition("=")
    low, _, high = numbers.partition(":")
    try:
        return name, (float(low), float(high))
    except ValueError:
        raise InputError("--travel", repr(text), "NAME=LOWEST:HIGHEST") from None
