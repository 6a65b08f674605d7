"""A watched run: shown in the browser in real time, recorded and published."""

import sys
import time
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from typing import Annotated

import typer

from trajopt.driving.recording import Logbook, Recording, Watched
from trajopt.problem.problem import Problem
from trajopt.viewer.mirror import RunPublisher
from trajopt.viewer.run_viewer import RunViewer, watch_run

PortOption = Annotated[int, typer.Option("--port", help="Port of the page.")]
HostOption = Annotated[str, typer.Option("--host", help="Address that the page is served on.")]
SecondsOption = Annotated[
    float | None, typer.Option("--seconds", help="Close after this many seconds; Ctrl-C otherwise.")
]


class Watching:
    """The observer of a run, called after each cycle."""

    def __init__(self, viewer: RunViewer | None, publisher: RunPublisher | None = None) -> None:
        """Record the run, optionally with a page and a publisher."""
        self._viewer, self._publisher, self._logbook = viewer, publisher, Logbook()
        self._begun: tuple[float, float] | None = None

    def look(self, watched: Watched) -> None:
        """Record the present moment; with a page, wait for real time."""
        looks = [each.look for each in (self._viewer, self._publisher) if each is not None]
        for look in looks if self._viewer is not None else [*looks, self._logbook.look]:
            look(watched)
        if not looks:
            return
        now = watched.executor.now()
        self._begun = self._begun or (time.monotonic(), now)
        time.sleep(max(self._begun[0] + now - self._begun[1] - time.monotonic(), 0.0))

    @property
    def recording(self) -> Recording:
        """The recording so far."""
        return self._logbook.recording if self._viewer is None else self._viewer.recording

    def linger(self, seconds: float | None) -> None:
        """Keep the page open for some time [s], or until Ctrl-C if None."""
        if self._viewer is not None:
            self._viewer.wait(seconds)


def say_where(url: str, *, as_json: bool, how: str = "open") -> None:
    """Print the address of a page; with JSON on standard output, on standard error for a person."""
    if not as_json or sys.stderr.isatty():
        typer.echo(f"{how} {url} (Ctrl-C ends)", err=as_json)


@contextmanager
def watched(
    problem: Problem, *, view: bool, port: int, host: str, as_json: bool, publish: int | None = None
) -> Generator[Watching]:
    """Open the page of a run and a publisher, as requested."""
    with ExitStack() as opened:
        viewer = publisher = None
        if publish is not None:
            publisher = opened.enter_context(RunPublisher(problem, port=publish, host=host))
            say_where(f"trajopt view --mirror {publisher.url}", as_json=as_json, how="mirror with:")
        if view:
            viewer = watch_run(problem, port=port, host=host)
            opened.callback(viewer.close)
            say_where(viewer.url, as_json=as_json)
        yield Watching(viewer, publisher)
