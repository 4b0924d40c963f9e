"""Typed settings from YAML by Drake's ``yaml_load_typed``, with one kind of error."""

import re
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydrake.common.yaml import yaml_load_typed

from ..models.yaml_mapping import yaml_mapping

T = TypeVar("T")


def load_typed(text: str, defaults: T, known: str) -> T:
    """Settings of the type of ``defaults``; a key left out keeps its value.

    Raises ValueError for text that is not YAML, an unknown key (``known`` lists those there are) or tag, or a
    value of another type.
    """
    if text.strip():
        _refuse_unreadable(text)
    try:
        found: T = yaml_load_typed(schema=type(defaults), data=text, defaults=defaults)
    except yaml.YAMLError as error:  # a tag whose value is of another shape
        raise ValueError(f"not usable YAML ({' '.join(str(error).split())[:200]})") from None
    except (AssertionError, AttributeError) as error:
        raise ValueError(f"found {error} where keys with values are expected") from None
    except (RuntimeError, ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
        unknown = re.match(r"The fields \['?([^']*)'?.*\] were unknown", str(error))
        if unknown:
            raise ValueError(f"unknown key {unknown[1]!r}; expected {known}") from None
        raise ValueError(" ".join(str(error).split())) from None
    return found


def read_text(path: str | Path) -> str:
    """UTF-8 text of a file; ValueError where there is none."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ValueError(f"{path}: {reason}; expected a YAML file") from None


class _Tagged(yaml.SafeLoader):
    """Takes the tags that choose among types as what follows them."""


def _untagged(loader: yaml.SafeLoader, suffix: str, node: yaml.Node) -> Any:
    if isinstance(node, yaml.MappingNode):
        return loader.construct_mapping(node, deep=True)
    if isinstance(node, yaml.SequenceNode):
        return loader.construct_sequence(node, deep=True)
    return loader.construct_scalar(node)


_Tagged.add_multi_constructor("!", _untagged)


def _refuse_unreadable(text: str) -> None:
    """Refuse what is not YAML, or stands for more than it says."""
    yaml_mapping(text, "settings", loader=_Tagged)
