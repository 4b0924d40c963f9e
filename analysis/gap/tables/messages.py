"""Numeric fields of decoded messages, whatever library decoded them, as signals per topic."""

import itertools
from array import array
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...errors import InputError
from .base import WIDEST, Signals

DEEPEST = 8  # messages within messages
STAMP = "stamp"  # column of the sender's own time
LOGGED = "log_time"  # column of the recorder's time


class Message(NamedTuple):
    """A decoded message."""

    topic: str
    time: float  # of the recorder [s]
    content: Any


class _Topic:
    """Columns of one topic, growing; a field that a message lacks is given up."""

    def __init__(self) -> None:
        self.size = 0
        self.columns: dict[str, array[float]] = {}

    def append(self, row: Iterable[tuple[str, float]]) -> None:
        for name, value in row:
            column = self.columns.setdefault(name, array("d"))
            if len(column) == self.size:
                column.append(value)
        self.size += 1


def signals(path: Path, messages: Iterable[Message]) -> list[Signals]:
    """One group per topic: columns ``field.field[i]``, times by the sender's stamp where it has one."""
    topics: dict[str, _Topic] = {}
    for message in messages:
        logged = [(LOGGED, message.time)]
        fields = _fields("", message.content, 0)
        topics.setdefault(message.topic, _Topic()).append(itertools.chain(logged, fields))
    groups = [_group(name, topic) for name, topic in topics.items()]
    groups = [group for group in groups if len(group.columns) > 1]
    if not groups:
        raise InputError(path, "no message with numbers", "topics with numeric fields")
    return sorted(groups, key=lambda group: -group.samples)


def _group(name: str, topic: _Topic) -> Signals:
    """Columns of a topic; fields that not every message has are left out and named."""
    columns = {n: np.array(c) for n, c in topic.columns.items() if len(c) == topic.size}
    dropped = [n for n in topic.columns if n not in columns]
    stamps = [n for n in columns if n.split(".")[-1] == STAMP and np.ptp(columns[n]) > 0.0]
    time = stamps[0] if stamps else LOGGED
    remarks = []
    if time == LOGGED:
        remarks.append("times are those of the recorder: messages carry no stamp of their own")
    if dropped:
        remarks.append(f"left out, not in every message: {', '.join(dropped)[:200]}")
    return Signals(name=name, columns=columns, time=time, remarks=tuple(remarks))


def _fields(prefix: str, value: Any, depth: int) -> Iterator[tuple[str, float]]:
    if isinstance(value, bool | int | float | np.number | np.bool_):
        try:
            yield prefix, float(value)
        except OverflowError:  # an integer that is no measurement
            return
    elif depth > DEEPEST or isinstance(value, str | bytes | None):
        return
    elif isinstance(value, list | tuple | np.ndarray) or _repeated(value):
        for i, item in enumerate(value[: WIDEST + 1] if len(value) <= WIDEST else []):
            yield from _fields(f"{prefix}[{i}]", item, depth + 1)
    else:
        fields = _mapping(value)
        stamp = _seconds(fields)
        if stamp is not None:
            yield prefix, stamp
            return
        labels = _labels(fields)
        for name, item in fields.items():
            inner = f"{prefix}.{name}" if prefix else name
            if labels and isinstance(item, list | tuple | np.ndarray) and len(item) == len(labels):
                for label, element in zip(labels, item):
                    yield from _fields(f"{inner}.{label}", element, depth + 1)
            else:
                yield from _fields(inner, item, depth + 1)


def _labels(fields: Mapping[str, Any]) -> list[str]:
    """Names of the elements of the other fields, as in sensor_msgs/JointState."""
    names = fields.get("name")
    if isinstance(names, list | tuple) and names and all(isinstance(n, str) for n in names):
        return [str(name) for name in names]
    return []


def _seconds(fields: Mapping[str, Any]) -> float | None:
    """A time message as seconds: ROS 1 and 2, protobuf."""
    for whole, fraction in (
        ("sec", "nanosec"),
        ("secs", "nsecs"),
        ("sec", "nsec"),
        ("seconds", "nanos"),
    ):
        if set(fields) == {whole, fraction}:
            parts = fields[whole], fields[fraction]
            if all(isinstance(p, int | float | np.number) for p in parts):
                return float(parts[0]) + 1e-9 * float(parts[1])
    return None


def _mapping(value: Any) -> Mapping[str, Any]:
    if isinstance(value, Mapping):
        return {str(key): item for key, item in value.items()}
    if hasattr(value, "DESCRIPTOR"):  # protobuf
        return {f.name: getattr(value, f.name) for f in value.DESCRIPTOR.fields}
    names = getattr(value, "__slots__", None) or list(getattr(value, "__dict__", {}))
    found = {str(n).lstrip("_"): getattr(value, n, None) for n in names}
    return {n: v for n, v in found.items() if not n.startswith("msgtype")}


def _repeated(value: Any) -> bool:
    """A protobuf repeated field: a sequence that is no list."""
    return hasattr(value, "__getitem__") and hasattr(value, "__len__") and hasattr(value, "append")
