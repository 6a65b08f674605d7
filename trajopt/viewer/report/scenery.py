"""The robot in a report: in 3-D on a screen, in still pictures on paper."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO

import numpy as np

from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.problem.problem import Problem
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.palette import SAFE, SURFACES, TOUCHING
from trajopt.viewer.recorded import GhostAt, recorded
from trajopt.viewer.report.subject import Subject

WIDTH, HEIGHT = 640, 420
"""Size of a still picture [pixels]: twice a quarter of a printed page at 150 dpi."""
SHADOW = 2048
"""Edge of the square that shadows are computed on [pixels]."""
QUALITY = 85
"""Of their JPEG: artefacts are not seen on paper."""
WALK = 4.0
"""Seconds in which a path without timing is walked along: slow enough to be looked at."""
GOAL = SURFACES[2]
"""Colour of the goal."""
MOMENT = 1e-3
"""Time between two configurations in one picture [s]: dynamic obstacles hardly move."""


@dataclass(frozen=True, eq=False)
class Still(Value):
    """A picture.

    Attributes:
        jpeg: The file.
        words: Its caption.
    """

    jpeg: bytes
    words: str


@dataclass(frozen=True, eq=False)
class Scenery(Value):
    """The shown scene.

    Attributes:
        motion: The shown motion, or None.
        words: Its caption.
        timed: Whether its time is that of a motion, not of a walk along a path.
        ghosts: Translucent copies of the robot.
    """

    motion: Trajectory | None
    words: str
    timed: bool
    ghosts: tuple[GhostAt, ...]


def scenery(subject: Subject) -> Scenery:
    """Choose the shown scene: the motion, else the best path, else the start."""
    ghosts = tuple(_ghosts(subject))
    if subject.trajectory is not None:
        words = "The motion" if subject.verified else "The motion that was not proven"
        return Scenery(subject.trajectory, f"{words}.", True, ghosts)
    if subject.path is not None:
        knots = subject.path.knots
        walk = Trajectory(subject.path.joint_names, np.linspace(0.0, WALK, len(knots)), knots)
        words = "The path that came nearest. It has no timing: the clock shows how far along it is."
        return Scenery(walk, words, False, ghosts)
    beside = {
        "blocked": "red where it is not free",
        "free": "blue the nearest that is free",
        "goal": "green the goal",
    }
    named = [beside[each.name] for each in ghosts]
    words = "; ".join(["The start", *named])
    return Scenery(None, f"{words}.", False, ghosts)


def in_space(subject: Subject, shown: Scenery) -> str:
    """Return the page in 3-D, in HTML.

    Raises:
        MissingExtra: If viser is not installed.
    """
    return recorded(subject.problem.reduced, shown.motion, shown.ghosts)


def stills(subject: Subject, shown: Scenery) -> tuple[Still, ...]:
    """Return still pictures: four moments of a motion, or the start.

    Raises:
        RenderingUnavailable: If OpenGL does not work.
    """
    from trajopt.simulation.sampled_motion import SampledMotion, moments_of, motion_of
    from trajopt.simulation.studio import Canvas, Studio

    reduced, canvas = subject.problem.reduced, Canvas(WIDTH, HEIGHT, SHADOW)
    if shown.motion is not None:
        motion = motion_of(reduced, shown.motion)
        moments = moments_of(motion, None)
        with Studio(reduced, motion, canvas, pictures=1, camera=None) as studio:
            pictures = list(studio.pictures(moments, _silent))
        of = [f"{t:.2f} s" if shown.timed else f"{t / WALK:.0%} of the way" for t in moments.tolist()]
        return tuple(Still(_jpeg(each), words) for each, words in zip(pictures, of, strict=True))
    places = [each.positions for each in shown.ghosts] or [reduced.start_positions]
    solid = places[0]
    knots = np.stack((*places[1:], solid)) if len(places) > 1 else np.stack((solid, solid))
    motion = SampledMotion(MOMENT * np.arange(len(knots), dtype=np.float64), knots)
    moments = motion.times if len(places) > 1 else motion.times[:1]
    lit = _highlighted(subject)
    with Studio(reduced, motion, canvas, pictures=len(moments), camera=None, highlight=lit) as studio:
        picture = studio.superposed(moments)
    return (Still(_jpeg(picture), _stood(shown)),)


def _ghosts(subject: Subject) -> Iterator[GhostAt]:
    """Yield copies of the robot: the blocked configuration, the nearest free one, or the goal."""
    if subject.verified:
        return
    if subject.blocked is not None:
        yield GhostAt("blocked", subject.blocked, TOUCHING)
    if subject.nearest_free is not None:
        yield GhostAt("free", subject.nearest_free, SAFE)
    if subject.blocked is None and subject.trajectory is None and subject.path is None:
        goal = _goal(subject.problem)
        if goal is not None:
            yield GhostAt("goal", goal, GOAL)


def _goal(problem: Problem) -> Floats | None:
    """Return the goal if it is one configuration, shape (n,)."""
    return None if problem.alternatives else fixed_positions(problem.goals, problem.reduced)


def _stood(shown: Scenery) -> str:
    names = {"blocked": "where it is not free", "free": "the nearest that is free", "goal": "the goal"}
    each = [names[item.name] for item in shown.ghosts] or ["the start"]
    return each[0] if len(each) == 1 else f"solid: {each[0]}; translucent: {each[1]}"


def _highlighted(subject: Subject) -> Sequence[str]:
    """Return the two bodies of the worst contact."""
    known = {*subject.problem.scene.objects, *subject.problem.scene.robot.links}
    for block in subject.explanation["blocks"].elements():
        if block["kind"].text() == "CONTACT":
            return [each.text() for each in block["subjects"].elements() if each.text() in known]
    return ()


def _jpeg(picture: object) -> bytes:
    from PIL import Image

    written = BytesIO()
    Image.fromarray(np.asarray(picture)).save(written, "JPEG", quality=QUALITY, optimize=True)
    return written.getvalue()


def _silent(_: float) -> None:
    pass
