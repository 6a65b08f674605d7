"""Text and JSON files, read with bounds; errors are typed and name the file.

A file has at most 256 MB and 100 levels. A repeated key is an error.
"""

import json
import os
import re
from collections.abc import Generator
from contextlib import contextmanager, suppress
from math import inf
from pathlib import Path
from secrets import token_hex
from typing import cast

from trajopt.values.errors import FileFormatError, TrajoptError, shown

LARGEST_FILE = 2**28
"""Largest text file [bytes]."""
DEEPEST = 100
_NESTING = re.compile(r"[\[{]|[\]}]|(?:[-?:][ \t]+){100}|\n {1000}")
# YAML 1.1 takes 1e-05 (no point) for a string; writers in other languages mean the number.
_SURROGATE = re.compile(r"[\ud800-\udfff]|\\u[dD][89a-fA-F]")
"""A surrogate, or its escape; only a lone one is refused."""
_EXPONENT = re.compile(r"[-+]?\d+(\.\d*)?[eE][-+]?\d+")


def is_file(path: Path) -> bool:
    """Return whether a file of that name exists; False for impossible names."""
    return os.path.isfile(path)  # Path.is_file raises where a name is too long.


def read_bytes(path: Path | str) -> bytes:
    """Return the content of a file."""
    try:
        with Path(path).open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:  # ValueError: a name with a zero in it
        reason = getattr(error, "strerror", None) or str(error)
        raise FileFormatError(str(path), f"cannot be read: {reason}") from error
    if len(data) > LARGEST_FILE:
        raise FileFormatError(str(path), f"holds more than {LARGEST_FILE >> 20} MB")
    return data


def read_text(path: Path | str) -> str:
    """Return the text of a file without its byte order mark."""
    try:
        return read_bytes(path).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileFormatError(str(path), f"cannot be read: it is not UTF-8 text: {error}") from error


def read_json(path: Path | str) -> object:
    """Parse a JSON file."""
    return parse_json(read_text(path), path)


def parse_json(text: str, path: Path | str) -> object:
    """Parse JSON text of a file, or of a source with a name for messages."""
    refuse_deep_nesting(path, text)

    def mapping(pairs: list[tuple[str, object]]) -> dict[str, object]:
        found: dict[str, object] = {}
        for key, value in pairs:
            if key in found:
                raise FileFormatError(str(path), f"the key {shown(key)} is there twice in one mapping")
            found[key] = value
        return found

    try:
        document = cast("object", json.loads(text, object_pairs_hook=mapping))
        if _SURROGATE.search(text):
            json.dumps(document, ensure_ascii=False).encode()
        return document
    except FileFormatError:
        raise
    except UnicodeEncodeError as error:
        raise FileFormatError(
            str(path), "has a text with a lone surrogate, which UTF-8 cannot encode"
        ) from error
    except (ValueError, RecursionError) as error:
        raise FileFormatError(str(path), f"cannot be parsed: {error}") from error


def number_of(value: object) -> float | None:
    """Return a parsed value as a number, infinite if too large; None if it is not a number."""
    if isinstance(value, str) and _EXPONENT.fullmatch(value):
        return float(value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        return float(value)
    except OverflowError:
        return inf if value > 0 else -inf


def refuse_deep_nesting(path: Path | str, text: str) -> None:
    """Refuse a text, before parsing, that is nested deeper than `DEEPEST` levels."""
    # The C parser of YAML descends by recursion, and ends the process where the stack does.
    depth = 0
    for match in _NESTING.finditer(text):
        mark = match.group()
        depth += 1 if mark in "[{" else -1 if mark in "]}" else DEEPEST
        if depth >= DEEPEST:
            raise FileFormatError(str(path), f"is nested more than {DEEPEST} levels deep")


@contextmanager
def written_whole(path: Path | str, *, durable: bool = False) -> Generator[Path]:
    """Yield the name of a temporary file, which replaces the file if the block succeeds.

    Of simultaneous writers the last to finish wins. Missing folders are created; a failed block leaves
    nothing.

    Args:
        durable: Whether the file survives a power failure; takes some milliseconds.
    """
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise FileFormatError(str(path), "cannot be written: it is a folder or a device")
        target = Path(os.path.realpath(path))
        draft = target.with_name(f".trajopt-{token_hex(8)}")
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield draft
            if durable:
                _to_disk(draft)
            draft.replace(target)
            if durable:
                _to_disk(target.parent)  # which has the name
        finally:
            with suppress(OSError):
                draft.unlink()
    except TrajoptError:
        raise
    except (OSError, ValueError) as error:
        raise FileFormatError(str(path), f"cannot be written: {error}") from error


def _to_disk(path: Path) -> None:
    opened = os.open(path, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)
