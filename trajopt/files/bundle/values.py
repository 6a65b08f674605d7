"""Single values as members: a robot, a scene, whatever a bundle may hold, without a problem around it."""

import json
from pathlib import Path
from typing import Any

from trajopt.files.bundle.members import Members
from trajopt.files.bundle.reading import document_in, reader_of
from trajopt.files.bundle.to_document import Writer
from trajopt.files.bundle.writing import named_members

VALUE = "value.json"
"""The document of a value that is kept by itself."""


def value_members(value: object, name: str) -> dict[str, bytes]:
    """Return a value as members.

    Args:
        value: The value.
        name: What it is called in messages.

    Raises:
        ModelError: If it holds code of the caller's, which no file can hold.
        FileFormatError: If a mesh cannot be read.
    """
    writer = Writer()
    document = {"value": writer.document(value, name)}
    return {VALUE: json.dumps(document, allow_nan=False).encode(), **named_members(writer)}


def value_of(members: Members, meshes: Path | str | None = None) -> Any:
    """Return the value that members make.

    Args:
        members: The members.
        meshes: A folder to unpack the meshes to that a viewer draws; they are left where they are when None.

    Raises:
        FileFormatError: If they do not say what they must.
    """
    return reader_of(members, meshes).value(document_in(members, VALUE)["value"])
