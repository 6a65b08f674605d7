"""Reading a proof file: only values of the stated kind and size are accepted."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn, TypeAlias, cast

import numpy as np
from intervals import Floats, Interval

LARGEST_FILE = 64 * 2**20
LONGEST_TEXT = 1000
MOST = 1_000_000
"""Most entries of any list."""
LARGEST = 1e12
"""Largest number: products of a few do not overflow."""

Fields: TypeAlias = Mapping[str, object]
Reader: TypeAlias = Callable[[str, object], Any]
"""Takes a value of JSON, with words for its place, and returns it as it is used."""


class Malformed(Exception):
    """The file is not a proof of this format; the message is a sentence."""


def demand(fits: bool | np.bool_, sentence: str) -> None:
    if not fits:
        raise Malformed(sentence)


def open_file(path: Path) -> tuple[Fields, bytes]:
    """Return the statement of a file and the bytes of its witness, once hash and lengths fit."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise Malformed(f"{path} cannot be read: {error.strerror}") from error
    demand(len(data) <= LARGEST_FILE, f"{path} is longer than {LARGEST_FILE} bytes")
    head = re.match(rb"proof/1 ([0-9]{1,9})\n", data)
    if head is None:
        raise Malformed(f"{path} does not begin with the line 'proof/1 <bytes of the statement>'")
    body, length = data[head.end() :], int(head[1])
    statement, digest, witness = body[:length], body[length : length + 32], body[length + 32 :]
    fits = len(statement) == length and digest == hashlib.sha256(statement).digest()
    demand(fits, "the witness is not of this statement: the SHA-256 differs")
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


def that(fits: Callable[[Any], bool], words: str, form: Callable[[Any], Any] = lambda value: value) -> Reader:
    """Return a reader of values that fit, and that it returns in some form."""

    def read(where: str, value: object) -> Any:
        if not fits(value):
            raise Malformed(f"{where} must be {words}")
        return form(value)

    return read


mapping = that(lambda value: isinstance(value, dict), "an object")
flag = that(lambda value: isinstance(value, bool), "true or false")
text = that(
    lambda value: isinstance(value, str) and len(value) <= LONGEST_TEXT and value.isprintable(),
    f"a printable text of at most {LONGEST_TEXT} characters",
)


def between(least: float, most: float) -> Reader:
    return that(
        lambda value: type(value) in (int, float) and least <= value <= most,
        f"a number from {least:g} to {most:g}",
        float,
    )


number, size = between(-LARGEST, LARGEST), between(0.0, LARGEST)


def items(most: int = MOST) -> Reader:
    def fits(value: object) -> bool:
        return isinstance(value, list) and len(cast("list[object]", value)) <= most

    return that(fits, f"a list of at most {most} entries")


def below(most: int) -> Reader:
    return that(
        lambda value: type(value) is int and 0 <= value < most, f"a whole number from 0 to below {most}"
    )


def one_of(kinds: Mapping[str, object]) -> Reader:
    """Return a reader of some names."""
    return that(lambda value: isinstance(value, str) and value in kinds, f"one of {', '.join(kinds)}")


def record(where: str, value: object, readers: Mapping[str, Reader]) -> list[Any]:
    found = mapping(where, value)
    demand(set(found) == set(readers), f"{where} must have the fields {', '.join(readers)}")
    return [read(f"{name} of {where}", found[name]) for name, read in readers.items()]


def row(*readers: Reader) -> Reader:
    def read(where: str, value: object) -> list[Any]:
        entries = items()(where, value)
        demand(len(entries) == len(readers), f"{where} must have {len(readers)} entries")
        return [take(where, entry) for take, entry in zip(readers, entries, strict=True)]

    return read


def every(read: Reader, most: int = MOST) -> Reader:
    return lambda where, value: [
        read(f"entry {at} of {where}", entry) for at, entry in enumerate(items(most)(where, value))
    ]


def unless_null(read: Reader, none: float) -> Reader:
    return lambda where, value: none if value is None else read(where, value)


least, most = unless_null(number, -np.inf), unless_null(number, np.inf)


def numbers(*shape: int | None) -> Reader:
    """Return a reader of nested lists of numbers of a shape; None stands for any length but zero."""
    nested = number
    for length in reversed(shape):
        nested = every(nested) if length is None else row(*[nested] * length)

    def read(where: str, value: object) -> Floats:
        try:
            found = np.array(nested(where, value), dtype=np.float64)
        except ValueError as error:
            raise Malformed(f"{where} must have rows of equal length") from error
        demand(found.size > 0, f"{where} must not be empty")
        return found

    return read


def direction(count: int, normal_form: Callable[[Floats], Interval]) -> Reader:
    """Return a reader of vectors that are to be normalised: their largest number must be near 1."""

    def read(where: str, value: object) -> Interval:
        found = numbers(count)(where, value)
        demand(0.5 <= np.abs(found).max() <= 2.0, f"{where} must have a largest number near 1")
        return normal_form(found)

    return read
