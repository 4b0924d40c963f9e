"""Fuzzing that is guided by what the code under test has run: libFuzzer through ``atheris``.

``cd tests && python -m fuzz.guided TARGET FOLDER SECONDS`` needs the dependency group ``fuzz`` (``pip install
--group fuzz``). Inputs that reach new code stay in FOLDER/corpus/TARGET, so that a second call goes on where the
first ended. What ends in a traceback, crashes, hangs for 10 s or takes more than 2 GB is written to FOLDER as
``crash-...``, ``timeout-...`` or ``oom-...`` and ends the run with an exit code other than zero.
"""

import contextlib
import os
import shutil
import sys
import warnings
from pathlib import Path

from . import targets

# Modules whose branches guide the search: ours, and those in Python that read formats for us.
GUIDES = ("gapscope.analysis.gap", "gapscope.models.yaml_mapping", "mcap", "rosbags", "yaml")
# scipy reads MATLAB files in a process of its own, whose branches are not seen.
GUIDED = tuple(t for t in targets.TARGETS if t not in ("log.mat", "steps", "import", "arguments"))


def main() -> None:
    """Fuzz one target for some seconds."""
    import atheris

    target, folder, seconds = sys.argv[1], Path(sys.argv[2]).resolve(), int(sys.argv[3])
    if target not in GUIDED:
        sys.exit(f"unknown target {target!r}; expected one of {', '.join(GUIDED)}")
    warnings.simplefilter("ignore")  # of libraries that read what is damaged
    seeds, corpus = folder / "seeds", folder / "corpus" / target
    with atheris.instrument_imports(include=list(GUIDES)):
        targets.write_seeds(seeds)
        with contextlib.suppress(targets.input_error()):
            attempt(target, (seeds / target).read_bytes(), seeds, folder)
    corpus.mkdir(parents=True, exist_ok=True)
    shutil.copy(seeds / target, corpus / "seed")
    atheris.Setup(
        [sys.argv[0], str(corpus), f"-max_total_time={seconds}", "-timeout=10", "-rss_limit_mb=2048",
         "-max_len=65536", f"-artifact_prefix={folder}/", "-print_final_stats=1"],
        lambda data: attempt(target, data, seeds, folder),
    )  # fmt: skip
    atheris.Fuzz()


def attempt(target: str, data: bytes, seeds: Path, folder: Path) -> None:
    """One input; it is read, or refused in one InputError."""
    scratch = folder / f"scratch-{os.getpid()}"
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    with contextlib.suppress(targets.input_error()):
        targets.read(target, data, seeds, scratch)


if __name__ == "__main__":
    main()
