"""A module imports downward only: the layers of the package, read from its imports."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "trajopt"

ORDER = (
    ("errors",),
    ("arrays", "native", "io"),
    ("model", "nlp", "messages"),
    ("query", "solvers", "retime", "verify", "simulate"),
    ("terms",),
    ("problem",),
    ("transcription", "kinematics", "moveit"),
    ("methods", "infeasibility", "srdf_assistant", "export", "perception"),
    ("planning",),
    ("explanation", "cartesian", "grasping", "benchmark", "seeds", "execution"),
    ("client", "bundle", "experience"),
    ("view", "commander", "warehouse"),
    ("server", "campaign", "report"),
    ("cli",),
    ("__main__",),
)
"""The rooms of the package, from the lowest layer to the highest: a room imports from lower layers only."""

LAYERS = {room: layer for layer, rooms in enumerate(ORDER) for room in rooms}

FORBIDDEN = {
    "solvers": {"model", "query", "terms", "problem"},
    "verify": {"query", "terms", "problem", "transcription", "solvers", "retime"},
    "retime": {"query", "terms", "problem", "transcription", "solvers", "verify"},
    "nlp": {"model"},
    "terms": {"solvers"},
}
"""What a room may not import although its layer would allow it."""

ONLY_IN: dict[str, set[str]] = {
    "mujoco": {"io"},
    "viser": {"view"},
    "matplotlib": {"view"},
    "typer": {"cli"},
    "rich": {"cli", "planning"},
    "casadi": {"terms", "methods"},
    "ompl": set(),
    "placo": {"kinematics"},
    "pygame": {"execution"},
    "toppra": set(),
    "sqlite3": {"warehouse"},
    "httpx": {"client"},
    "msgspec": {"server"},
    "fastapi": {"server"},
    "uvicorn": {"server"},
    "prometheus_client": {"server"},
    "pyarrow": {"kinematics", "campaign"},
    "ray": {"campaign"},
}
"""Packages that only some rooms may import."""

CORES = {
    "proximity": {"query"},
    "banded": {"solvers"},
    "descent": {"solvers", "transcription"},
    "timing": {"retime"},
    "proof": {"verify"},
    "covers": {"model"},
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


def violations(path: Path) -> Iterator[str]:
    """Yield the imports of a file that its room may not have."""
    mine = room(path)
    for name in imports(path):
        parts = name.split(".")
        if parts[0] == "trajopt" and len(parts) > 1:
            other = parts[1]
            if other not in LAYERS:
                yield f"{path}: {name} is in a room without a layer"
            elif other != mine and LAYERS[other] >= LAYERS[mine]:
                yield f"{path}: imports upward: {name}"
            elif other in FORBIDDEN.get(mine, set()):
                yield f"{path}: {mine} must not know {name}"
            if other == "native" and parts[2:] and parts[2] != "native_cores" and mine not in CORES[parts[2]]:
                yield f"{path}: {name} is not for {mine}"
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


def test_every_room_has_a_layer() -> None:
    rooms = {
        room(path) for path in PACKAGE.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    assert rooms - {"__init__", "__pycache__"} == set(LAYERS)
