"""The robot in a report: in 3-D on a screen, in still pictures on paper."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np

from trajopt.geometry import evaluator
from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.problem.problem import Problem
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, Value
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.drawing import Ghost
from trajopt.viewer.palette import SAFE, SURFACES, TOUCHING, Rgb
from trajopt.viewer.report.measured import Subject
from trajopt.viewer.scene_view import SceneView
from trajopt.viewer.server import close_server, open_server

if TYPE_CHECKING:
    from viser import ViserServer

ASPECT = 1.8
"""Width over height that the motion is framed for: of a page as wide as a screen, half as high."""
RATE = 25.0
"""Frames per second."""
FEWEST, MOST = 60, 600
"""Smallest and largest number of frames of a motion."""
HOST = "127.0.0.1"
"""Viser draws only on a server: on this address of this machine, while the page is made."""
AFTER = 0.002
"""Time of the clock after the motion [s], so that its end can be shown."""
EMPTY = 1
"""WebGL calls of a frame without a robot: the background."""
FRAMES = 3
"""Frames with more calls after which the scene is on the screen: a browser holds back at most two."""
BRIDGE = (
    """<script>
(() => {
  // The page around this one follows the time that is shown, may set it, and learns when the scene is drawn.
  const shown = () => document.querySelector('[role="slider"]');
  const show = (wanted) => {
    const [field, slider] = [document.querySelector("input"), shown()];
    if (!field || !slider) return;
    const end = Number(slider.getAttribute("aria-valuemax")) - AFTER;  // at its very end it begins anew
    if (end <= 0) return;  // nothing moves
    const time = Math.max(0, Math.min(wanted, end));
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(field, time.toFixed(6));
    field.dispatchEvent(new Event("input", { bubbles: true }));
  };
  let [calls, frames] = [0, 0];
  for (const name of window.WebGL2RenderingContext ? ["drawElements", "drawArrays"] : []) {
    const draw = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...given) {
      calls += 1;
      return draw.apply(this, given);
    };
  }
  let told = null;
  const tell = () => {
    const slider = shown();
    const time = slider ? Number(slider.getAttribute("aria-valuenow")) : null;
    if (told === null && time !== null) show(0);  // it would play at once, and for ever
    if (time !== told) parent.postMessage({ time }, "*");
    told = time;
    if (calls > EMPTY && ++frames === FRAMES) parent.postMessage({ drawn: true }, "*");
    calls = 0;
    requestAnimationFrame(tell);
  };
  addEventListener("message", (event) => {
    if (event.source === parent && Number.isFinite(event.data.show)) show(event.data.show);
  });
  requestAnimationFrame(tell);
})();
</script>""".replace("AFTER", str(AFTER))
    .replace("EMPTY", str(EMPTY))
    .replace("FRAMES", str(FRAMES))
)


@dataclass(frozen=True, eq=False)
class GhostAt(Value):
    """A translucent copy of the robot.

    Attributes:
        name: Name of its node in the scene.
        positions: Of the group's joints, shape (n,) [rad | m].
        colour: Of all bodies.
    """

    name: str
    positions: Floats
    colour: Rgb


def recorded(reduced: ReducedModel, trajectory: Trajectory | None, beside: Sequence[GhostAt] = ()) -> str:
    """Return a self-contained HTML page of a motion, or of the start alone.

    A page that contains it in a frame receives the shown time, `{time}` [s], and, once, that the scene is
    drawn, `{drawn: true}`, as messages; it may set the time with `{show}`.

    Args:
        reduced: Robot and scene.
        trajectory: The motion of the group's joints; None for the start alone.
        beside: Translucent copies of the robot.

    Raises:
        MissingExtra: If viser is not installed.
    """
    server = open_server(HOST, 0)
    try:
        page = _Recording(server, reduced, trajectory, beside).page()
    finally:
        close_server(server)
    head = page.index("</head>")
    return page[:head] + BRIDGE + page[head:]


class _Recording:
    """The scene, drawn frame by frame."""

    def __init__(
        self,
        server: "ViserServer",
        reduced: ReducedModel,
        trajectory: Trajectory | None,
        beside: Sequence[GhostAt],
    ) -> None:
        self._server, self._trajectory, self._beside = server, trajectory, beside
        self._start = reduced.start_positions
        duration = 0.0 if trajectory is None else trajectory.duration
        self._scene = SceneView(server, reduced, self._positions(0.0), duration=duration)
        for each in beside:
            ghost = Ghost(server, reduced, each.name, each.colour)
            ghost.stand(evaluator(reduced).kinematics(each.positions[None]))
        self._look(reduced)
        self._draw(0.0)

    def page(self) -> str:
        serializer = self._server.get_scene_serializer()
        if self._trajectory is not None:
            duration = self._trajectory.duration
            count = int(np.clip(np.ceil(RATE * duration), FEWEST, MOST))
            for number in range(1, count + 1):
                serializer.insert_sleep(duration / count)
                self._draw(duration * number / count)
            serializer.insert_sleep(AFTER)
        return serializer.as_html()

    def _look(self, reduced: ReducedModel) -> None:
        from trajopt.simulation.sampled_motion import SampledMotion, motion_of

        if self._trajectory is None:
            stood = np.stack([self._start, *(each.positions for each in self._beside), self._start])
            motion = SampledMotion(np.arange(len(stood), dtype=np.float64), stood)
            self._scene.look(motion, paths=False, aspect=ASPECT)
        else:
            self._scene.look(motion_of(reduced, self._trajectory), aspect=ASPECT)

    def _draw(self, time: float) -> None:
        self._scene.show(time, self._positions(time))

    def _positions(self, time: float) -> Floats:
        return self._start if self._trajectory is None else self._trajectory(time)


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
        timed: Whether its time is a motion's, not a walk along a path.
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
