"""Reading a YAML mapping from text that may be damaged or hostile.

Aliases let a few lines stand for billions of nodes; such documents, those that contain themselves and
those nested too deeply to be handled are refused before anything is made of them.
"""

from pathlib import Path
from typing import Any

import yaml

MOST_NODES = 100_000  # of a description written by hand, with its aliases written out


def read_yaml_mapping(path: str | Path) -> dict[str, Any]:
    """The mapping in a YAML file; ValueError, OSError included, names the file and the line."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: not text ({error.reason}); expected UTF-8 YAML") from None
    except (OSError, ValueError) as error:  # a NUL in the name is a ValueError
        reason = getattr(error, "strerror", None) or error
        raise ValueError(f"{path}: {reason}; expected a YAML file") from None
    return yaml_mapping(text, str(path))


def yaml_mapping(
    text: str, where: str, loader: type[yaml.SafeLoader] = yaml.SafeLoader
) -> dict[str, Any]:
    """The mapping in YAML text; ``where`` opens the message of the ValueError."""
    expected = "expected a mapping of keys to values"
    try:
        document = yaml.load(text, Loader=loader)
        nodes = _size(document, {}, frozenset())
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f", line {mark.line + 1}" if mark else ""
        raise ValueError(f"{where}{line}: not valid YAML; {expected}") from None
    except RecursionError:
        raise ValueError(f"{where}: YAML nested too deeply; {expected}") from None
    except (
        ValueError,
        OverflowError,
        TypeError,
        KeyError,
        AttributeError,
    ) as error:  # of a scalar's constructor
        raise ValueError(f"{where}: {' '.join(str(error).split())[:200]}; {expected}") from None
    if nodes > MOST_NODES:
        raise ValueError(f"{where}: {nodes:.3g} values; expected at most {MOST_NODES}")
    if not isinstance(document, dict):
        found = "nothing" if document is None else f"a {type(document).__name__}"
        raise ValueError(f"{where}: {found} instead of keys; {expected}")
    odd = [key for key in document if not isinstance(key, str)]
    if odd:
        raise ValueError(f"{where}: key {str(odd[0])[:60]!r} is no text; expected names as keys")
    return document


def _size(value: Any, known: dict[int, int], above: frozenset[int]) -> int:
    """Nodes of a document with its aliases written out."""
    if not isinstance(value, dict | list | tuple | set):
        return 1
    if id(value) in above:
        raise ValueError("a value contains itself")
    if id(value) not in known:
        inside = [*value.keys(), *value.values()] if isinstance(value, dict) else value
        known[id(value)] = 1 + sum(_size(v, known, above | {id(value)}) for v in inside)
    return known[id(value)]
