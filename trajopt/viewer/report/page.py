"""A report as one self-contained HTML page."""

from base64 import b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from trajopt.files.bundle import Holds
from trajopt.geometry import evaluator
from trajopt.lab.suite.html import status_words, table
from trajopt.optimise.terms.joint_positions import fixed_positions
from trajopt.scene.reduced import ReducedModel
from trajopt.tasks.sequence import MotionSequence
from trajopt.values.arrays import Floats, Value
from trajopt.values.documents.document import write_text
from trajopt.values.errors import RenderingUnavailable
from trajopt.values.errors.arguments import checked
from trajopt.values.printed import in_length
from trajopt.values.trajectory import Trajectory
from trajopt.viewer.drawing import Ghost
from trajopt.viewer.palette import SAFE, SURFACES, TOUCHING, Rgb
from trajopt.viewer.report import sections
from trajopt.viewer.report.measured import Reported, Subject, measured, subject_of
from trajopt.viewer.report.sections import section
from trajopt.viewer.scene_view import SceneView
from trajopt.viewer.server import close_server, open_server

if TYPE_CHECKING:
    from viser import ViserServer

ASPECT = 1.8
"""Width over height that the motion is framed for."""
RATE = 25.0
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
    // Viser focuses the field that is set, to which the page would scroll.
    field.focus = () => HTMLElement.prototype.focus.call(field, { preventScroll: true });
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
    """A translucent copy of the robot."""

    name: str
    positions: Floats
    colour: Rgb


def recorded(reduced: ReducedModel, trajectory: Trajectory | None, beside: Sequence[GhostAt] = ()) -> str:
    """Return a self-contained HTML page of a motion, or of the start alone.

    A page that contains it in a frame receives the shown time, `{time}` [s], and, once the scene is drawn,
    `{drawn: true}`, as messages; it may set the time with `{show}`.
    """
    server = open_server(HOST, 0)
    try:
        page = _recorded(server, reduced, trajectory, beside)
    finally:
        close_server(server)
    head = page.index("</head>")
    return page[:head] + BRIDGE + page[head:]


def _recorded(
    server: "ViserServer", reduced: ReducedModel, trajectory: Trajectory | None, beside: Sequence[GhostAt]
) -> str:
    from trajopt.simulation.sampled_motion import SampledMotion, motion_of

    start, duration = reduced.start_positions, 0.0 if trajectory is None else trajectory.duration

    def positions(time: float) -> Floats:
        return start if trajectory is None else trajectory(time)

    scene = SceneView(server, reduced, positions(0.0), duration=duration)
    for each in beside:
        ghost = Ghost(server, reduced, each.name, each.colour)
        ghost.stand(evaluator(reduced).kinematics(each.positions[None]))
    if trajectory is None:
        stood = np.stack([start, *(each.positions for each in beside), start])
        motion = SampledMotion(np.arange(len(stood), dtype=np.float64), stood)
        scene.look(motion, paths=False, aspect=ASPECT)
    else:
        scene.look(motion_of(reduced, trajectory), aspect=ASPECT)
    scene.show(0.0, positions(0.0))
    serializer = server.get_scene_serializer()
    if trajectory is not None:
        count = int(np.clip(np.ceil(RATE * duration), FEWEST, MOST))
        for time in (duration * np.arange(1, count + 1) / count).tolist():
            serializer.insert_sleep(duration / count)
            scene.show(time, positions(time))
        serializer.insert_sleep(AFTER)
    return serializer.as_html()


WIDTH, HEIGHT = 640, 420
"""Size of a still picture [pixels]: twice a quarter of a printed page at 150 dpi."""
SHADOW = 2048
"""Edge of the square that shadows are computed on [pixels]."""
QUALITY = 85
"""Of their JPEG: artefacts are not seen on paper."""
WALK = 4.0
"""Seconds in which a path without timing is walked along."""
GOAL = SURFACES[2]
MOMENT = 1e-3
"""Time between two configurations in one picture [s]: dynamic obstacles hardly move."""


@dataclass(frozen=True, eq=False)
class Still(Value):
    """A picture."""

    jpeg: bytes
    words: str


@dataclass(frozen=True, eq=False)
class Scenery(Value):
    """The shown scene, with the time of a motion or of a walk along a path."""

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
        "blocked": "red if it is not free",
        "free": "blue the nearest that is free",
        "goal": "green the goal",
    }
    named = [beside[each.name] for each in ghosts]
    words = "; ".join(["The start", *named])
    return Scenery(None, f"{words}.", False, ghosts)


def stills(subject: Subject, shown: Scenery) -> tuple[Still, ...]:
    """Return still pictures: four moments of a motion, or the start."""
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
    if subject.verified:
        return
    if subject.blocked is not None:
        yield GhostAt("blocked", subject.blocked, TOUCHING)
    if subject.nearest_free is not None:
        yield GhostAt("free", subject.nearest_free, SAFE)
    if subject.blocked is None and subject.trajectory is None and subject.path is None:
        problem = subject.problem
        goal = None if problem.alternatives else fixed_positions(problem.goals, problem.reduced)
        if goal is not None:
            yield GhostAt("goal", goal, GOAL)


def _stood(shown: Scenery) -> str:
    names = {"blocked": "where it is not free", "free": "the nearest that is free", "goal": "the goal"}
    each = [names[item.name] for item in shown.ghosts] or ["the start"]
    return each[0] if len(each) == 1 else f"solid: {each[0]}; translucent: {each[1]}"


def _highlighted(subject: Subject) -> Sequence[str]:
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


HERE = Path(__file__).parent
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' blob:; "
    "style-src 'unsafe-inline'; img-src data: blob:; font-src data:; connect-src data: blob:; "
    "worker-src blob:; form-action 'none'; base-uri 'none'"
)
"""Content security policy: no access outside the page. The 3-D scene unpacks itself within it."""
WITHOUT_SCRIPTS = "<noscript><style>.space { display: none; } .stills { display: grid; }</style></noscript>"
"""Style without scripts: still pictures instead of the 3-D scene."""
KINDS = {Holds.PLAN: "plan", Holds.FAILURE: "failure", Holds.PROBLEM: "problem"}


def page(subject: Subject, shown: Scenery, space: str, pictures: Sequence[Still], remark: str) -> str:
    """Return the page."""
    name = subject.problem.name or "problem"
    parts = [
        _head(subject),
        _space(shown, space, pictures),
        _stills(pictures, alone=not space),
        *_parts(subject),
    ]
    return _page(name, parts, sections.about(subject), remark)


def page_of_motions(what: MotionSequence[Any], *, moving: bool) -> str:
    """Return the page of several motions: the whole in 3-D, the cycle times, and the proof of each motion."""
    found = what.explain()
    mark = '<b class="good">✓ Proven.</b>' if what.verified else '<b class="bad">✗ No plan.</b>'
    facts = [("robot", what.scene.robot.name), ("group", what.group)]
    parts: list[str] = []
    if what.verified:
        facts += [("duration", f"{what.trajectory.duration:.3f} s"), ("motions", str(len(what.segments)))]
        if moving:
            parts.append(_frame(recorded(*what.whole), "", "The motion.", timed=True))
        parts.append(section("stages", "Cycle times", _tree(what)))
        parts.append(section("proven", "What was proven", sections.proven(what.certificate)))
    elif what.refusals:
        parts.append(section("tried", "What was tried", _tree(what)))
    head = _title("task", what.name, f"{mark} {escape(found.reason)}.", facts)
    return _page(what.name, [head, *parts], "", "")


def _tree(what: MotionSequence[Any]) -> str:
    head = ("stage", "begin", "duration", "clearance")[: 4 if what.verified else 1]
    rows = [
        (
            f'<span style="display:block;padding-left:{1.5 * row.depth}em">{escape(row.text)}</span>',
            f"{row.time.begin:.2f} s" if row.time else "",
            f"{row.time.end - row.time.begin:.2f} s" if row.time else "",
            in_length(row.clearance) if np.isfinite(row.clearance) else "",
        )[: len(head)]
        for row in what.tree
    ]
    return table(head, rows, numbers=head[1:])


def _page(name: str, parts: Sequence[str], about: str, remark: str) -> str:
    foot = about + (f"<p class=faint>{escape(remark)}</p>" if remark else "")
    style, script = ((HERE / f"page.{kind}").read_text(encoding="utf-8") for kind in ("css", "js"))
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>{escape(name)}</title>'
        f"<style>{style}</style>{WITHOUT_SCRIPTS}</head><body>{''.join(parts)}<footer>{foot}</footer>"
        f"<script>{script}</script></body></html>\n"
    )


def _parts(subject: Subject) -> list[str]:
    parts: list[str] = []
    if not subject.verified:
        parts.append(section("blocked", "What stands in the way", sections.in_the_way(subject)))
    if subject.certificate is not None:
        title = "What was proven" if subject.verified else "What the judge found"
        parts.append(section("proven", title, sections.proven(subject.certificate)))
    if subject.proof is not None:
        parts.append(section("proof", "Proof file", sections.for_another_checker(subject.proof)))
    if subject.trajectory is not None:
        seen = measured(subject.problem, subject.trajectory)
        parts.append(
            section("limits", "Where limits bind", sections.binding(seen, subject.trajectory.duration))
        )
        parts.append(section("prices", "What the constraints cost", sections.costs(subject)))
        parts.append(section("time", "Over time", "".join(map(sections.plot, seen.charts))))
    parts.append(section("tried", "What was tried", sections.tried(subject.answer)))
    parts.append(section("asked", "What was asked", sections.request(subject)))
    return parts


def _head(subject: Subject) -> str:
    problem = subject.problem
    kind = KINDS[subject.holds]
    facts = [("robot", problem.scene.robot.name), ("group", problem.group)]
    if subject.trajectory is not None:
        facts.append(("duration", f"{subject.trajectory.duration:.3f} s"))
    if subject.certificate is not None:
        told = subject.certificate.closest.removeprefix("clearance ")
        facts.append(("clearance", told))
    total = subject.answer["cpu_seconds"]["total"]
    if not total.missing:
        facts.append(("planning", f"{1000.0 * total.number():.0f} ms of CPU"))
    return _title(kind, problem.name or "problem", _verdict(subject), facts)


def _title(kind: str, name: str, verdict: str, facts: Sequence[tuple[str, str]]) -> str:
    listed = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in facts)
    return (
        f'<header><div class="over-title">trajopt report of a {kind}</div><h1>{escape(name)}</h1>'
        f'<p class="verdict">{verdict}</p><dl>{listed}</dl></header>'
    )


def _verdict(subject: Subject) -> str:
    certificate = subject.certificate
    if subject.verified and certificate is not None:
        count = sum(check.required for check in certificate.checks)
        words = f" {escape(subject.words)}." if subject.words else ""
        return f'<b class="good">✓ Proven.</b> All {count} checks of the judge hold.{words}'
    if certificate is not None and subject.status in ("", "SOLVED"):
        return f'<b class="bad">✗ Not proven.</b> {escape(certificate.verdict)}.'
    if not subject.status:
        return "It is not planned yet."
    reason = subject.answer["message"].text("").removeprefix(f"{subject.status}: ")
    words = status_words(subject.status)
    known = sections.certain(subject)
    return (
        f'<b class="bad">✗ No plan: {escape(words)}.</b> {escape(reason or sections.meaning(subject.status))}'
        + (f'<br><span class="faint">{escape(known)}</span>' if known else "")
    )


def _space(shown: Scenery, space: str, pictures: Sequence[Still]) -> str:
    if not space:
        return ""
    poster = "".join(
        f'<img class="poster" src="{_source(still)}" alt="{escape(still.words)}">' for still in pictures[:1]
    )
    return _frame(space, poster, shown.words, timed=shown.motion is not None)


def _frame(space: str, poster: str, words: str, *, timed: bool) -> str:
    return (
        '<figure class="space screen waiting"><div class="view"><iframe title="The motion in 3-D" '
        f'sandbox="allow-scripts" srcdoc="{escape(space, quote=True)}"></iframe>{poster}</div>'
        f"<figcaption>{escape(words)} "
        '<span class="turn">Drag to turn, scroll to come nearer'
        f"{'; the bar below is time' if timed else ''}.</span></figcaption></figure>"
    )


def _stills(pictures: Sequence[Still], *, alone: bool) -> str:
    if not pictures:
        return ""
    kind = f"stills{' shown' if alone else ''}{' one' if len(pictures) == 1 else ''}"
    drawn = "".join(
        f'<figure><img src="{_source(each)}" width="{WIDTH}" height="{HEIGHT}" alt="{escape(each.words)}">'
        f"<figcaption>{escape(each.words)}</figcaption></figure>"
        for each in pictures
    )
    return f'<div class="{kind}">{drawn}</div>'


def _source(picture: Still) -> str:
    return f"data:image/jpeg;base64,{b64encode(picture.jpeg).decode()}"


@checked
def write_report(
    what: Reported | MotionSequence[Any], path: Path | str, *, moving: bool = True, pictures: bool = True
) -> Path:
    """Write a report as one self-contained HTML page; return the path.

    Args:
        what: A result, a plan, an unplanned problem, or a bundle, which is drawn as by `trajopt view` after
            its meshes are unpacked (`read_bundle`); or the result of a task or of a pick and place, with its
            cycle times, or of following a curve.
        pictures: Whether to include still pictures; omitted with a remark without OpenGL.

    Raises:
        MissingExtra: If the 3-D motion is requested, and viser is not installed.
        FileFormatError: If the file cannot be written, or a bundle is invalid.
    """
    if isinstance(what, MotionSequence):
        write_text(path, page_of_motions(what, moving=moving))
        return Path(path)
    subject = subject_of(what)
    shown = scenery(subject)
    remark, drawn = "", ()
    if pictures:
        try:
            drawn = stills(subject, shown)
        except RenderingUnavailable as missing:
            remark = f"There are no still pictures: {missing}"
    space = recorded(subject.problem.reduced, shown.motion, shown.ghosts) if moving else ""
    write_text(path, page(subject, shown, space, drawn, remark))
    return Path(path)
