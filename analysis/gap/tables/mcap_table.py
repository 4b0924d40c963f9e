"""MCAP, by mcap; messages in JSON, ROS 2 (CDR) and Protobuf encoding."""

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from ...errors import InputError
from .base import Array, Signals, broken, in_blocks, one_table, optional
from .messages import Message, signals

SUFFIXES = (".mcap",)
FORMAT = "MCAP"
WANTED = "an MCAP recording"


def read(path: Path) -> list[Signals]:
    """One group of signals per topic."""
    return signals(path, _messages(path))


def blocks(path: Path, names: Sequence[str]) -> Iterator[Array]:
    """Blocks of the columns ``names`` of one topic."""
    return in_blocks(one_table(path, read(path), names), names)


class _Json:
    """Decoder of JSON messages."""

    def decoder_for(self, encoding: str, schema: Any) -> Callable[[bytes], Any] | None:
        return json.loads if encoding == "json" else None


def _messages(path: Path) -> Iterator[Message]:
    reader = optional("mcap.reader", "mcap", path)
    refused: set[str] = set()
    factories = [
        _Json(),
        optional("mcap_ros2.decoder", "mcap", path).DecoderFactory(),
        optional("mcap_protobuf.decoder", "mcap", path).DecoderFactory(),
    ]
    seen = False
    try:
        with open(path, "rb") as stream:
            file = reader.make_reader(stream, validate_crcs=True)
            decoders: dict[int, Callable[[bytes], Any] | None] = {}
            for schema, channel, message in file.iter_messages():
                if channel.id not in decoders:
                    encoding = channel.message_encoding
                    found = (f.decoder_for(encoding, schema) for f in factories)
                    decoders[channel.id] = next((f for f in found if f is not None), None)
                decode = decoders[channel.id]
                if decode is None:
                    refused.add(channel.message_encoding)
                    continue
                seen = True
                yield Message(channel.topic, 1e-9 * message.log_time, decode(message.data))
    # The reader and the decoders raise whatever a damaged record leads them to.
    except Exception as error:
        raise broken(path, WANTED, error) from None
    if not seen and refused:
        raise InputError(
            path, f"messages encoded as {', '.join(sorted(refused))}", "JSON, ROS 2 CDR or Protobuf",
            "Convert the recording, for ROS 1 with `mcap convert`.",
        )  # fmt: skip
