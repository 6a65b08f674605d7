"""A line on standard error that moves while work goes on, where somebody watches."""

from collections.abc import Generator
from contextlib import contextmanager

from rich.console import Console

from trajopt.planning import Progress
from trajopt.solvers import Iteration

DOING = {
    "examine": "looking at the start",
    "seed": "searching goal configurations",
    "optimise": "optimising",
    "retime": "timing",
    "verify": "judging",
    "simulate": "simulating",
    "render": "rendering",
}
"""What each stage is called while it runs."""


@contextmanager
def progress_line() -> Generator[Progress]:
    """Show a spinner with the present stage; silent where standard error is no terminal."""
    console = Console(stderr=True)
    with console.status("starting") as status:

        def show(stage: str, step: Iteration | None) -> None:
            text = DOING.get(stage, stage)
            if step is not None:
                text += f": cost {step.cost:.3f}, violation {step.violation:.4f}"
            status.update(text)

        yield show
