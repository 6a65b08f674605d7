"""`trajopt run` and `servo`: commands that drive the simulated robot."""

import json
import sys
import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from trajopt.cli.options import (
    GroupOption,
    HostOption,
    JsonOption,
    MotionsOption,
    PortOption,
    RequestOption,
    RobotSource,
    SceneOption,
    SecondsOption,
    read_files,
    robot_options,
)
from trajopt.driving.commit_loop import CommitLoop
from trajopt.driving.recording import Logbook, Recording, write_recording
from trajopt.driving.rehearsal import RunReport, TaskReport
from trajopt.driving.rehearsal import run as drive
from trajopt.driving.run_log import write_mcap, write_rerun
from trajopt.driving.servo import Servo
from trajopt.driving.servo_command import REDUCED_SPEED, ServoOptions
from trajopt.driving.servo_input import Gamepad, Player, Recorder, ServoInput, guide, read_stream
from trajopt.driving.simulated import TOLERANCE, SimulatedExecutor
from trajopt.driving.surprises import NONE, Surprises, random_surprise, read_surprises, undisturbed
from trajopt.files.moveit import read_motions, read_scene
from trajopt.problem.problem import Problem
from trajopt.problem.requirements.joints import LENGTH
from trajopt.problem.stated import only_group
from trajopt.simulation import render
from trajopt.simulation.picture_files import check_path
from trajopt.values.documents.document import write_json
from trajopt.values.errors import ProblemError, shown
from trajopt.values.placement import WORLD
from trajopt.viewer.mirror import RunPublisher
from trajopt.viewer.run_viewer import RunViewer, watch_run
from trajopt.viewer.servo_page import ServoPage, servo_page


class Watching:
    """The observer of a run, called after each cycle."""

    def __init__(self, viewer: RunViewer | None, publisher: RunPublisher | None = None) -> None:
        self._viewer, self._publisher, self._logbook = viewer, publisher, Logbook()
        self._begun: tuple[float, float] | None = None

    def look(self, watched: CommitLoop) -> None:
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
        return self._logbook.recording if self._viewer is None else self._viewer.recording

    def linger(self, seconds: float | None) -> None:
        if self._viewer is not None:
            self._viewer.wait(seconds)


def say_where(url: str, *, as_json: bool, how: str = "open") -> None:
    if not as_json or sys.stderr.isatty():
        typer.echo(f"{how} {url} (Ctrl-C ends)", err=as_json)


@contextmanager
def watched(
    problem: Problem, *, view: bool, port: int, host: str, as_json: bool, publish: int | None = None
) -> Generator[Watching]:
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


RANDOM = "random:"
SurprisesOption = Annotated[
    str,
    typer.Option(
        "--surprises",
        help="Unannounced events: a YAML file, or random:SEED for a box that appears on the path.",
    ),
]
LongestOption = Annotated[float, typer.Option("--longest", help="Time limit, in simulated seconds.")]
ToleranceOption = Annotated[
    float,
    typer.Option(
        "--tolerance",
        help="Largest tracking error of each joint \\[rad] or \\[m], as of your driver.",
    ),
]
OutOption = Annotated[
    Path | None, typer.Option("--out", help="Write the events and the measured motion here as JSON.")
]
RecordOption = Annotated[
    Path | None,
    typer.Option(
        "--record",
        help="Record the run here: JSON for `trajopt view FILE`, a log for Foxglove (.mcap) or Rerun (.rrd).",
    ),
]
ViewOption = Annotated[bool, typer.Option("--view", help="Show the run in the browser in real time.")]
PublishOption = Annotated[
    int | None,
    typer.Option(
        "--publish", help="Publish the run on this port, for trajopt view --mirror http://HOST:PORT."
    ),
]
PictureOption = Annotated[
    list[Path] | None,
    typer.Option("--picture", help="Draw the run here: .png, .gif or .mp4 (repeatable)."),
]


@robot_options
def run(
    robot: RobotSource,
    scene: SceneOption,
    request: RequestOption,
    motions: MotionsOption = None,
    surprises: SurprisesOption = "",
    longest: LongestOption = 60.0,
    tolerance: ToleranceOption = TOLERANCE,
    out: OutOption = None,
    picture: PictureOption = None,
    record: RecordOption = None,
    view: ViewOption = False,
    publish: PublishOption = None,
    port: PortOption = 8080,
    host: HostOption = "127.0.0.1",
    seconds: SecondsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Plan and drive the simulated robot. Exit status 0 reached, 1 not or a contact at fault, 2 bad input."""
    for path in picture or ():
        check_path(path)
    problem = read_files(robot.load(), scene, request, motions)[1].problem()
    happening = _surprises(problem, surprises, tolerance)
    with watched(problem, view=view, port=port, host=host, as_json=as_json, publish=publish) as page:
        driven = drive(problem, surprises=happening, longest=longest, tolerance=tolerance, watch=page.look)
        if record is not None:
            write_run(record, page.recording, robot)
        page.linger(seconds)
    world = happening.world(problem.scene)
    for path in picture or ():
        render(replace(problem, scene=world).reduced, driven.measured, path)
    end_run(driven, out, as_json=as_json)


def write_run(path: Path, recording: Recording, robot: RobotSource) -> None:
    match path.suffix.lower():
        case ".mcap":
            write_mcap(path, recording)
        case ".rrd":
            write_rerun(path, recording)
        case _:
            write_recording(path, recording, robot.as_dict())


def _surprises(problem: Problem, words: str, tolerance: float) -> Surprises:
    if not words:
        return NONE
    if not words.startswith(RANDOM):
        return read_surprises(words)
    seed = words.removeprefix(RANDOM)
    if not seed.isdigit():
        raise ProblemError(f"--surprises random:SEED takes a whole number, is {shown(words)}")
    return random_surprise(problem, undisturbed(problem, tolerance=tolerance), int(seed))


def end_run(driven: RunReport | TaskReport, out: Path | None, *, as_json: bool) -> NoReturn:
    document = driven.as_dict()
    if out is not None:
        write_json(out, {**document, "measured": driven.measured.as_dict()})
    touched = (f"touched: {contact}" for contact in driven.contacts)
    words = "\n".join([*map(str, driven.events), str(driven), *touched])
    typer.echo(json.dumps(document, allow_nan=False) if as_json else words)
    raise typer.Exit(0 if driven.succeeded else 1)


GAMEPAD, BROWSER = "gamepad", "browser"
DEAD_ZONE = 0.08
"""Dead zone of a stick, as a share of its range."""
SMOOTHING = 0.05
"""Time constant of the smoothing of hand input [s]: intended motions are slower than 10 Hz."""
InputOption = Annotated[
    str, typer.Option("--input", help="gamepad, browser, or a file of recorded commands.")
]
ServoStateOption = Annotated[str, typer.Option("--start", help="Named start state; default: the scene's.")]
FrameOption = Annotated[str, typer.Option("--frame", help="Controlled frame; default: the group's tip.")]
AxesOption = Annotated[str, typer.Option("--axes", help="Frame of the commands.")]
PeriodOption = Annotated[float, typer.Option("--period", help="Control period \\[s].")]
StreamOption = Annotated[
    Path | None, typer.Option("--record", help="Record the commands here as JSON, for --input.")
]
ServoViewOption = Annotated[bool, typer.Option("--view", help="Show the robot in the browser.")]
DurationOption = Annotated[
    float | None, typer.Option("--seconds", help="Time limit \\[s]; default: until Ctrl-C.")
]


@robot_options
def servo(
    robot: RobotSource,
    scene: SceneOption,
    source: InputOption = BROWSER,
    motions: MotionsOption = None,
    group: GroupOption = "",
    start: ServoStateOption = "",
    frame: FrameOption = "",
    axes: AxesOption = "world",
    period: PeriodOption = 0.01,
    record: StreamOption = None,
    view: ServoViewOption = False,
    port: PortOption = 8080,
    host: HostOption = "127.0.0.1",
    seconds: DurationOption = None,
    as_json: JsonOption = False,
) -> None:
    """Control the simulated robot by hand, clear of obstacles. Exit status 0 without contacts, 1 with one."""
    problem = _still_problem(robot, scene, motions, group, start)
    said = _input(source, problem, frame, axes, port, host)
    by_hand = source in (GAMEPAD, BROWSER)
    options = ServoOptions(period=period)
    if by_hand:
        options = ServoOptions(
            period=period,
            scaling=REDUCED_SPEED,
            turning=1.0 / LENGTH,
            dead_zone=DEAD_ZONE if source == GAMEPAD else 0.0,
            smoothing=SMOOTHING,
        )
    arm = SimulatedExecutor(problem.scene, problem.start_positions)
    led, recorder = Servo(arm, problem, options, frame), Recorder(said)
    with watched(problem, view=view and source != BROWSER, port=port, host=host, as_json=as_json) as page:
        if isinstance(said, ServoPage):
            say_where(said.url, as_json=as_json)
        look = said.look if isinstance(said, ServoPage) else page.look if view else None
        longest = inf if seconds is None else seconds
        try:
            guide(led, recorder, _passing(arm, by_hand), longest=longest, each=look)
        except KeyboardInterrupt:
            led.release("ended")
        finally:
            recorder.close()
    if record is not None:
        recorder.stream.write(record)
    contacts = [str(contact) for contact in arm.contacts if contact.allowance is None]
    told = {
        "duration": arm.now(),
        "contacts": contacts,
        "events": [each.as_dict() for each in led.events],
    }
    lines = [*map(str, led.events), *(f"touched: {contact}" for contact in contacts)]
    typer.echo(json.dumps(told) if as_json else "\n".join((*lines, f"led for {arm.now():.2f} s")))
    raise typer.Exit(1 if contacts else 0)


def _still_problem(source: RobotSource, scene: Path, motions: Path | None, group: str, start: str) -> Problem:
    loaded = source.load()
    around = read_scene(scene, loaded)
    placed = around.scene if motions is None else read_motions(motions, around.scene)
    begin = around.positions if not start else loaded.positions(start, group=group or None)
    moved = loaded.group(group or only_group(loaded)).joints[0]
    there = {moved: float(begin[loaded.joint_names.index(moved)])}
    return Problem(scene=placed, group=group, start=begin, goal=there)


def _input(source: str, problem: Problem, frame: str, axes: str, port: int, host: str) -> ServoInput:
    if axes != WORLD:
        problem.reduced.attachment(axes)
    if source == GAMEPAD:
        return Gamepad(frame=axes)
    if source == BROWSER:
        return servo_page(problem, frame=frame, axes=axes, port=port, host=host)
    if not Path(source).is_file():
        raise ProblemError(f"--input is {GAMEPAD}, {BROWSER} or a file, is {shown(source)}")
    return Player(read_stream(source))


def _passing(arm: SimulatedExecutor, by_hand: bool) -> Callable[[float], None]:
    begun, at = time.monotonic(), arm.now()

    def wait(seconds: float) -> None:
        arm.advance(seconds)
        if by_hand:
            time.sleep(max(begun + arm.now() - at - time.monotonic(), 0.0))

    return wait
