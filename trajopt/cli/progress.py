"""A line on standard error that moves while work goes on, where somebody watches."""

from collections.abc import Callable, Generator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import Progress as Bar

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


@contextmanager
def progress_bar(text: str, total: int) -> Generator[Callable[[int], None]]:
    """Show a bar that is told how many of a total are done; silent where standard error is no terminal."""
    console = Console(stderr=True)
    with Bar(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(text, total=total)
        yield lambda done: bar.update(task, completed=done)
