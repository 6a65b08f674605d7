"""YAML files, read with bounds; errors are typed and name the file and the line.

Aliases and merges expand to at most a million values. A repeated key is an error.
"""

from collections.abc import Hashable
from math import inf
from pathlib import Path
from typing import Any, cast

import yaml
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from trajopt.values.documents.files import read_text, refuse_deep_nesting
from trajopt.values.errors import FileFormatError, shown

MOST_ALIASED = 1_000_000
"""Most values that aliases and merges expand to."""

_MERGE = "tag:yaml.org,2002:merge"
_TEXT = "tag:yaml.org,2002:str"
_YAML: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_MALFORMED = (ValueError, ArithmeticError, LookupError, AttributeError, TypeError, RecursionError)
"""Errors of PyYAML's own constructors."""


def read_yaml(path: Path | str) -> list[object]:
    """Parse the non-empty documents of a YAML file."""
    return parse_yaml(read_text(path), path)


def parse_yaml(text: str, path: Path | str) -> list[object]:
    """Parse the non-empty documents of a YAML text."""
    refuse_deep_nesting(path, text)
    try:
        loader = _Loader(text)
        try:
            documents: list[object] = []
            while loader.check_data():
                documents.append(cast("object", loader.get_data()))
        finally:
            loader.dispose()
        standing_for = _aliased(documents) if "*" in text else 0.0
    except (*_MALFORMED, yaml.YAMLError) as error:
        raise FileFormatError(str(path), f"cannot be parsed: {_sentence(error)}") from error
    if standing_for > MOST_ALIASED:
        raise FileFormatError(str(path), f"its aliases stand for more than {MOST_ALIASED} values")
    return [document for document in documents if document is not None]


class _Loader(_YAML):
    merged = 0

    def construct_mapping(self, node: MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        lines: dict[Hashable, int] = {}
        for name, _ in node.value:
            if name.tag == _MERGE or not isinstance(name, ScalarNode):
                continue
            name.tag = _TEXT  # a joint named 3 or off is not the number or the truth value
            key: Any = self.construct_object(name, deep=deep)
            if key in lines:
                raise yaml.constructor.ConstructorError(
                    None, None, f"the key {shown(key)} is there twice in one mapping, first in line "
                    f"{lines[key]}", name.start_mark,
                )  # fmt: skip
            lines[key] = name.start_mark.line + 1
        return cast("dict[Hashable, Any]", super().construct_mapping(node, deep=deep))  # pyright: ignore

    def flatten_mapping(self, node: MappingNode) -> None:
        own = [pair for pair in node.value if pair[0].tag != _MERGE]
        if len(own) == len(node.value):
            return
        taken = {_key(name) for name, _ in own}
        merged: dict[object, tuple[Node, Node]] = {}
        for name, value in node.value:
            if name.tag != _MERGE:
                continue
            for part in value.value if isinstance(value, SequenceNode) else (value,):
                if not isinstance(part, MappingNode):
                    raise yaml.constructor.ConstructorError(
                        None, None, "only mappings can be merged", part.start_mark
                    )
                self.flatten_mapping(part)
                self.merged += len(part.value)
                if self.merged > MOST_ALIASED:
                    raise yaml.constructor.ConstructorError(
                        None, None, f"merges more than {MOST_ALIASED} values", name.start_mark
                    )
                for key, inner in part.value:
                    if _key(key) not in taken:
                        merged.setdefault(_key(key), (key, inner))
        node.value = [*merged.values(), *own]


def _key(node: Node) -> object:
    return (node.tag, node.value) if isinstance(node, ScalarNode) else id(node)


def _sentence(error: Exception) -> str:
    if not isinstance(error, yaml.MarkedYAMLError):
        return str(error).replace('\n  in "<unicode string>",', " at")
    mark = error.problem_mark or error.context_mark
    said = ", ".join(part for part in (error.context, error.problem) if part)
    return said if mark is None else f"line {mark.line + 1}, column {mark.column + 1}: {said}"


def _aliased(documents: list[object]) -> float:
    sizes: dict[int, float] = {}
    written = 0

    def size(value: object) -> float:
        nonlocal written
        if not isinstance(value, dict | list):
            return 1.0
        key = id(cast("object", value))
        if key not in sizes:
            sizes[key] = inf  # while it is counted
            container = cast("dict[object, object] | list[object]", value)
            inner = list(container.values()) if isinstance(container, dict) else container
            written += 1 + sum(not isinstance(item, dict | list) for item in inner)
            sizes[key] = 1.0 + sum(size(item) for item in inner)
        return sizes[key]

    return sum(size(document) for document in documents) - written
