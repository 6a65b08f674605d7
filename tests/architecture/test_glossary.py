"""One word for each concept: public names do without the words that docs/glossary.md lists at its end."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from tests.architecture.import_graph import PACKAGE, ROOT, modules

GLOSSARY = ROOT / "docs" / "glossary.md"
HEADING = "## Words that names do without"
PARTS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")

KEPT = {
    "simulate_handling": "in the README since the first version",
}
"""Public names that keep such a word, and why."""


def words() -> set[str]:
    """The words of the glossary's last table."""
    _, _, table = GLOSSARY.read_text().partition(HEADING)
    rows = re.findall(r"^\| (`.+?) \|", table, re.MULTILINE)
    return {word for row in rows for word in re.findall(r"`(\w+)`", row)}


def public(name: str) -> bool:
    return not name.startswith("_") or (name.startswith("__") and name.endswith("__"))


def names(tree: ast.Module) -> Iterator[str]:
    """Public classes, functions, parameters, attributes and constants of a module."""
    for node in tree.body:
        yield from names_of(node)


def names_of(node: ast.stmt) -> Iterator[str]:
    match node:
        case ast.ClassDef(name=name) if public(name):
            yield name
            for item in node.body:
                yield from names_of(item)
        case ast.FunctionDef(name=name, args=args) if public(name):
            yield name
            every = (*args.posonlyargs, *args.args, *args.kwonlyargs, args.vararg, args.kwarg)
            yield from (argument.arg for argument in every if argument is not None and public(argument.arg))
            yield from attributes(node)
        case ast.Assign(targets=targets):
            yield from (each.id for each in targets if isinstance(each, ast.Name) and public(each.id))
        case ast.AnnAssign(target=ast.Name(id=name)) if public(name):
            yield name
        case _:
            pass


def attributes(function: ast.FunctionDef) -> Iterator[str]:
    """Attributes that a method gives to its object."""
    for node in ast.walk(function):
        match node:
            case ast.Attribute(value=ast.Name(id="self"), attr=name, ctx=ast.Store()) if public(name):
                yield name
            case _:
                pass


def unwanted(name: str, banned: set[str]) -> bool:
    return any(part.lower() in banned for part in PARTS.findall(name))


def test_the_glossary_lists_some() -> None:
    assert {"berth", "glance", "guess", "own", "straying"} <= words()


def files() -> list[Path]:
    return [path for name, path in modules().items() if not any(p.startswith("_") for p in name.split("."))]


def test_public_names_do_without_them() -> None:
    banned = words()
    found: list[str] = []
    for path in files():
        stem = path.parent.name if path.name == "__init__.py" else path.stem
        every = {stem, *names(ast.parse(path.read_text()))} - set(KEPT)
        found += [f"{path.relative_to(PACKAGE)}: {name}" for name in sorted(every) if unwanted(name, banned)]
    assert found == []


def test_what_is_kept_exists_and_has_a_reason() -> None:
    every = {name for path in files() for name in names(ast.parse(path.read_text()))}
    assert set(KEPT) <= every and all(KEPT.values())


def test_such_names_are_seen() -> None:
    source = """
class NoGuess:
    berth: float
    def meter(self, first_guess, *, told=1):
        self.straying = 1
        self._own = 2
def _own(): ...
WALLED_IN = 1
ownership = 2
"""
    found = {name for name in names(ast.parse(source)) if unwanted(name, words())}
    assert found == {"NoGuess", "berth", "meter", "first_guess", "told", "straying", "WALLED_IN"}
