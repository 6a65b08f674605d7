"""The public face: few names, all documented."""

import ast
import inspect
from pathlib import Path

import trajopt

ROOT = Path(__file__).parents[2]
SOURCES = sorted(
    path for folder in ("trajopt", "robots", "problems") for path in (ROOT / folder).rglob("*.py")
)


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


def undocumented(path: Path) -> list[str]:
    """Return the public functions and classes of a file that have no docstring."""
    tree = ast.parse(path.read_text())
    missing = [] if ast.get_docstring(tree) or not tree.body else [f"{path}: the module"]
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    members = [item for owner in classes if not owner.name.startswith("_") for item in owner.body]
    for node in (*tree.body, *members):
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            overloads = isinstance(node, ast.FunctionDef) and any(
                ast.unparse(item) == "overload" for item in node.decorator_list
            )
            if not overloads and not ast.get_docstring(node):
                missing.append(f"{path}: {node.name}")
    return missing


def test_public_functions_are_documented() -> None:
    assert [line for path in SOURCES for line in undocumented(path)] == []


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
