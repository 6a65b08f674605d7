"""What is imported is required, with bounds, and pinned for the tests."""

import ast
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
OURS = ("trajopt", "trajopt_robots", "trajopt_problems")
BOUNDS = {"==", "<", "<="}
UNVERSIONED = {"scipy-stubs", "types-pyyaml", "furo"}
"""Their versions are dates, or those of the package whose types they are."""


@cache
def project() -> dict[str, Any]:
    with (ROOT / "pyproject.toml").open("rb") as file:
        return tomllib.load(file)["project"]


def requirements() -> Iterator[Requirement]:
    """Yield all, those of the extras too, but for extras that other extras name."""
    groups = [project()["dependencies"], *project()["optional-dependencies"].values()]
    for each in (Requirement(line) for group in groups for line in group):
        if each.name != project()["name"]:
            yield each


def imported() -> dict[str, str]:
    """Return the packages that trajopt imports, each with a module that does."""
    found: dict[str, str] = {}
    for path in sorted((ROOT / "trajopt").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names = [node.module or ""]
            for name in (name.partition(".")[0] for name in names):
                if name not in sys.stdlib_module_names and name not in OURS:
                    found[name] = str(path.relative_to(ROOT))
    return found


@pytest.mark.parametrize("requirement", list(requirements()), ids=lambda each: each.name)
def test_every_requirement_has_an_upper_bound(requirement: Requirement) -> None:
    if canonicalize_name(requirement.name) not in UNVERSIONED:
        assert any(each.operator in BOUNDS for each in requirement.specifier), str(requirement)


def test_every_import_is_required() -> None:
    required = {canonicalize_name(each.name) for each in requirements()}
    owners = packages_distributions()
    undeclared = {
        name: path
        for name, path in imported().items()
        if name in owners and not {canonicalize_name(each) for each in owners[name]} & required
    }
    assert undeclared == {}


def test_packages_of_tests_are_pinned_within_their_bounds() -> None:
    lines = (ROOT / "packaging" / "locked.txt").read_text().splitlines()
    pins = {
        canonicalize_name(name): version
        for name, _, version in (line.partition("==") for line in lines if not line.startswith("#"))
    }
    for requirement in requirements():
        pin = pins.get(canonicalize_name(requirement.name))
        assert pin is not None, f"{requirement.name} is not pinned: make lock"
        assert requirement.specifier.contains(pin, prereleases=True), f"{requirement}: {pin}: make lock"
