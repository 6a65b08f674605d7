"""Pictures and films of a motion, drawn by MuJoCo without a display."""

from collections.abc import Callable, Iterable, Sequence
from enum import Enum
from pathlib import Path

import numpy as np

from trajopt.arrays import Floats, floats
from trajopt.errors import ShapeError
from trajopt.model.reduced import ReducedModel
from trajopt.model.trajectory import Trajectory
from trajopt.simulate.camera import CameraView
from trajopt.simulate.controller import in_group_order
from trajopt.simulate.film import WRITERS, check_path, write_strip
from trajopt.simulate.phases import SequenceLog
from trajopt.simulate.rollout import Rollout
from trajopt.simulate.studio import Motion, Studio

MOST_PLACES = 100_000
"""Between so many moments at most a planned motion is drawn straight."""
MOST_PICTURES = 100_000
"""Of one film."""


class Layout(Enum):
    """How several moments come into one PNG."""

    FILM_STRIP = "one picture each, in rows"
    SUPERPOSED = "one picture: the last moment solid, the others translucent"


def render(
    reduced: ReducedModel,
    motion: Rollout | Trajectory | SequenceLog,
    path: Path | str,
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
    """Draw a motion into a PNG, GIF or MP4 file.

    Args:
        reduced: Robot and scene.
        motion: A simulated or a planned motion; of a simulated sequence, `reduced` is its own.
        path: The file; its suffix says the kind. MP4 needs the package imageio-ffmpeg.
        width: Of one picture [pixels].
        height: Of one picture [pixels].
        fps: Pictures per second of GIF and MP4.
        moments: Times to show in a PNG [s]; start, end and two between, at even shares of the
            way through joint space, when None.
        layout: How several moments come into a PNG.
        camera: From where; chosen to show the whole motion when None.
        highlight: Links and objects that are drawn in a colour of their own.
        progress: Called with the share done, up to 1.

    Returns:
        The path.

    Raises:
        FileFormatError: If the suffix is none of the three, or the folder does not exist.
        MissingExtra: If MP4 is asked for and imageio-ffmpeg is not installed.
        RenderingUnavailable: If no OpenGL works here; says what to install.
        ShapeError: If a size, `fps` or `moments` cannot be used.
        ModelError: If the motion is not of this group's joints.
    """
    file = Path(path)
    suffix = check_path(file)
    for name, value in (("width", width), ("height", height), ("fps", fps)):
        if value <= 0 or (suffix == ".mp4" and name != "fps" and value % 2):
            raise ShapeError(name, f"must be positive, and even for MP4; is {value}")
    still = suffix == ".png"
    known = _motion(reduced, motion)
    times = _moments(known, moments) if still else _beats(known, fps)
    report = progress or _silent
    studio = Studio(
        reduced,
        known,
        width=width,
        height=height,
        shadow=min(4096, (6 if still else 3) * max(width, height)),
        pictures=len(times),
        camera=camera,
        highlight=frozenset(highlight),
    )
    with studio:
        if still and layout is Layout.SUPERPOSED:
            write_strip(file, [studio.superposed(times)])
        elif still:
            write_strip(file, list(studio.pictures(times, report)))
        else:
            WRITERS[suffix](file, studio.pictures(times, report), fps)
    report(1.0)
    return file


def _motion(reduced: ReducedModel, motion: Rollout | Trajectory | SequenceLog) -> Motion:
    if isinstance(motion, SequenceLog):
        columns = reduced.scene.robot.index(reduced.joint_names)
        return Motion(motion.times, motion.positions[:, columns], motion.loose, motion.placements)
    if isinstance(motion, Rollout):
        if motion.joint_names != reduced.joint_names:
            in_group_order(reduced, motion.trajectory)  # raises
        if len(motion.times) == 1:  # it blew up at once
            return Motion(np.array((0.0, 1e-3)), np.repeat(motion.positions, 2, axis=0))
        return Motion(motion.times, motion.positions)
    trajectory = in_group_order(reduced, motion)
    step = max(0.01, trajectory.duration / MOST_PLACES)
    between = step * np.arange(int(trajectory.duration / step) + 1)
    times = np.array(sorted({*between.tolist(), *trajectory.times.tolist()}))
    return Motion(times, trajectory(times))


def _moments(motion: Motion, moments: Sequence[float] | None) -> Floats:
    end = motion.duration
    if moments is None:
        # Even shares of the way, not of the time: most happens in the middle of a motion.
        steps = np.linalg.norm(np.diff(motion.positions, axis=0), axis=1) + 1e-6 * np.diff(motion.times)
        way = np.append(0.0, np.cumsum(steps))
        places = np.searchsorted(way / way[-1], (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0))
        return motion.times[places]
    times = floats("moments", moments, (None,))
    if len(times) == 0 or (times < 0.0).any() or (times > end + 1e-9).any():
        raise ShapeError("moments", f"need at least one, each from 0 to {end:g} s")
    return times


def _beats(motion: Motion, fps: float) -> Floats:
    if motion.duration * fps > MOST_PICTURES:
        raise ShapeError(
            "fps", f"of {fps:g} over {motion.duration:g} s makes more than {MOST_PICTURES} pictures"
        )
    return np.array([k / fps for k in range(int(motion.duration * fps + 1.5))])


def _silent(_: float) -> None:
    pass
