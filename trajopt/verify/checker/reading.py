"""Reading a proof file: only values of the stated kind and size are accepted."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn, TypeAlias, cast

import numpy as np
from intervals import Floats

FORMAT = b"proof/1"
LARGEST_FILE = 64 * 2**20
"""More bytes are not read."""
LONGEST_HEAD = 100
MOST = 100_000
"""Most entries of any list."""
LARGEST = 1e12
"""Largest number: products of a few do not overflow."""

Fields: TypeAlias = Mapping[str, object]
Reader: TypeAlias = Callable[[str, object], Any]
"""Takes a value of JSON, with words for its place, and returns it as it is used."""


class Malformed(Exception):
    """The file is not a proof of this format; the message is a sentence."""


def open_file(path: Path) -> tuple[Fields, bytes]:
    """Return the statement of a file and the bytes of its witness, once hash and lengths fit."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise Malformed(f"{path} cannot be read: {error.strerror}") from error
    if len(data) > LARGEST_FILE:
        raise Malformed(f"{path} is longer than {LARGEST_FILE} bytes")
    head, found, _ = data[:LONGEST_HEAD].partition(b"\n")
    words = head.split(b" ")
    if not found or len(words) != 2 or words[0] != FORMAT or not words[1].isdigit():
        raise Malformed(f"{path} does not begin with the line 'proof/1 <bytes of the statement>'")
    body, length = data[len(head) + 1 :], int(words[1])
    statement, digest, witness = body[:length], body[length : length + 32], body[length + 32 :]
    if len(statement) < length or digest != hashlib.sha256(statement).digest():
        raise Malformed("the witness is not of this statement: the SHA-256 differs")
    try:
        found = json.loads(statement, parse_constant=_refused, object_pairs_hook=_unique)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"the statement is not JSON: {error}") from error
    return mapping("statement", found), witness


def _refused(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number")


def _unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name is given twice")
    return found


def mapping(where: str, value: object) -> Fields:
    """Take an object of JSON."""
    if not isinstance(value, dict):
        raise Malformed(f"{where} must be an object")
    return cast("Fields", value)


def record(where: str, value: object, readers: Mapping[str, Reader]) -> list[Any]:
    """Take the values of an object with exactly the fields of some readers, in their order."""
    found = mapping(where, value)
    if set(found) != set(readers):
        raise Malformed(f"{where} must have the fields {', '.join(readers)}")
    return [read(f"{name} of {where}", found[name]) for name, read in readers.items()]


def row(*readers: Reader) -> Reader:
    def read(where: str, value: object) -> list[Any]:
        entries = items(where, value)
        if len(entries) != len(readers):
            raise Malformed(f"{where} must have {len(readers)} entries")
        return [take(where, entry) for take, entry in zip(readers, entries, strict=True)]

    return read


def every(read: Reader, most: int = MOST) -> Reader:
    return lambda where, value: [
        read(f"entry {at} of {where}", entry) for at, entry in enumerate(items(where, value, most))
    ]


def items(where: str, value: object, most: int = MOST) -> list[object]:
    if not isinstance(value, list) or len(cast("list[object]", value)) > most:
        raise Malformed(f"{where} must be a list of at most {most} entries")
    return cast("list[object]", value)


def text(where: str, value: object) -> str:
    if not isinstance(value, str) or len(value) > 1000 or not value.isprintable():
        raise Malformed(f"{where} must be a printable text of at most 1000 characters")
    return value


def flag(where: str, value: object) -> bool:
    if not isinstance(value, bool):
        raise Malformed(f"{where} must be true or false")
    return value


def below(most: int) -> Reader:
    """Return a reader of whole numbers from 0 to below a bound."""

    def read(where: str, value: object) -> int:
        if type(value) is not int or not 0 <= value < most:
            raise Malformed(f"{where} must be a whole number from 0 to below {most}")
        return value

    return read


def number(where: str, value: object) -> float:
    """Take a finite double."""
    if type(value) not in (int, float) or not abs(cast("float", value)) <= LARGEST:
        raise Malformed(f"{where} must be a number of at most {LARGEST:g}")
    return float(cast("float", value))


def size(where: str, value: object) -> float:
    """Take a number that is not negative."""
    if (found := number(where, value)) < 0.0:
        raise Malformed(f"{where} must not be negative")
    return found


def unless_null(read: Reader, none: float) -> Reader:
    return lambda where, value: none if value is None else read(where, value)


def numbers(*shape: int | None) -> Reader:
    """Return a reader of nested lists of numbers of a shape; None stands for any length but zero."""

    def nested(where: str, value: object, depth: int) -> object:
        if depth == len(shape):
            return number(where, value)
        rows = items(where, value)
        if not rows or shape[depth] not in (None, len(rows)):
            raise Malformed(f"{where} must have the shape {shape}")
        return [nested(where, each, depth + 1) for each in rows]

    def read(where: str, value: object) -> Floats:
        try:
            return np.array(nested(where, value, 0), dtype=np.float64)
        except ValueError as error:
            raise Malformed(f"{where} must have rows of equal length") from error

    return read


def direction(count: int) -> Reader:
    """Return a reader of vectors that are to be normalised: their largest number must be near 1."""

    def read(where: str, value: object) -> Floats:
        found = numbers(count)(where, value)
        if not 0.5 <= np.abs(found).max() <= 2.0:
            raise Malformed(f"{where} must have a largest number near 1")
        return found

    return read


def one_of(where: str, value: object, kinds: Mapping[str, object]) -> str:
    """Take one of some names."""
    if not isinstance(value, str) or value not in kinds:
        raise Malformed(f"{where} must be one of {', '.join(kinds)}")
    return value
