"""`trajopt moveit`: run an unmodified MoveIt script in a simulated world."""

import logging
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import RobotSource, robot_options
from trajopt.files.moveit import read_scene

ScriptArgument = Annotated[
    Path, typer.Argument(help="Python script that imports moveit_commander and rospy, or moveit and rclpy.")
]
WordsArgument = Annotated[list[str] | None, typer.Argument(help="Arguments of the script.")]
SceneOption = Annotated[
    Path | None, typer.Option("--scene", help="MoveIt PlanningScene in YAML, at the start.")
]
StateOption = Annotated[str | None, typer.Option("--state", help="Named start state.")]
YesOption = Annotated[
    bool,
    typer.Option(
        "--yes", help="Answer each prompt of the script with Enter; the default without a terminal."
    ),
]


@robot_options
def moveit(
    robot: RobotSource,
    script: ScriptArgument,
    words: WordsArgument = None,
    scene: SceneOption = None,
    state: StateOption = None,
    yes: YesOption = False,
) -> None:
    """Run an unmodified MoveIt script in a simulated world. Exit status: the script's, 2 bad input.

    Options come before the script; arguments after it are passed to it.
    """
    # The commander takes a while to import, which other commands need not wait for.
    from trajopt.ros.commander import World
    from trajopt.ros.commander.scripts import Answering, run_script

    loaded = robot.load()
    if scene is None:
        world, notes = World(loaded, start=state), loaded.notes
    else:
        around = read_scene(scene, loaded)
        start = state if state is not None else around.state or None
        world, notes = World(loaded, scene=around.scene, start=start), (*loaded.notes, *around.notes)
    alone = yes or not sys.stdin.isatty()
    with _log_shown():
        for note in notes:
            logging.getLogger("trajopt.ros.commander").info("%s", note)
        run_script(
            script,
            words or (),
            world=world,
            stdin=Answering(None if yes else sys.stdin) if alone else None,  # type: ignore[arg-type]
        )


@contextmanager
def _log_shown() -> Generator[None]:
    log, handler = logging.getLogger("trajopt.ros.commander"), logging.StreamHandler(sys.stderr)
    handler.setFormatter(logging.Formatter("[%(levelname)s] %(message)s"))
    level = log.level
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)
