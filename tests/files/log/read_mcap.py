"""Messages of an MCAP log, read by the official reader."""

import json
from pathlib import Path
from typing import Any

import pytest


def read(path: Path) -> dict[str, list[tuple[float, dict[str, Any]]]]:
    """Return the times [s] and messages of each topic, each checked by its schema."""
    pytest.importorskip("mcap")
    from jsonschema import validate
    from mcap.reader import make_reader

    found = dict[str, list[tuple[float, dict[str, Any]]]]()
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema is not None and schema.encoding == "jsonschema"
            assert channel.message_encoding == "json"
            content, described = json.loads(message.data), json.loads(schema.data)
            assert described["title"] == schema.name
            validate(content, {**described, "additionalProperties": False})
            found.setdefault(channel.topic, []).append((message.log_time / 1e9, content))
    return found


def seconds(stamp: dict[str, int]) -> float:
    return stamp["sec"] + 1e-9 * stamp["nsec"]
