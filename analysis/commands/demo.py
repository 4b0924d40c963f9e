"""``gapscope demo``: a printed experiment, a machine whose effect is withheld, a measured log."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def demo(
    out: Annotated[
        Path, typer.Option(callback=places.folder, help="Folder for the reports, made if missing.")
    ],
    seed: Annotated[int, typer.Option(help="Seed that decides the withheld effect.")] = 2015,
) -> None:
    """Show the instrument on a printed experiment, on a withheld effect and on a measured log."""
    from rich.console import Console

    from .. import demo as parts
    from ..gap.diagnosis import diagnose
    from ..gap.terminal import print_diagnosis
    from ..gap.thesis.diagnosis import diagnose_thesis
    from ..gap.thesis.terminal import print_thesis

    console = Console()
    with Console(stderr=True).status("reading") as status:
        console.rule("1. Printed experiment of the C-drive against its simulation")
        thesis = diagnose_thesis(progress=lambda text: status.update(text))
        paths = thesis.save(out / "thesis-c-drive")
        print_thesis(console, thesis)
        console.print(f"report: {paths[-1]}", soft_wrap=True)
        console.rule(f"2. A C-drive with an effect that is withheld (seed {seed})")
        status.update("simulating it")
        folder = out / "blind"
        case = parts.sealed_case(folder, seed)
        console.print(f"answer sealed before the diagnosis: SHA-256 {case.seal[:16]}…")
        blind = diagnose(case.logset, progress=lambda text: status.update(text))
        print_diagnosis(console, blind)
        among = blind.verdict.verdict == "ambiguous" and set(case.answer["answer"]) <= set(
            parts.named(blind)
        )
        undecided = "undecided, the answer among the named" if among else "not right"
        console.print(
            f"diagnosed: {', '.join(parts.named(blind)) or 'nothing'} ({blind.verdict.verdict})\n"
            f"answer opened: {', '.join(case.answer['answer'])}, {case.answer['parameters']}\n"
            f"-> {'right' if case.right(blind) else undecided}; {case.open(folder)}",
            soft_wrap=True,
        )
        console.print(f"report: {parts.save(blind, folder)}", soft_wrap=True)
        log = parts.measured_log()
        if log is None:
            console.print(
                f"3. needs a measured log: set {parts.DATA} to the folder with {parts.EMPS}/, which "
                f"`gapscope data get {parts.EMPS}` writes where there is a connection."
            )
            return
        console.rule("3. Measured log of the EMPS slider")
        measured = diagnose(log, progress=lambda text: status.update(text))
        print_diagnosis(console, measured)
        console.print(f"report: {parts.save(measured, out / 'emps')}", soft_wrap=True)
