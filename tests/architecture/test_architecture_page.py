"""docs/architecture.md says what is so: its layers, its picture, and the sections that a program writes."""

import importlib
import inspect
import re
import typing

import pytest

from benchmarks.flow import FIRST, OUTER, PICTURE, STEPS, Step, picture
from benchmarks.house import PAGE, calls_to_the_core, code_lines, layers, once


def named(name: str) -> object:
    """Return what a dotted name is: an attribute of the longest part that is a module."""
    module, *attributes = name.split(".")
    value: object = importlib.import_module(module)
    for attribute in attributes:
        value = getattr(value, attribute)
    return value


def test_its_layers_are_those_of_the_test() -> None:
    assert layers() in PAGE.read_text(), "run: python -m benchmarks.house"


def test_its_numbers_are_a_table() -> None:
    _, _, rest = PAGE.read_text().partition("<!-- numbers:begin -->")
    table, _, _ = rest.partition("<!-- numbers:end -->")
    assert len(re.findall(r"^\| .+ \| .+ \|$", table, re.MULTILINE)) > 10, "run: python -m benchmarks.house"


def test_its_picture_is_the_one_that_is_drawn() -> None:
    assert picture() == PICTURE.read_text(), "run: python -m benchmarks.house"
    assert f"images/{PICTURE.name}" in PAGE.read_text()


@pytest.mark.parametrize("step", STEPS, ids=lambda step: step.function)
def test_each_step_of_the_picture_returns_its_drawn_value(step: Step) -> None:
    function = named(step.function)
    assert callable(function)
    names = re.findall(r"\w+", step.call.partition("(")[0]) + re.findall(r"\.(\w+)\(", step.call)
    assert function.__name__ in names
    written = re.findall(r"\w+", step.call.rpartition("(")[2])
    assert len(written) <= len([name for name in inspect.signature(function).parameters if name != "self"])
    returned = str(typing.get_type_hints(function)["return"])
    assert step.value in returned or (step.value == "seed" and "ndarray" in returned)


@pytest.mark.parametrize("name", [FIRST[0], *(name for name, _ in OUTER)])
def test_other_drawn_functions_exist(name: str) -> None:
    assert callable(named(name))


def test_one_attempt_leads_to_the_core() -> None:
    chain = calls_to_the_core(once)
    assert chain[0] == "plan_once" and chain[-1] == "NativeDescent.descend"


def test_lines_of_code_are_counted() -> None:
    text = '"""A page."""\n\n# Why.\nx = (\n    1,\n)\n\n\ndef f():\n    """Say."""\n    return x\n'
    assert code_lines(text) == 5
