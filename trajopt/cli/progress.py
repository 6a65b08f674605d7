"""Progress lines on standard error, if that is a terminal."""

import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from trajopt.optimise.solvers import Iteration
from trajopt.planning.budget import DOING
from trajopt.planning.result import Result

if TYPE_CHECKING:
    from rich.progress import Progress as Bar


@dataclass(eq=False)
class ProgressLine:
    """The line: the present stage, and the present best motion."""

    write: Callable[[str], None]
    _best: str = ""

    def show(self, stage: str, step: Iteration | None) -> None:
        text = DOING.get(stage, stage)
        if step is not None:
            text += f": cost {step.cost:.3f}, violation {step.violation:.4f}"
        self.write(self._best + text)

    def have(self, result: Result) -> None:
        self._best = f"have a motion of {result.cost:.3f} s; "


@contextmanager
def status_line(text: str) -> Generator[Callable[[str], None]]:
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console

    with Console(stderr=True).status(text) as status:
        yield status.update


@contextmanager
def progress_line() -> Generator[ProgressLine]:
    with status_line("starting") as write:
        yield ProgressLine(write)


@contextmanager
def progress_bar(text: str, total: int) -> Generator[Callable[[int], None]]:
    with quiet_bar() as bar:
        task = bar.add_task(text, total=total)
        yield lambda done: bar.update(task, completed=done)


def quiet_bar() -> "Bar":
    from rich.console import Console
    from rich.progress import Progress as Bar

    console = Console(stderr=True)
    return Bar(console=console, transient=True, disable=not console.is_terminal)
