"""Single values as members, such as a robot or a scene, without a problem around them."""

import json
from pathlib import Path
from typing import Any

from trajopt.files.bundle.members import Members
from trajopt.files.bundle.reading import document_in, reader_of
from trajopt.files.bundle.to_document import Writer
from trajopt.files.bundle.writing import named_members

VALUE = "value.json"
"""The document of a single value."""


def value_members(value: object, name: str) -> dict[str, bytes]:
    """Return a value as members.

    Args:
        value: The value.
        name: Its name in error messages.

    Raises:
        ModelError: If it contains code of the caller, which a file cannot hold.
        FileFormatError: If a mesh cannot be read.
    """
    writer = Writer()
    document = {"value": writer.document(value, name)}
    return {VALUE: json.dumps(document, allow_nan=False).encode(), **named_members(writer)}


def value_of(members: Members, meshes: Path | str | None = None) -> Any:
    """Return the value stored in members.

    Args:
        members: The members.
        meshes: Folder for unpacking the visual meshes; None leaves them packed.

    Raises:
        FileFormatError: If the members are incomplete or malformed.
    """
    return reader_of(members, meshes).value(document_in(members, VALUE)["value"])
