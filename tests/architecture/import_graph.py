"""The imports of the package as a graph of its files, and of its rooms: those within functions count, too."""

import ast
from collections.abc import Iterable, Mapping
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "trajopt"

Graph = Mapping[str, set[str]]

CONVENIENCES: Mapping[str, set[str]] = {
    "planning.result": {"files.bundle", "files.proof", "why"},
    "problem.problem": {"files.bundle"},
    "tasks.grasping.result": {"tasks.grasping.simulation"},
    "tasks.result": {"tasks.grasping.simulation"},
}
"""Modules with methods that pass their object to a function of a higher layer: `result.save(path)` calls
`files.bundle.save(result, path)`. They import it within the method, which is not part of the graph."""


def modules(package: Path = PACKAGE) -> dict[str, Path]:
    """Dotted name of each module -> its file; a package is named after its folder."""
    named: dict[str, Path] = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package.parent).with_suffix("").parts
        named[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return named


def imported(path: Path) -> set[str]:
    """Names of modules and of what is taken out of them, wherever in the file they are imported."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


def file_graph(package: Path = PACKAGE) -> Graph:
    """Module -> the modules of the package that it imports."""
    files = modules(package)

    def home(name: str) -> str | None:
        return name if name in files else (parent if (parent := name.rpartition(".")[0]) in files else None)

    return {
        module: {
            other
            for name in imported(path)
            if (other := home(name)) not in {None, module} and not name.startswith(conveniences(module))
        }
        for module, path in files.items()
    }


def conveniences(module: str) -> tuple[str, ...]:
    """Return the higher modules that methods of a module may import."""
    return tuple(f"trajopt.{other}" for other in CONVENIENCES.get(module.removeprefix("trajopt."), ()))


def folder_graph(files: Graph, depth: int) -> Graph:
    """Join modules that share their first folders: at depth 1 the rooms, at depth 2 folders within them."""

    def folder(module: str) -> str:
        return ".".join(module.split(".")[: depth + 1])

    joined: dict[str, set[str]] = {folder(module): set() for module in files}
    for module, others in files.items():
        joined[folder(module)] |= {folder(other) for other in others} - {folder(module)}
    return joined


def circles(graph: Graph) -> list[set[str]]:
    """Groups of at least two nodes each of which leads to each other."""
    reach = {node: reachable(graph, graph[node]) for node in graph}
    found: list[set[str]] = []
    for node in graph:
        ring = {other for other in reach[node] if node in reach[other]} - {node}
        if ring and not any(node in known for known in found):
            found.append(ring | {node})
    return found


def reachable(graph: Graph, first: Iterable[str]) -> set[str]:
    """Return the nodes that some nodes lead to, themselves included."""
    seen: set[str] = set()
    waiting = list(first)
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            waiting.extend(graph.get(node, ()))
    return seen
