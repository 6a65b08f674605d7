"""A module imports downward only: the layers of the package, read from its imports."""

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.architecture.import_graph import CONVENIENCES, conveniences

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "trajopt"

ORDER = (
    ("values",),
    ("native",),
    ("robot",),
    ("scene", "timing"),
    ("geometry", "simulation"),
    ("problem",),
    ("verify",),
    ("optimise",),
    ("planning",),
    ("files", "tasks", "why"),
    ("driving", "lab"),
    ("server",),
    ("ros", "viewer"),
    ("cli",),
    ("__main__",),
)
"""The rooms of the package, from the lowest layer to the highest: a room imports from lower layers only."""

LAYERS = {room: layer for layer, rooms in enumerate(ORDER) for room in rooms}

FORBIDDEN = {
    "optimise.solvers": {
        *("robot", "scene", "geometry", "problem", "verify"),
        *("optimise.terms", "optimise.transcription", "optimise.methods", "optimise.kinematics"),
    },
    "optimise.terms": {"optimise.solvers", "optimise.transcription", "optimise.methods"},
    "optimise.nlp": {"robot", "scene", "geometry", "problem"},
    "timing": {"scene", "geometry", "problem", "optimise", "verify"},
    "verify": {"geometry", "timing", "problem.problem", "problem.residual", "problem.motion"},
}
"""Part of the package -> the parts that it may not import although its layer would allow it."""

ONLY_IN: dict[str, set[str]] = {
    "mujoco": {"robot"},
    "viser": {"viewer"},
    "matplotlib": {"viewer"},
    "typer": {"cli"},
    "rich": {"cli", "planning"},
    "casadi": {"optimise"},
    "ompl": set(),
    "placo": {"optimise"},
    "pygame": {"driving"},
    "toppra": set(),
    "sqlite3": {"server"},
    "httpx": {"server"},
    "msgspec": {"server", "ros"},
    "fastapi": {"server"},
    "uvicorn": {"server"},
    "prometheus_client": {"server"},
    "pyarrow": {"lab"},
    "ray": {"lab"},
}
"""Packages that only some rooms may import."""

CORES = {
    "proximity": {"geometry"},
    "banded": {"optimise.solvers"},
    "descent": {"optimise.solvers", "optimise.transcription"},
    "timing": {"timing"},
    "servo": {"driving"},
    "proof": {"verify"},
    "checker": {"files.proof"},
    "covers": {"robot"},
}
"""Native cores and the rooms that may call each: what is judged shares no code with the judge. Of a descent
one room knows the steps, and no robot, and another which frames its program is about."""


def modules() -> list[Path]:
    return sorted(
        path for path in PACKAGE.rglob("*.py") if path.name != "__init__.py" or path.parent != PACKAGE
    )


def room(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imports(path: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide where things come from"
            found.add(node.module or "")
            if node.module in {"trajopt", "trajopt.native"}:
                found.update(f"{node.module}.{alias.name}" for alias in node.names)
    return found


def within(module: str, parts: set[str]) -> bool:
    """Whether a module is one of some parts of the package, or inside one; both named without `trajopt.`."""
    return any(module == part or module.startswith(f"{part}.") for part in parts)


def violations(path: Path) -> Iterator[str]:
    """Yield the imports of a file that its place may not have."""
    mine = room(path)
    here = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
    forbidden = {part for place, parts in FORBIDDEN.items() if within(here, {place}) for part in parts}
    for name in imports(path) - set(conveniences(here)):
        parts = name.split(".")
        if parts[0] == "trajopt" and len(parts) > 1:
            other = parts[1]
            if other not in LAYERS:
                yield f"{path}: {name} is in a room without a layer"
            elif other != mine and LAYERS[other] >= LAYERS[mine]:
                yield f"{path}: imports upward: {name}"
            elif within(".".join(parts[1:]), forbidden):
                yield f"{path}: may not import {name}"
            core = parts[2] if other == "native" and len(parts) > 2 else "native_cores"
            if core != "native_cores" and not within(here, CORES[core]):
                yield f"{path}: {name} is not for {here}"
        if mine not in ONLY_IN.get(parts[0], {mine}):
            yield f"{path}: {parts[0]} is not for {mine}"
        if parts[0] in {"robots", "problems", "trajopt_robots", "trajopt_problems"}:
            yield f"{path}: {name}"


def test_imports_downward() -> None:
    assert [line for path in modules() for line in violations(path)] == []


def test_robots_and_problems_use_public_names() -> None:
    found: list[str] = []
    for path in (*(ROOT / "robots").rglob("*.py"), *(ROOT / "problems").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if (
                isinstance(node, ast.ImportFrom)
                and not node.level
                and (node.module or "").startswith("trajopt.")
            ):
                found.append(f"{path}: {node.module} is not public")
    assert found == []


def test_conveniences_are_imported_within_methods() -> None:
    for module, others in CONVENIENCES.items():
        tree = ast.parse((PACKAGE / f"{module.replace('.', '/')}.py").read_text())
        at_first = {node.module for node in tree.body if isinstance(node, ast.ImportFrom)}
        assert not at_first & {f"trajopt.{other}" for other in others}


def test_every_room_has_a_layer() -> None:
    rooms = {
        room(path) for path in PACKAGE.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    assert rooms - {"__init__", "__pycache__"} == set(LAYERS)
