"""The checker of proofs is small and alone."""

import ast
import sys
from pathlib import Path

import pytest

from benchmarks.house import code_lines

CHECKER = Path(__file__).parents[2] / "trajopt" / "verify" / "checker"
FILES = sorted(CHECKER.glob("*.py"))
MOST_OF_KERNEL, MOST_OF_RULE = 800, 60


def is_rule(path: Path) -> bool:
    """Rules of requirements, and the one file that they share."""
    return path.stem == "requirement" or path.stem.startswith("rule_")


def test_it_imports_nothing_but_numpy_flint_and_itself() -> None:
    known = sys.stdlib_module_names | {"numpy", "flint"} | {path.stem for path in FILES}
    for path in FILES:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                assert not node.level, path
                names = [node.module or ""]
            assert {name.partition(".")[0] for name in names} <= known, path


def test_its_files_hide_no_module_of_python() -> None:
    assert not {path.stem for path in FILES} & sys.stdlib_module_names


def test_the_kernel_is_small() -> None:
    assert sum(code_lines(path.read_text()) for path in FILES if not is_rule(path)) <= MOST_OF_KERNEL


@pytest.mark.parametrize("path", [each for each in FILES if is_rule(each)], ids=lambda path: path.stem)
def test_a_rule_is_small(path: Path) -> None:
    assert code_lines(path.read_text()) <= MOST_OF_RULE


def test_the_fast_kernel_includes_no_code_of_other_cores() -> None:
    folder = CHECKER.parents[1] / "native" / "checker"
    own = {each.name for each in folder.glob("*.hpp")} | {"../leaks.hpp", "../arrays.hpp"}
    for path in (*folder.glob("*.cpp"), *folder.glob("*.hpp")):
        lines = [line for line in path.read_text().splitlines() if line.startswith('#include "')]
        included = {line.split('"')[1] for line in lines}
        assert included <= own, path
