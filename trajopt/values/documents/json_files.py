"""Documents as JSON files."""

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import cast

from trajopt.values.documents.document import write_text
from trajopt.values.errors import FileFormatError, shown


def write_json(path: Path | str, document: Mapping[str, object], *, indent: int | None = 1) -> None:
    """Write a document as JSON atomically; numbers are written exactly.

    Args:
        path: The file.
        document: The content.
        indent: Spaces for each level; None for one line.

    Raises:
        FileFormatError: If it contains a value that JSON does not have (such as NaN), or cannot be written.
    """
    _check(document, str(path), "")
    write_text(path, json.dumps(document, indent=indent, allow_nan=False) + "\n")


def _check(value: object, path: str, place: str) -> None:
    match value:
        case dict():
            for key, inner in cast("dict[object, object]", value).items():
                if not isinstance(key, str):
                    raise FileFormatError(path, f"{place}: the key {shown(key)} is not text")
                _check(inner, path, f"{place}.{key}" if place else key)
        case list() | tuple():
            for i, inner in enumerate(cast("Sequence[object]", value)):
                _check(inner, path, f"{place}[{i}]")
        case float() if not isfinite(value):
            raise FileFormatError(path, f"{place}: {value} is not a number that JSON can hold")
        case None | bool() | int() | float() | str():
            pass
        case _:
            raise FileFormatError(path, f"{place}: JSON cannot hold a {type(value).__name__}")
