"""Typical mistakes and their messages: the source of docs/mistakes.md.

`python -m tests.mistakes` writes the page; `tests/test_mistakes.py` keeps it true.
"""

import warnings
from collections.abc import Iterator, Mapping
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import trajopt as to
from trajopt.files.moveit import read_request, read_scene
from trajopt.tasks.cartesian import follows_curve, polyline
from trajopt.tasks.grasping import gripper_of
from trajopt.values.errors import TrajoptError, UnitWarning

PAGE = Path(__file__).parents[1] / "docs" / "mistakes.md"

HEAD = """# Typical mistakes and their messages

Misuse raises a `TrajoptError` immediately. It is also the builtin error that it refines (`ValueError`,
`KeyError`, ...), names the argument and lists near matches of a name. A valid number with a probable unit
error is accepted with a `UnitWarning` (`trajopt.values.errors`). A failure to find a plan is not an error:
planning returns a result with a status and a reason; the last section has examples.

In the code, `panda` is `to.load("panda")`, `scene` contains a box named "table", `goal` is a joint position,
`AT` is a placement, and `problem` is a `to.Problem` of these; `planned(...)` creates it with other arguments.

A test compares this page with the actual messages (`python -m tests.mistakes` writes it).
"""


@dataclass(frozen=True)
class Mistake:
    """A line of code with a mistake.

    Attributes:
        code: The line.
        error: Name of the error that it raises, or of the status if planning ends without a plan.
        listed: Whether the page lists it; it omits a line whose message resembles another one's.
    """

    code: str
    error: str
    listed: bool = True


SECTIONS: Mapping[str, tuple[Mistake, ...]] = {
    "Names": (
        Mistake('to.load("pandas")', "RobotNotFound"),
        Mistake('to.named_problem("cup_past_pilar")', "ProblemNotFound", listed=False),
        Mistake('panda.group("panda_amr")', "GroupNotFound"),
        Mistake('panda.positions("redy")', "StateNotFound"),
        Mistake('panda.positions({"panda_joint8": 0.1})', "JointNotFound"),
        Mistake('scene.object("tabel")', "ObjectNotFound"),
        Mistake('scene.object("panda_hand")', "ObjectNotFound"),
        Mistake('scene.add("table", to.Sphere(0.1))', "DuplicateObject"),
        Mistake('scene.add("panda_hand", to.Sphere(0.1))', "ModelError"),
        Mistake('scene.add("cup", to.Sphere(0.1), AT, frame="tabel")', "FrameNotFound"),
        Mistake('scene.attach("table", "panda_hnad", placement=AT)', "FrameNotFound", listed=False),
        Mistake(
            'scene.attach("table", "panda_hand", placement=AT, touch_links="panda_hand")', "ProblemError"
        ),
        Mistake('scene.allow("table", "panda_link99")', "FrameNotFound", listed=False),
        Mistake('scene.with_tool("tcp", on="panda_flange")', "FrameNotFound"),
        Mistake('scene.with_tool("panda_hand", on="panda_link8")', "ModelError"),
        Mistake('to.plan(problem, method="chmop")', "SolverNotFound"),
        Mistake('planned(goal=to.joint_positions({"panda_joint0": 1.0}))', "JointNotFound", listed=False),
        Mistake('planned(goal=to.frame_placement("panda_tcp", AT))', "FrameNotFound", listed=False),
        Mistake('planned(goal="redy")', "StateNotFound", listed=False),
        Mistake('planned(goal="open")', "StateNotFound"),
        Mistake('planned(goal=to.any_of({"home": "redy", "shelf": AT}))', "StateNotFound", listed=False),
        Mistake('planned(constraints=[to.during(to.gravity_torque(0.5), after="via")])', "WaypointNotFound"),
        Mistake('planned(start_velocity={"panda_finger_joint1": 0.01})', "JointNotFound", listed=False),
        Mistake('to.joint_positions({"panda_joint1": 1.0}, below={"panda_joint2": 0.1})', "JointNotFound"),
    ),
    "Units": (
        Mistake("to.Box(400, 300, 20)", "SizeError"),
        Mistake("to.placement((0.4, 0, 0.3), quaternion=(0, 0, 0, 0))", "ShapeError"),
        Mistake('scene.add("cup", to.Sphere(0.03), to.placement((400, 0, 300)))', "UnitWarning"),
        Mistake("to.placement((0.4, 0, 0.3), rpy=(180, 0, 0))", "UnitWarning"),
        Mistake('to.frame_placement("panda_hand", AT, rotation_tolerance=10)', "UnitWarning", listed=False),
        Mistake('to.frame_placement("panda_hand", AT, position_tolerance=5)', "UnitWarning", listed=False),
        Mistake('to.tool_speed("panda_hand", linear=250)', "UnitWarning"),
        Mistake('to.gaze("panda_hand", (1, 0, 0), angle=30)', "ShapeError"),
        Mistake(
            'to.point_on_arc("panda_hand", AT, radius=0.1, tolerance=0.001, sweep=90)',
            "ProblemError",
            listed=False,
        ),
        Mistake('planned(goal=to.joint_positions({"panda_finger_joint1": 2}, degrees=True))', "ProblemError"),
        Mistake('to.axis_alignment("panda_hand", tolerance=5)', "ShapeError", listed=False),
        Mistake('planned(start_velocity={"panda_joint1": 90})', "ProblemError"),
        Mistake("planned(velocity_scaling=50)", "ProblemError"),
        Mistake("scene.with_margin(-0.01)", "ShapeError"),
        Mistake('scene.add("brick", to.Box(0.1, 0.1, 0.1), mass=-1)', "ShapeError", listed=False),
        Mistake("to.gravity_torque(50)", "ProblemError"),
        Mistake('to.tool_speed("panda_hand", linear=0)', "ProblemError", listed=False),
    ),
    "Shapes and numbers": (
        Mistake("planned(start=[0.0] * 8)", "ShapeError"),
        Mistake("planned(start=[0.0] * 6)", "ShapeError"),
        Mistake("planned(start=None)", "ProblemError", listed=False),
        Mistake("planned(start=[np.nan] * 9)", "ShapeError"),
        Mistake("to.plan_once(problem, np.zeros((10, 7)))", "ShapeError"),
        Mistake("to.placement((0.4, 0.3))", "ShapeError"),
        Mistake('to.frame_placement("panda_hand", (0.4, 0, 0.3))', "ShapeError"),
        Mistake('to.frame_placement("panda_hand", AT, position_tolerance=-0.001)', "ProblemError"),
        Mistake(
            'to.frame_placement("panda_hand", AT, position_tolerance=np.inf, rotation_tolerance=np.inf)',
            "ProblemError",
        ),
        Mistake('to.axis_alignment("panda_hand", axis=(0, 0, 0), tolerance=0.1)', "ShapeError", listed=False),
        Mistake('to.distance_between("panda_hand", "table", lower=0.5, upper=0.1)', "ProblemError"),
        Mistake('to.joint_positions({"panda_joint1": "left"})', "ShapeError"),
        Mistake('to.Trajectory(("a",), [0.0, 1.0, 0.5], [[0.0], [1.0], [2.0]])', "ShapeError"),
        Mistake('to.Cost("short")', "ProblemError"),
        Mistake("planned(knots=2)", "ProblemError"),
        Mistake("to.Budget(seconds=-1)", "ProblemError"),
        Mistake("polyline([AT])", "ProblemError"),
        Mistake('follows_curve("panda_hand", polyline([AT, AT]))', "ProblemError"),
    ),
    "The wrong kind of thing": (
        Mistake("to.Scene('panda')", "ProblemError"),
        Mistake("to.Problem(scene=panda, start={}, goal=goal)", "ProblemError"),
        Mistake("to.Problem(scene=scene, start={}, goal=goal)", "ProblemError"),
        Mistake("planned(goal=(0.4, 0.0, 0.3))", "ProblemError"),
        Mistake("planned(goal=[0.0, -0.8, 0.0, -2.4, 0.0])", "ProblemError", listed=False),
        Mistake('planned(goal=AT, group="hand")', "ProblemError"),
        Mistake("planned(goal=[])", "ProblemError"),
        Mistake('planned(goal=to.any_of({"shelf": 0.4}))', "ProblemError", listed=False),
        Mistake('planned(constraints=["upright"])', "ProblemError"),
        Mistake("planned(constraints=goal)", "ProblemError"),
        Mistake("planned(costs=[1.0])", "ProblemError", listed=False),
        Mistake("planned(tool_speed=0.25)", "ProblemError", listed=False),
        Mistake("to.joint_positions([0.1, 0.2])", "ProblemError"),
        Mistake("to.plan(scene)", "ProblemError"),
        Mistake("to.plan(problem, rng=42)", "ProblemError"),
        Mistake("to.plan(problem, budget=2.0)", "ProblemError", listed=False),
        Mistake("to.plan(problem, seconds=1.0, budget=to.Budget(seconds=2.0))", "ProblemError"),
        Mistake("to.examine(problem, np.zeros(7))", "ProblemError", listed=False),
        Mistake('scene.add("cup", "sphere", AT)', "ModelError"),
        Mistake('scene.attach("table", "panda_hand")', "ModelError"),
        Mistake('scene.with_clearance(0.05, "table")', "ModelError"),
        Mistake('scene.detach("table", at=np.zeros(9))', "ModelError"),
        Mistake('gripper_of(to.load("ur5"))', "GripperError"),
    ),
    "Files": (
        Mistake('to.load("robots/arm.urdf")', "RobotNotFound"),
        Mistake('to.load("text.urdf")', "FileFormatError"),
        Mistake('to.load(".")', "FileFormatError", listed=False),
        Mistake('to.load_mesh("bracket.stl")', "MeshFileError"),
        Mistake('read_scene("missing.yaml", panda)', "FileFormatError"),
        Mistake('read_scene("text.urdf", panda)', "FileFormatError"),
        Mistake('read_request("unknown_joint.yaml", scene)', "JointNotFound"),
    ),
    "Results without a plan": (
        Mistake('planned(goal=to.joint_positions({"panda_joint1": 3.0}))', "GOAL_OUT_OF_LIMITS"),
        Mistake('planned(goal=to.joint_positions({"panda_joint1": 90}))', "GOAL_OUT_OF_LIMITS"),
        Mistake('planned(group="hand", goal={"panda_finger_joint1": 20})', "GOAL_OUT_OF_LIMITS"),
        Mistake(
            'planned(start={"panda_joint1": 90, "panda_joint4": -90})', "START_OUT_OF_LIMITS", listed=False
        ),
        Mistake("planned(goal=to.placement((400, 0, 300)))", "NO_INVERSE_KINEMATICS"),
        Mistake(
            'planned(goal=to.frame_placement("panda_hand", to.placement((2.0, 0, 0.5))))',
            "NO_INVERSE_KINEMATICS",
            listed=False,
        ),
        Mistake(
            'planned(goal=to.frame_placement("panda_hand", to.placement((0.1, 0, 1.15), rpy=(np.pi, 0, 0))))',
            "NO_INVERSE_KINEMATICS",
        ),
        Mistake('planned(start={"panda_joint4": -0.1, "panda_joint2": 1.7})', "START_IN_COLLISION"),
        Mistake('planned(scene=scene.add("part", to.Box(30, 40, 50)))', "START_IN_COLLISION", listed=False),
        Mistake("planned(scene=scene.with_clearance(0.12))", "CLEARANCE_IMPOSSIBLE"),
        Mistake('planned(start={"panda_joint1": 3.0})', "START_OUT_OF_LIMITS", listed=False),
        Mistake(
            'planned(goal=to.frame_placement("panda_hand", to.placement((0.5, 0, -0.05))))',
            "GOAL_IN_COLLISION",
        ),
    ),
}
FILES: Mapping[str, str] = {
    "text.urdf": "hello\n",
    "unknown_joint.yaml": "group_name: panda_arm\n"
    "goal_constraints: [{joint_constraints: [{joint_name: panda_joint9, position: 0.1}]}]\n",
}
"""Files that the lines name."""


def namespace() -> dict[str, object]:
    """What the lines may name."""
    panda = to.load("panda")
    table = to.Box(0.9, 1.4, 0.04)
    scene = to.Scene(panda).add("table", table, to.placement((0.65, 0.0, -0.02)))
    goal = to.joint_positions({"panda_joint1": 0.2})

    def planned(**changes: object) -> to.Problem:
        fields: dict[str, object] = {"scene": scene, "group": "panda_arm", "start": "ready", "goal": goal}
        return to.Problem(**{**fields, **changes})  # type: ignore[arg-type]

    return {
        "to": to, "np": np, "panda": panda, "scene": scene, "goal": goal, "AT": to.placement((0.4, 0.0, 0.3)),
        "problem": planned(), "planned": planned, "polyline": polyline, "follows_curve": follows_curve,
        "gripper_of": gripper_of, "read_scene": read_scene,
        "read_request": read_request,
    }  # fmt: skip


def said(mistake: Mistake, names: Mapping[str, object]) -> tuple[str, str]:
    """Return the name of the error, or of the status, and the message."""
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always", UnitWarning)
        try:
            value = eval(mistake.code, dict(names))
        except TrajoptError as error:
            return type(error).__name__, str(error)
    if warned:
        return type(warned[0].message).__name__, str(warned[0].message)
    assert isinstance(value, to.Problem), f"{mistake.code}: raises nothing"
    result = to.plan(value)
    return result.status.name, result.reason.removeprefix(f"{result.status.name}: ")


def answers() -> Iterator[tuple[str, Mistake, str, str]]:
    """Make every mistake in a folder with the files, and yield its section and what was said."""
    names = namespace()
    with TemporaryDirectory() as folder, chdir(folder):
        for name, text in FILES.items():
            Path(name).write_text(text)
        for section, mistakes in SECTIONS.items():
            for mistake in mistakes:
                yield section, mistake, *said(mistake, names)


def page() -> str:
    """Return the page."""
    lines, last = [HEAD.rstrip("\n")], ""
    for section, mistake, kind, message in answers():
        if not mistake.listed:
            continue
        if section != last:
            lines += ["", f"## {section}", "", "| code | message |", "|---|---|"]
            last = section
        cells = (f"`{mistake.code}`", f"**{kind}** {message}")
        lines.append(
            "| " + " | ".join(cell.replace("|", "\\|").replace("<", "&lt;") for cell in cells) + " |"
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    PAGE.write_text(page())
