"""The commands, and how their errors become exit codes.

Exit status: 0 a verified plan, 1 no plan found (with the reason), 2 bad input (one clear line).
"""

import sys

import typer

from trajopt.cli.bench import bench
from trajopt.cli.check import check
from trajopt.cli.compare import compare
from trajopt.cli.demo import demo
from trajopt.cli.export import export
from trajopt.cli.moveit import moveit
from trajopt.cli.plan import plan
from trajopt.cli.reach import reach
from trajopt.cli.sample import sample
from trajopt.cli.srdf import srdf
from trajopt.cli.suite import suite
from trajopt.cli.view import view
from trajopt.errors import TrajoptError

BAD_INPUT = 2

app = typer.Typer(
    name="trajopt",
    help="Plan motions of robot arms by optimisation, with a proof that each motion does what it must.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for command in (demo, plan, check, export, bench, suite, compare, view, sample, reach, srdf):
    app.command()(command)
app.command(context_settings={"allow_interspersed_args": False})(moveit)


def main() -> None:
    """Run the command line; errors of input are one line on standard error and exit status 2."""
    try:
        app()
    except TrajoptError as error:
        sys.stderr.write(f"trajopt: {error}\n")
        sys.exit(BAD_INPUT)
