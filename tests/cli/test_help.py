"""Help says the unit of every number with a fraction: markup takes no brackets away."""

import inspect
from collections.abc import Callable, Iterator
from importlib.metadata import version
from typing import Annotated, get_args, get_origin

import pytest
import typer
from typer.testing import CliRunner

from trajopt.cli import COMMANDS, app_for, command_named

UNITLESS = {"--torque-scaling", "--share", "--level"}
"""Factors and shares, which have none."""
UNITS = ("[s]", "[m]", "[rad]", "[deg]", "second")


def every_command() -> Iterator[str]:
    """All commands; of those that have commands of their own, those: "warehouse ls"."""
    for name in COMMANDS:
        found = command_named(name)
        if isinstance(found, typer.Typer):
            yield from (f"{name} {called(each)}" for each in found.registered_commands)
        else:
            yield name


def called(command: typer.models.CommandInfo) -> str:
    return command.name or getattr(command.callback, "__name__", "")


def function_of(command: str) -> Callable[..., None]:
    name, _, own = command.partition(" ")
    found = command_named(name)
    if isinstance(found, typer.Typer):
        found = next(each.callback for each in found.registered_commands if called(each) == own)
    return found


def floats(command: str) -> dict[str, str]:
    """Return the options of a command that are floats, and what is written as their help."""
    function = function_of(command)
    found: dict[str, str] = {}
    for parameter in inspect.signature(function, eval_str=True).parameters.values():
        if get_origin(parameter.annotation) is not Annotated:
            continue
        kind, option, *_ = get_args(parameter.annotation)
        if kind is float or float in get_args(kind):
            assert isinstance(option, typer.models.OptionInfo) and option.help
            found[f"--{parameter.name.replace('_', '-')}"] = option.help
    return found


def printed(command: str, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("COLUMNS", "400")
    monkeypatch.setenv("TERMINAL_WIDTH", "400")
    done = CliRunner().invoke(app_for(command.split()), [*command.split(), "--help"])
    assert done.exit_code == 0, done.output
    return done.output


@pytest.mark.parametrize("command", [*every_command()])
def test_help_shows_the_unit_of_every_option(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = printed(command, monkeypatch)
    for name, text in floats(command).items():
        words = text.replace("\\[", "[")
        assert words in shown, f"{command} {name}: {text!r} is not shown as it is written"
        assert name in UNITLESS or any(unit in words.lower() for unit in UNITS), (
            f"{command} {name}: {text!r} says no unit"
        )


@pytest.mark.parametrize("command", [*every_command()])
def test_help_loses_nothing_in_brackets(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = printed(command, monkeypatch)
    function = function_of(command)
    assert "[" not in (function.__doc__ or ""), "markup would take it away"
    for parameter in inspect.signature(function, eval_str=True).parameters.values():
        if get_origin(parameter.annotation) is Annotated:
            help_text = get_args(parameter.annotation)[1].help or ""
            assert help_text.replace("\\[", "[") in shown, f"{command} {parameter.name}"


def test_some_options_have_units() -> None:
    """So that the tests above look at something."""
    assert {"--dwell", "--finish-by", "--time-budget"} <= set(floats("plan"))
    assert "--margin" in floats("sample") and "--cell" in floats("reach")


def test_the_version_is_printed() -> None:
    done = CliRunner().invoke(app_for(["--version"]), ["--version"])
    assert done.exit_code == 0 and done.stdout.strip() == version("trajopt-planner")
