"""A run that is watched: shown in the browser in real time, and recorded."""

import sys
import time
from collections.abc import Generator
from contextlib import contextmanager
from typing import Annotated

import typer

from trajopt.execution.logbook import Logbook, Watched
from trajopt.execution.recording import Recording
from trajopt.problem import Problem
from trajopt.view.run_viewer import RunViewer, watch_run

PortOption = Annotated[int, typer.Option("--port", help="Port of the page.")]
HostOption = Annotated[str, typer.Option("--host", help="Address that the page is served on.")]
SecondsOption = Annotated[
    float | None, typer.Option("--seconds", help="Close after this many seconds; Ctrl-C otherwise.")
]


class Watching:
    """Whoever looks after each cycle."""

    def __init__(self, viewer: RunViewer | None) -> None:
        """Look, with a page or without."""
        self._viewer, self._logbook = viewer, Logbook()
        self._begun: tuple[float, float] | None = None

    def look(self, watched: Watched) -> None:
        """Write down what is new; with a page, wait until it is time for it too."""
        if self._viewer is None:
            self._logbook.look(watched)
            return
        self._viewer.look(watched)
        now = watched.executor.now()
        self._begun = self._begun or (time.monotonic(), now)
        time.sleep(max(self._begun[0] + now - self._begun[1] - time.monotonic(), 0.0))

    @property
    def recording(self) -> Recording:
        """Everything so far."""
        return self._logbook.recording if self._viewer is None else self._viewer.recording

    def linger(self, seconds: float | None) -> None:
        """Keep the page open for so long, until Ctrl-C when None."""
        if self._viewer is not None:
            self._viewer.wait(seconds)


def say_where(url: str, *, as_json: bool) -> None:
    """Say where a page is; with JSON on standard output only to a person, on standard error."""
    if not as_json or sys.stderr.isatty():
        typer.echo(f"open {url} (Ctrl-C ends)", err=as_json)


@contextmanager
def watched(problem: Problem, *, view: bool, port: int, host: str, as_json: bool) -> Generator[Watching]:
    """Open the page of a run if one is asked for, and close it at the end."""
    viewer = watch_run(problem, port=port, host=host) if view else None
    if viewer is not None:
        say_where(viewer.url, as_json=as_json)
    try:
        yield Watching(viewer)
    finally:
        if viewer is not None:
            viewer.close()
