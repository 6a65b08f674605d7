"""The public face: few names, all documented."""

import ast
import inspect
from collections.abc import Iterator, Mapping
from pathlib import Path

import trajopt

ROOT = Path(__file__).parents[2]
SOURCES = sorted(
    path for folder in ("trajopt", "robots", "problems") for path in (ROOT / folder).rglob("*.py")
)

SMALL = 10
"""Lines of a function from which it needs a docstring, wherever it is used."""


def public_names() -> list[str]:
    return [
        name
        for name in dir(trajopt)
        if not name.startswith("_") and not inspect.ismodule(getattr(trajopt, name))
    ]


def test_names_are_few() -> None:
    assert len(public_names()) <= 66


def test_public_names_are_documented() -> None:
    values = {name: getattr(trajopt, name) for name in public_names()}
    documented = {name for name, value in values.items() if (getattr(value, "__doc__", "") or "").strip()}
    described = {
        name for name, value in values.items() if inspect.isclass(value) or inspect.isfunction(value)
    }
    assert described - documented == set()


def room_of(path: Path) -> str:
    """Return the part of the repository that a file belongs to: a folder of `trajopt/`, or its top folder."""
    parts = path.relative_to(ROOT).parts
    return "/".join(parts[:2]) if parts[0] == "trajopt" and len(parts) > 2 else parts[0]


def imported(tree: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the module and the name of each import from trajopt."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("trajopt"):
            yield from ((node.module or "", item.name) for item in node.names)


def shared_names(trees: dict[Path, ast.Module]) -> set[str]:
    """Return the names that packages export, and those that other rooms import."""
    return {
        name
        for path, tree in trees.items()
        for module, name in imported(tree)
        if path.name == "__init__.py" or "/".join(module.split(".")[:2]) != room_of(path)
    }


def is_protocol(owner: ast.ClassDef) -> bool:
    return any("Protocol" in ast.unparse(base) for base in owner.bases)


def needs_docstring(node: ast.FunctionDef, owner: ast.ClassDef | None, shared: set[str]) -> bool:
    """Small functions that one room uses alone may do without."""
    if any(ast.unparse(item) == "overload" for item in node.decorator_list):
        return False
    public = node.name in shared if owner is None else owner.name in shared or is_protocol(owner)
    last = node.body[-1].end_lineno or 0
    return public or last - node.body[0].lineno >= SMALL


def bases_of(owner: ast.ClassDef) -> list[str]:
    return [ast.unparse(base).split("[")[0] for base in owner.bases]


def documented_methods(owner: ast.ClassDef, owners: Mapping[str, ast.ClassDef]) -> set[str]:
    """Return the names of the methods with a docstring, of a class or of its bases."""
    own = {node.name for node in owner.body if isinstance(node, ast.FunctionDef) and ast.get_docstring(node)}
    return own.union(
        *(documented_methods(owners[name], owners) for name in bases_of(owner) if name in owners)
    )


def undocumented(
    path: Path,
    tree: ast.Module,
    shared: set[str],
    described: set[str],
    inherited: Mapping[str, set[str]] = {},
) -> Iterator[str]:
    """Yield the modules, classes and functions of a file that need a docstring and have none.

    A method that implements a protocol is described there; `help` shows the docstring of the overridden one.
    """
    if tree.body and not ast.get_docstring(tree):
        yield f"{path}: the module"
    owners = [node for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
    yield from (f"{path}: {owner.name}" for owner in owners if not ast.get_docstring(owner))
    functions = [(None, node) for node in tree.body]
    methods = [(owner, node) for owner in owners for node in owner.body]
    for owner, node in (*functions, *methods):
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            bases = bases_of(owner) if owner is not None else []
            overrides = any(node.name in inherited.get(base, ()) for base in bases)
            implements = owner is not None and node.name in described and not is_protocol(owner)
            needed = needs_docstring(node, owner, shared) and not implements and not overrides
            if needed and not ast.get_docstring(node):
                yield f"{path}: {node.name}"


def test_public_functions_are_documented() -> None:
    trees = {path: ast.parse(path.read_text()) for path in SOURCES}
    shared = shared_names(trees) | set(public_names())
    classes = [node for tree in trees.values() for node in tree.body if isinstance(node, ast.ClassDef)]
    owners = {owner.name: owner for owner in classes}
    inherited = {name: documented_methods(owner, owners) for name, owner in owners.items()}
    described = {name for owner in classes if is_protocol(owner) for name in inherited[owner.name]}
    missing = [
        line
        for path, tree in trees.items()
        for line in undocumented(path, tree, shared, described, inherited)
    ]
    assert missing == []


def test_shared_functions_and_long_ones_need_docstrings() -> None:
    """The rule itself, on a module of three functions without docstrings."""
    functions = {"shared": 1, "small": 1, "long": SMALL + 1}
    lines = (f"def {name}():\n" + "    x = 1\n" * count for name, count in functions.items())
    tree = ast.parse('"""A module."""\n' + "".join(lines))
    found = list(undocumented(ROOT / "module.py", tree, {"shared"}, set()))
    assert [line.rpartition(" ")[2] for line in found] == ["shared", "long"]


def signatures(name: str) -> list[str]:
    """Return the signatures of a public name and its methods, as `help` shows them."""
    value = getattr(trajopt, name)
    members = [value] if not inspect.isclass(value) else [value, *vars(value).values()]
    return [
        str(inspect.signature(member))
        for member in (getattr(each, "__func__", each) for each in members)
        if inspect.isfunction(member) or (inspect.isclass(member) and not issubclass(member, Exception))
    ]


def test_signatures_can_be_read() -> None:
    """`help` shows the names of what is taken, not what numpy makes of them."""
    shown = {name: signatures(name) for name in public_names()}
    long = {name: s for name, many in shown.items() for s in many if "numpy._typing" in s or len(s) >= 1000}
    assert long == {}
