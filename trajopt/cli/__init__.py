"""The command line.

Exit status: 0 a verified plan, 1 no plan found (with the reason), 2 bad input (one clear line).
"""

import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.metadata import version
from typing import Annotated

import typer

from trajopt.values.errors import TrajoptError

BAD_INPUT, INTERRUPTED = 2, 130
COMMANDS: Mapping[str, str] = {
    "demo": "demo",
    "plan": "plan",
    "task": "task",
    "check": "motions",
    "prove": "motions",
    "simulate": "simulate",
    "run": "drive",
    "servo": "drive",
    "export": "motions",
    "bench": "suite",
    "suite": "suite",
    "compare": "suite",
    "view": "view",
    "sample": "kinematics",
    "reach": "kinematics",
    "srdf": "kinematics",
    "serve": "serve",
    "moveit": "moveit",
    "replay": "motions",
    "report": "motions",
    "warehouse": "warehouse",
    "campaign": "campaign",
}
"""Module of each command, which is a function, or a group of commands, of its name."""
OTHERS_WORDS = ("moveit",)
"""Commands that pass the arguments after the first on."""


def app_for(words: Sequence[str]) -> typer.Typer:
    """Return the command line with the named command only, or with all commands.

    So `trajopt plan` does not load the requirements of other commands.
    """
    app = typer.Typer(
        name="trajopt",
        help="Plan motions of robot arms by optimisation, with a proof that each motion does what it must.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.callback()(_whole)
    for name in words[:1] if words and words[0] in COMMANDS else COMMANDS:
        command = command_named(name)
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name)
            continue
        settings = {"allow_interspersed_args": False} if name in OTHERS_WORDS else None
        app.command(name, context_settings=settings)(command)
    return app


def command_named(name: str) -> Callable[..., None] | typer.Typer:
    return getattr(import_module(f"trajopt.cli.{COMMANDS[name]}"), name)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(version("trajopt-planner"))
        raise typer.Exit


VersionOption = Annotated[
    bool,
    typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit."),
]


def _whole(version: VersionOption = False) -> None:
    """Do nothing: with a single command, typer would drop its name from the command line."""


def main() -> None:
    """Run the command line; errors of input are one line on standard error and exit status 2."""
    if not set(OTHERS_WORDS).intersection(sys.argv[1:2]):  # whose warnings name a line of the script
        warnings.formatwarning = _warning
    try:
        app_for(sys.argv[1:])()
    except KeyboardInterrupt:  # during the imports; later typer ends the command
        sys.exit(INTERRUPTED)
    except TrajoptError as error:
        sys.stderr.write(f"trajopt: {error}\n")
        sys.exit(BAD_INPUT)


def _warning(message: Warning | str, *_: object) -> str:
    return f"trajopt: warning: {message}\n"
