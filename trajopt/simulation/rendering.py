"""Pictures and films of a motion, drawn by MuJoCo without a display."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from enum import Enum
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

from trajopt.scene.planned_robot import HasReduced, Planned, PlannedWhole, model_and_trajectory
from trajopt.scene.reduced import ReducedModel
from trajopt.simulation.camera import CameraView
from trajopt.simulation.rollout import Rollout, SequenceLog
from trajopt.values.arrays import function, number, one_of, several, unless_none
from trajopt.values.errors import FileFormatError, FrameNotFound, ProblemError, ShapeError, shown
from trajopt.values.trajectory import Trajectory

if TYPE_CHECKING:
    from trajopt.simulation.sampled_motion import SampledMotion


@runtime_checkable
class Logged(Protocol):
    """A simulated task, or pick and place."""

    @property
    def log(self) -> SequenceLog:
        """The record of the simulation."""
        ...


Subject = (
    Planned[ReducedModel]
    | PlannedWhole[ReducedModel]
    | Rollout
    | SequenceLog
    | Logged
    | ReducedModel
    | HasReduced[ReducedModel]
)


class Layout(Enum):
    """Layout of several times in one PNG."""

    FILM_STRIP = "one picture per time, in rows"
    SUPERPOSED = "one picture: the last time solid, the others translucent"


def render(
    subject: Subject,
    motion: Rollout | Trajectory | SequenceLog | Path | str,
    path: Path | str | None = None,
    *,
    width: int = 640,
    height: int = 480,
    fps: float = 20.0,
    moments: Sequence[float] | None = None,
    layout: Layout = Layout.FILM_STRIP,
    camera: CameraView | None = None,
    highlight: Iterable[str] = (),
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Draw a motion, or the start of a problem, into a PNG, GIF or MP4 file; return the path.

    Args:
        subject: A plan, a result with one or several motions, a simulated motion, a problem; or a reduced
            model.
        motion: The file; or, for a reduced model, the motion, simulated or planned. A simulated sequence has
            its own reduced model.
        path: The file, after a motion; its suffix selects the format.
        width: Of one picture, as `height` [pixels].
        fps: Pictures per second of GIF and MP4.
        moments: Times to show in a PNG [s]; if None, four at equal shares of the path in joint space.
        camera: If None, one that shows the whole motion.
        highlight: Links and objects with a special colour.
        progress: Called with the share that is done, up to 1.

    Raises:
        PlanningFailed: If the result has no plan.
        FrameNotFound: If a highlighted link or object does not exist.
        ProblemError: If the motion or the file is missing.
        FileFormatError: If the suffix is another one (PNG for a problem), or the folder does not exist.
        MissingExtra: If a film (.mp4) is requested without the extra `film`.
        RenderingUnavailable: If OpenGL does not work.
        ShapeError: If a size, `fps` or `moments` is invalid.
        ModelError: If the joints of the motion differ from the group's.
    """
    from trajopt.simulation.picture_files import WRITERS, check_path, write_strip
    from trajopt.simulation.sampled_motion import frame_times, moments_of
    from trajopt.simulation.studio import Canvas, Studio

    reduced, drawn, file = _drawn(subject, motion, path)
    suffix = check_path(file)
    known, still = _known(reduced, drawn, file), suffix == ".png"
    _check_sizes(width, height, fps, even=suffix == ".mp4")
    red, names = several("highlight", highlight, str), (*reduced.scene.robot.links, *reduced.scene.objects)
    for name in red:
        if name not in names:
            raise FrameNotFound("link or object", name, names)
    times = moments_of(known, moments if drawn is not None else (0.0,)) if still else frame_times(known, fps)
    one_of("layout", layout, Layout)
    report = function("progress", progress) or _silent
    with Studio(
        reduced,
        known,
        Canvas(width, height, shadow=min(4096, (6 if still else 3) * max(width, height))),
        pictures=len(times),
        camera=unless_none("camera", camera, CameraView),
        highlight=red,
    ) as studio:
        if still and layout is Layout.SUPERPOSED:
            write_strip(file, [studio.superposed(times)])
        elif still:
            write_strip(file, list(studio.pictures(times, report)))
        else:
            WRITERS[suffix](file, studio.pictures(times, report), fps)
    report(1.0)
    return file


def _known(
    reduced: ReducedModel, drawn: Rollout | Trajectory | SequenceLog | None, file: Path
) -> SampledMotion:
    from trajopt.simulation.sampled_motion import held_start, motion_of

    if drawn is not None:
        return motion_of(reduced, drawn)
    if file.suffix.lower() != ".png":
        raise FileFormatError(str(file), "a problem has no motion; its start is drawn as .png")
    return held_start(reduced)


def _check_sizes(width: int, height: int, fps: float, *, even: bool) -> None:
    if number("fps", fps) <= 0.0:
        raise ShapeError("fps", f"must be positive, is {fps:g}")
    for name, value in (("width", width), ("height", height)):
        if type(value) is not int or value <= 0 or (even and value % 2):
            raise ShapeError(name, f"must be a positive integer, for MP4 an even one; is {shown(value)}")


def _drawn(
    subject: Subject,
    motion: Rollout | Trajectory | SequenceLog | Path | str,
    path: Path | str | None,
) -> tuple[ReducedModel, Rollout | Trajectory | SequenceLog | None, Path]:
    subject = subject.log if isinstance(subject, Logged) else subject
    if isinstance(motion, Path | str):
        if path is not None:
            raise ProblemError(f"render: two files are given, motion={shown(motion)} and path")
        file = Path(motion)
        if isinstance(subject, Rollout | SequenceLog):
            return subject.reduced, subject, file
        if isinstance(subject, HasReduced):
            return subject.reduced, None, file
        return *model_and_trajectory("render", subject, None, ReducedModel, "subject"), file
    if path is None:
        raise ProblemError("render: the file is missing; pass it as path, or instead of the motion")
    if isinstance(subject, Rollout | SequenceLog):
        raise ProblemError("render: subject is a simulated motion; leave out motion")
    if isinstance(subject, ReducedModel | HasReduced):
        return subject if isinstance(subject, ReducedModel) else subject.reduced, motion, Path(path)
    return model_and_trajectory("render", subject, None, ReducedModel, "subject")[0], motion, Path(path)


def _silent(_: float) -> None:
    pass


WIDTH, HEIGHT = 320, 240
"""Size of a thumbnail [pixels]."""
SHADOW = 1024
JPEG_QUALITY = 80
"""JPEG quality without visible artefacts."""
TYPE = "image/jpeg"


def thumbnail(reduced: ReducedModel, trajectory: Trajectory | None) -> bytes:
    """Draw a motion, its end solid and the way translucent, or the start, as a JPEG."""
    from PIL import Image

    from trajopt.simulation.sampled_motion import held_start, moments_of, motion_of
    from trajopt.simulation.studio import Canvas, Studio

    if trajectory is None:
        motion, moments = held_start(reduced), np.zeros(1)
    else:
        motion = motion_of(reduced, trajectory)
        moments = moments_of(motion, None)
    with Studio(reduced, motion, Canvas(WIDTH, HEIGHT, SHADOW), pictures=len(moments), camera=None) as studio:
        picture = studio.superposed(moments)
    written = BytesIO()
    Image.fromarray(picture).save(written, "JPEG", quality=JPEG_QUALITY, optimize=True)
    return written.getvalue()
