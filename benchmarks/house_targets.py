"""Measure size and structure of a checkout against the targets of the project.

python -m benchmarks.house_targets [--names] [--closure] [--checkout FOLDER]

Reads the sources of one checkout; only the closure of `trajopt.verify` and the number of tests need an
environment in which that checkout is the installed one.
"""

import argparse
import ast
import io
import subprocess
import sys
import tokenize
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.page import table

ROOT = Path(__file__).parents[1]
NOT_CODE = {
    *(tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT),
    *(tokenize.ENCODING, tokenize.ENDMARKER),
}
MESSAGES = "messages"
"""Folder of the ROS messages: their classes carry the names that ROS gives them."""
EVALUATORS = {"Query", "Evaluator"}
"""Names of the classes that evaluate placements and distances."""
CLOSURE = """
import sys, trajopt.verify
for name, module in sorted(sys.modules.items()):
    if name.partition(".")[0] == "trajopt" and getattr(module, "__file__", None):
        print(name, module.__file__)
"""


@dataclass(frozen=True)
class Source:
    """A Python file of the package: its path within `trajopt/`, its text and its syntax tree."""

    path: Path
    text: str
    tree: ast.Module

    @property
    def lines(self) -> int:
        """Number of lines."""
        return self.text.count("\n")


def sources(checkout: Path) -> list[Source]:
    """Read every Python file of the package."""
    package = checkout / "trajopt"
    texts = {path.relative_to(package): path.read_text() for path in sorted(package.rglob("*.py"))}
    return [Source(path, text, ast.parse(text)) for path, text in texts.items()]


def rooms(checkout: Path) -> list[str]:
    """Name the folders and the files directly in the package that hold Python."""
    package = checkout / "trajopt"
    folders = {path.relative_to(package).parts[0] for path in package.rglob("*.py")}
    return sorted(folders - {"__init__.py", "__main__.py"})


def code_lines(source: Source) -> int:
    """Count the lines that are neither blank nor comment nor docstring."""
    prose = {
        line
        for node in ast.walk(source.tree)
        if isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
        for line in _span(node)
    }
    tokens = tokenize.generate_tokens(io.StringIO(source.text).readline)
    lines = {
        line
        for token in tokens
        if token.type not in NOT_CODE
        for line in range(token.start[0], token.end[0] + 1)
    }
    return len(lines - prose)


def import_lines(source: Source) -> int:
    """Count the lines of import statements, wherever in the file they are."""
    imports = (node for node in ast.walk(source.tree) if isinstance(node, ast.Import | ast.ImportFrom))
    return len({line for node in imports for line in _span(node)})


def _span(node: ast.stmt) -> range:
    return range(node.lineno, (node.end_lineno or node.lineno) + 1)


def _calls(source: Source) -> Iterator[tuple[str, ast.Call]]:
    """Yield each call with the last name of the called function."""
    for node in ast.walk(source.tree):
        match node:
            case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)):
                yield name, node
            case _:
                pass


def hidden_imports(files: Sequence[Source]) -> list[str]:
    """Find calls of `import_module` with the name of a module of the package."""
    return [
        f"{source.path}:{call.lineno}"
        for source in files
        for name, call in _calls(source)
        if name.endswith("import_module") and _begins_with_package(call)
    ]


def _begins_with_package(call: ast.Call) -> bool:
    match call.args:
        case [ast.Constant(value=str(text)), *_]:
            return text.partition(".")[0] == "trajopt"
        case _:
            return False


def evaluators(files: Sequence[Source]) -> list[str]:
    """Find the lines that construct an evaluator of placements and distances, or the native core of one."""
    found = {
        f"{source.path}:{call.lineno}"
        for source in files
        for name, call in _calls(source)
        if name in EVALUATORS
    }
    return sorted(found)


def repeated_names(files: Sequence[Source]) -> Mapping[str, list[str]]:
    """Public names of top-level classes used more than once -> the files that use them."""
    places: defaultdict[str, list[str]] = defaultdict(list)
    for source in files:
        for node in source.tree.body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                if MESSAGES not in source.path.parts:
                    places[node.name].append(str(source.path))
    return {name: where for name, where in sorted(places.items()) if len(where) > 1}


def closure(checkout: Path) -> list[tuple[str, int]]:
    """Modules of the package that `import trajopt.verify` reads, with their numbers of lines."""
    command = [sys.executable, "-I", "-c", CLOSURE]
    printed = subprocess.run(command, cwd=checkout, check=True, capture_output=True, text=True).stdout
    named = dict(line.split(maxsplit=1) for line in printed.splitlines())
    package = (checkout / "trajopt").resolve()
    if not Path(named["trajopt"]).resolve().is_relative_to(package):
        raise SystemExit(f"{sys.executable} imports {named['trajopt']}, which is not in {package}")
    python = {name: path for name, path in named.items() if path.endswith(".py")}
    return [(name, Path(path).read_text().count("\n")) for name, path in python.items()]


def style_tests(checkout: Path) -> int:
    """Count the test items that read sources instead of running them: those of tests/architecture."""
    listing = ("-o", "addopts=", "--collect-only", "-q", "-n", "0")
    command = [sys.executable, "-m", "pytest", "tests/architecture", *listing]
    printed = subprocess.run(command, check=True, cwd=checkout, capture_output=True, text=True).stdout
    return sum("::" in line for line in printed.splitlines())


def measures(checkout: Path, files: Sequence[Source]) -> list[tuple[str, str, str]]:
    """Return each measure with its value here and the most that it should be."""
    imports, code = sum(map(import_lines, files)), sum(map(code_lines, files))
    read = closure(checkout)
    return [
        (
            "files / lines of `trajopt/` (Python)",
            f"{len(files)} / {sum(each.lines for each in files):,}",
            "500 / 88,000",
        ),
        ("rooms directly in `trajopt/`", f"{len(rooms(checkout))}", "20"),
        ("import lines of code lines", f"{100 * imports / code:.1f} %", "11 %"),
        ('`import_module("trajopt`', f"{len(hidden_imports(files))}", "0"),
        ("public top-level class names used more than once", f"{len(repeated_names(files))}", "5"),
        (
            "files / lines read by `import trajopt.verify`",
            f"{len(read)} / {sum(lines for _, lines in read):,}",
            "70 / 10,000",
        ),
        ("places that construct the evaluator", f"{len(evaluators(files))}", "3"),
        ("test items about style", f"{style_tests(checkout)}", "150"),
    ]


def main() -> None:
    """Print the measures, and on request the names and files behind them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--checkout", type=Path, default=ROOT, help="root of the sources to measure")
    parser.add_argument("--names", action="store_true", help="list repeated names and places, too")
    parser.add_argument("--closure", action="store_true", help="list the files that the judge reads, too")
    options = parser.parse_args()
    files = sources(options.checkout)
    print(table(("measure", "here", "at most"), measures(options.checkout, files)))
    if options.names:
        for name, where in repeated_names(files).items():
            print(f"{name}: {', '.join(where)}")
        print("evaluators:", *evaluators(files), sep="\n  ")
        print("hidden imports:", *hidden_imports(files), sep="\n  ")
    if options.closure:
        for name, lines in closure(options.checkout):
            print(f"{lines:6} {name}")


if __name__ == "__main__":
    main()
