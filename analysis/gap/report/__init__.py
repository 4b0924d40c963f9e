"""``report.html``: a diagnosis on one self-contained page, for somebody who did not run it.

One section a module, beside its template of the same name. The page needs no network: style, script and
data are inside, and its content policy allows nothing else.
"""

from pathlib import Path

import jinja2

from ...files import output_folder, write_whole
from ..result import Diagnosis
from . import (
    how_far,
    next_experiment,
    provenance,
    series,
    unseen,
    verdict,
    waterfall,
    where,
    which,
    words,
)
from .base import Material, Section

FILE = "report.html"
SECTIONS: tuple[Section, ...] = (
    verdict.SECTION,
    waterfall.SECTION,
    where.SECTION,
    which.SECTION,
    how_far.SECTION,
    series.SECTION,
    unseen.SECTION,
    next_experiment.SECTION,
    provenance.SECTION,
)


def write_report(diagnosis: Diagnosis, folder: str | Path) -> Path:
    """Write ``report.html`` into the folder (made if missing), whole or not at all."""
    path = output_folder(Path(folder)) / FILE
    write_whole(path, page(diagnosis))
    return path


def page(diagnosis: Diagnosis) -> str:
    """The page as HTML; every text of the log set is escaped."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader(__name__, ""),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = words.number
    environment.filters["percent"] = words.percent
    environment.filters["interval"] = words.interval
    material = Material(diagnosis)
    bodies = []
    for section in SECTIONS:
        template = environment.get_template(f"{section.key}.html")
        bodies.append((section, template.render(section.context(material))))
    return environment.get_template("page.html").render(
        name=diagnosis.logset.name,
        kind=diagnosis.machine.kind,
        fit=len(diagnosis.logset.fit),
        held_out=len(material.held_out),
        version=diagnosis.provenance.get("gapscope", ""),
        sections=bodies,
    )
