"""The commands, and how their errors become exit codes.

Exit status: 0 a verified plan, 1 no plan found (with the reason), 2 bad input (one clear line).
"""

import sys
from collections.abc import Sequence
from importlib import import_module

import typer

from trajopt.values.errors import TrajoptError

BAD_INPUT = 2
COMMANDS = (
    "demo", "plan", "check", "prove", "simulate", "run", "servo", "export", "bench", "suite", "compare",
    "view", "sample", "reach", "srdf", "serve", "moveit", "replay", "report",
    "warehouse", "campaign",
)  # fmt: skip
"""All commands; each is the function of its name in a file of its name, or commands of its own there."""
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
        command = getattr(import_module(f"trajopt.cli.{name}"), name)
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name)
            continue
        settings = {"allow_interspersed_args": False} if name in OTHERS_WORDS else None
        app.command(name, context_settings=settings)(command)
    return app


def _whole() -> None:
    """Do nothing: with a single command, typer would drop its name from the command line."""


def main() -> None:
    """Run the command line; errors of input are one line on standard error and exit status 2."""
    try:
        app_for(sys.argv[1:])()
    except TrajoptError as error:
        sys.stderr.write(f"trajopt: {error}\n")
        sys.exit(BAD_INPUT)
