"""`trajopt servo`: lead the simulated robot by a gamepad, the browser, or a recorded stream."""

import json
import time
from collections.abc import Callable
from math import inf
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import (
    ExactOption,
    JsonOption,
    LimitsOption,
    MotionsOption,
    PackageOption,
    RobotOption,
    RobotSource,
    SceneOption,
    SrdfOption,
)
from trajopt.cli.watched import HostOption, PortOption, say_where, watched
from trajopt.driving.servo import Servo
from trajopt.driving.servo_command import REDUCED_SPEED, ServoOptions
from trajopt.driving.servo_input import Gamepad, Player, Recorder, ServoInput, guide, read_stream
from trajopt.driving.simulated import SimulatedExecutor
from trajopt.files.moveit import read_motions, read_scene
from trajopt.problem.problem import Problem
from trajopt.problem.requirements.joints import LENGTH
from trajopt.problem.stated import only_group
from trajopt.values.errors import ProblemError, shown
from trajopt.viewer.servo_page import ServoPage, servo_page

GAMEPAD, BROWSER = "gamepad", "browser"
DEAD_ZONE = 0.08
"""Dead zone of a stick, as a share of its range."""
SMOOTHING = 0.05
"""Time constant of the smoothing of hand input [s]: intended motions are slower than 10 Hz."""
InputOption = Annotated[str, typer.Option("--input", help="gamepad, browser, or a file with a stream.")]
GroupOption = Annotated[str, typer.Option("--group", help="Group; the robot's only one where left out.")]
StartOption = Annotated[
    str, typer.Option("--start", help="Named state to begin in; the scene's where left out.")
]
FrameOption = Annotated[str, typer.Option("--frame", help="Tool that is led; the group's where left out.")]
AxesOption = Annotated[str, typer.Option("--axes", help="Frame whose axes sticks and sliders mean.")]
PeriodOption = Annotated[float, typer.Option("--period", help="Time from one tick to the next \\[s].")]
RecordOption = Annotated[
    Path | None, typer.Option("--record", help="Write what was said here as JSON, a stream for --input.")
]
ViewOption = Annotated[bool, typer.Option("--view", help="Show the robot in the browser.")]
SecondsOption = Annotated[
    float | None, typer.Option("--seconds", help="Most seconds; until Ctrl-C where left out.")
]


def servo(
    robot: RobotOption,
    scene: SceneOption,
    source: InputOption = BROWSER,
    srdf: SrdfOption = None,
    limits: LimitsOption = None,
    package_dir: PackageOption = None,
    exact_meshes: ExactOption = False,
    motions: MotionsOption = None,
    group: GroupOption = "",
    start: StartOption = "",
    frame: FrameOption = "",
    axes: AxesOption = "world",
    period: PeriodOption = 0.01,
    record: RecordOption = None,
    view: ViewOption = False,
    port: PortOption = 8080,
    host: HostOption = "127.0.0.1",
    seconds: SecondsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Lead the simulated robot by hand, clear of obstacles. Exit status 0 without a contact, 1 with one."""
    about = RobotSource(robot, srdf, limits, tuple(package_dir or ()), exact_meshes)
    problem = _problem(about, scene, motions, group, start)
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
        "events": [{"time": each.time, "kind": each.kind.value, "words": each.words} for each in led.events],
    }
    lines = [*map(str, led.events), *(f"touched: {contact}" for contact in contacts)]
    typer.echo(json.dumps(told) if as_json else "\n".join((*lines, f"led for {arm.now():.2f} s")))
    raise typer.Exit(1 if contacts else 0)


def _problem(source: RobotSource, scene: Path, motions: Path | None, group: str, start: str) -> Problem:
    """Return the robot in its scene; it is to go nowhere."""
    loaded = source.load()
    around = read_scene(scene, loaded)
    placed = around.scene if motions is None else read_motions(motions, around.scene)
    begin = around.positions if not start else loaded.positions(start, group=group or None)
    moved = loaded.group(group or only_group(loaded)).joints[0]
    there = {moved: float(begin[loaded.joint_names.index(moved)])}
    return Problem(scene=placed, group=group, start=begin, goal=there)


def _input(source: str, problem: Problem, frame: str, axes: str, port: int, host: str) -> ServoInput:
    """Open the input device.

    Raises:
        ProblemError: If there is no such input.
    """
    if source == GAMEPAD:
        return Gamepad(frame=axes)
    if source == BROWSER:
        return servo_page(problem, frame=frame, axes=axes, port=port, host=host)
    if not Path(source).is_file():
        raise ProblemError(f"--input is {GAMEPAD}, {BROWSER} or a file, is {shown(source)}")
    return Player(read_stream(source))


def _passing(arm: SimulatedExecutor, by_hand: bool) -> Callable[[float], None]:
    """Return the clock of the loop: for a hand at most as fast as wall time."""
    begun, at = time.monotonic(), arm.now()

    def wait(seconds: float) -> None:
        arm.advance(seconds)
        if by_hand:
            time.sleep(max(begun + arm.now() - at - time.monotonic(), 0.0))

    return wait
