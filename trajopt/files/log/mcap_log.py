"""A log in MCAP: messages in JSON, each with its time and its topic."""

import json
from collections.abc import Mapping
from io import BytesIO
from math import isfinite
from pathlib import Path

from trajopt.files.log.schemas import Json, Topic
from trajopt.values.documents.files import written_whole
from trajopt.values.errors import MissingExtra, ProblemError


def stamp(time: float) -> Json:
    """Return a time, not negative, as Foxglove's messages contain it."""
    sec, nsec = divmod(_nanoseconds(time), 1_000_000_000)
    return {"sec": sec, "nsec": nsec}


class McapLog:
    """A log that is written to a file when it is complete; https://mcap.dev describes the format."""

    def __init__(self) -> None:
        try:
            from mcap.writer import Writer
        except ImportError as error:
            raise MissingExtra("mcap", "mcap") from error
        self._bytes, self._channels = BytesIO(), dict[Topic, int]()
        self._writer = Writer(self._bytes)
        self._writer.start(library="trajopt")

    def add(self, topic: Topic, time: float, message: Mapping[str, object]) -> None:
        """Add a message at a time, not negative [s]."""
        at = _nanoseconds(time)
        if topic not in self._channels:
            name, data = str(topic.schema["title"]), json.dumps(topic.schema).encode()
            schema = self._writer.register_schema(name=name, encoding="jsonschema", data=data)
            self._channels[topic] = self._writer.register_channel(
                topic=topic.name, message_encoding="json", schema_id=schema
            )
        data = json.dumps(message, allow_nan=False, separators=(",", ":")).encode()
        self._writer.add_message(self._channels[topic], log_time=at, publish_time=at, data=data)

    def save(self, path: Path | str) -> None:
        """Write the file atomically; nothing can be added afterwards."""
        self._writer.finish()
        with written_whole(path) as draft:
            draft.write_bytes(self._bytes.getvalue())


def _nanoseconds(time: float) -> int:
    if not isfinite(time) or time < 0.0:
        raise ProblemError(f"a time of a log must be finite and not negative, is {time:g} s")
    return round(1e9 * time)
