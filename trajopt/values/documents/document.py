"""Documents read value by value: each error names the file and the place in it."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from difflib import get_close_matches
from math import isfinite, isnan
from pathlib import Path
from typing import cast

from trajopt.values.documents.files import number_of, parse_json, read_text, written_whole
from trajopt.values.errors import FileFormatError, shown


@dataclass(frozen=True)
class Node:
    """One value of a document, and its place.

    Attributes:
        value: The parsed value; None if missing.
        place: The path to it from the top, such as `world.collision_objects[3].pose`.
    """

    value: object
    path: str
    place: str = ""

    def error(self, reason: str) -> FileFormatError:
        return FileFormatError(self.path, f"{self.place}: {reason}" if self.place else reason)

    @property
    def missing(self) -> bool:
        """Whether the document has no value here."""
        return self.value is None

    def __getitem__(self, key: str) -> "Node":
        return Node(self._mapping().get(key), self.path, f"{self.place}.{key}" if self.place else key)

    def only(self, fields: Iterable[str]) -> "Node":
        """Return this mapping after checking that it has no other members than the given ones."""
        known = sorted(fields)
        for key in self._mapping():
            if key not in known:
                near = get_close_matches(shown(key), known, n=1)
                hint = f"; did you mean {shown(near[0])}?" if near else f"; known: {', '.join(known)}"
                raise self.error(f"unknown key {shown(key)}{hint}")
        return self

    def keys(self) -> tuple[str, ...]:
        """Return the names of this mapping's members; empty if missing."""
        return tuple(str(key) for key in self._mapping())

    def has_only(self, fields: Iterable[str]) -> bool:
        """Return whether this mapping has no other members than the given ones."""
        return self._mapping().keys() <= set(fields)

    def has(self, key: str) -> bool:
        """Return whether this is a mapping with a value under that key."""
        return isinstance(self.value, dict) and self._mapping().get(key) is not None

    def elements(self) -> list["Node"]:
        """Return the elements of a list; empty if missing."""
        if self.value is None:
            return []
        value = self.value
        if not isinstance(value, list):
            raise self.error(f"must be a list, is {_say(value)}")
        values = cast("list[object]", value)
        return [Node(inner, self.path, f"{self.place}[{i}]") for i, inner in enumerate(values)]

    def members(self) -> dict[str, "Node"]:
        """Return the members of a mapping by name; empty if missing."""
        return {str(key): self[str(key)] for key in self._mapping()}

    def text(self, default: str | None = None) -> str:
        """Return a string; the default, if there is one, if it is missing."""
        if self.value is None and default is not None:
            return default
        if not isinstance(self.value, str):
            bare = isinstance(self.value, bool | int | float | date) and not self.path.endswith(".json")
            hint = " (YAML reads it so unless it is quoted)" if bare else ""
            raise self.error(f"must be text, is {_say(self.value)}{hint}")
        return self.value

    def number(self, default: float | None = None, *, infinite: bool = False) -> float:
        """Return a number, perhaps an infinite one; the default, if there is one, if it is missing."""
        value = default if self.value is None else self.value
        result = number_of(value)
        if result is None:
            raise self.error(f"must be a number, is {_say(value)}")
        if isnan(result) or not (infinite or isfinite(result)):
            raise self.error(f"must be finite, is {result}")
        return result

    def numbers(self) -> tuple[float, ...]:
        """Return a list of finite numbers; empty if missing."""
        return tuple(element.number() for element in self.elements())

    def flag(self) -> bool:
        """Return a truth value (0 and 1 count); False if missing."""
        if self.value is None:
            return False
        if self.value not in (False, True):
            raise self.error(f"must be true or false, is {_say(self.value)}")
        return bool(self.value)

    def _mapping(self) -> dict[object, object]:
        value = self.value
        if value is None:
            return {}
        if not isinstance(value, dict):
            raise self.error(f"must be a mapping, is {_say(value)}")
        return cast("dict[object, object]", value)


def read_document(path: Path | str) -> Node:
    """Parse the one mapping of a file: JSON if its suffix is .json, YAML otherwise."""
    return parse_document(read_text(path), path)


def parse_document(text: str, path: Path | str) -> Node:
    """Parse the text of a file, as `read_document` does."""
    return _the_only(text, path, dict, "one mapping (key: value)")


def read_list(path: Path | str) -> Node:
    """Parse a file that contains a list, as `read_document` parses a mapping."""
    return parse_list(read_text(path), path)


def parse_list(text: str, path: Path | str) -> Node:
    """Parse a text that contains a list, as `parse_document` parses a mapping."""
    return _the_only(text, path, list, "one list (- item)")


def _the_only(text: str, path: Path | str, kind: type[object], words: str) -> Node:
    from trajopt.values.documents.yaml_files import parse_yaml  # slow to import

    documents = [parse_json(text, path)] if Path(path).suffix == ".json" else parse_yaml(text, path)
    if len(documents) != 1 or not isinstance(documents[0], kind):
        raise FileFormatError(str(path), f"must hold {words}")
    return Node(documents[0], str(path))


def write_text(path: Path | str, text: str) -> None:
    """Write a file atomically: a reader finds the old or the new content. Missing folders are created."""
    with written_whole(path) as draft:
        draft.write_text(text, encoding="utf-8")


def _say(value: object) -> str:
    return "missing" if value is None else shown(value)


def write_json(path: Path | str, document: Mapping[str, object], *, indent: int | None = 1) -> None:
    """Write a document as JSON atomically, exactly; None indents nothing."""
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
