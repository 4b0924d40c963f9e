"""ROS 1 bags (.bag) and ROS 2 bags (a folder with metadata.yaml, or its .db3), by rosbags."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from .base import Array, Signals, broken, in_blocks, one_table, optional
from .messages import Message, signals

SUFFIXES = (".bag", ".db3")
FORMAT = "ROS bag"
WANTED = "a ROS 1 or ROS 2 bag"


def read(path: Path) -> list[Signals]:
    """One group of signals per topic."""
    return signals(path, _messages(path))


def blocks(path: Path, names: Sequence[str]) -> Iterator[Array]:
    """Blocks of the columns ``names`` of one topic."""
    return in_blocks(one_table(path, read(path), names), names)


def _messages(path: Path) -> Iterator[Message]:
    reader = optional("rosbags.highlevel", "ros", path)
    types = optional("rosbags.typesys", "ros", path)
    bag = path.parent if path.suffix == ".db3" else path
    # Bags of early ROS 2 releases carry no message definitions; the standard ones have not changed.
    known = types.get_typestore(types.Stores.LATEST)
    try:
        with reader.AnyReader([bag], default_typestore=known) as recording:
            for connection, stamp, data in recording.messages():
                content = recording.deserialize(data, connection.msgtype)
                yield Message(connection.topic, 1e-9 * stamp, content)
    # The reader raises whatever a damaged record leads it to.
    except Exception as error:
        raise broken(path, WANTED, error) from None
