"""Pictures of results, for the pages that commands write."""

from typing import Annotated, Generic, TypeVar

import typer

from trajopt.planning.result import Result
from trajopt.simulation.rendering import thumbnail
from trajopt.values.errors import RenderingUnavailable

Key = TypeVar("Key")
PicturesOption = Annotated[
    bool, typer.Option("--pictures/--no-pictures", help="Whether the page has a picture of each problem.")
]


class Thumbnails(Generic[Key]):
    """Pictures by key; without OpenGL none, with a remark."""

    def __init__(self, *, enabled: bool) -> None:
        """Have none yet."""
        self.pictures: dict[Key, bytes] = {}
        self.remark = ""
        self._enabled = enabled

    def draw(self, key: Key, result: Result) -> None:
        """Add the picture of a result: of its motion, or of the start without one."""
        if not self._enabled:
            return
        motion = result.trajectory if result.verified else None
        try:
            self.pictures[key] = thumbnail(result.problem.reduced, motion)
        except RenderingUnavailable as missing:
            self.remark = f"It has no pictures: {missing}"
            self._enabled = False
