"""Options that commands share, and the robot, scene and request that they name."""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path
from typing import Annotated, cast

import typer

from trajopt.cli.progress import status_line
from trajopt.files.moveit import RequestFile, SceneFile, read_motions, read_request, read_scene
from trajopt.planning.budget import Budget
from trajopt.problem.problem import Problem
from trajopt.robot.load import load
from trajopt.robot.mesh_cover import MeshPolicy
from trajopt.robot.robot import Robot
from trajopt.values.documents.files import number_of
from trajopt.values.errors import FileFormatError, ProblemError, shown

ROBOT_HELP = (
    "Installed robot (panda, ur5, ...), or a URDF, xacro or MJCF file, which is read with bounds on time, "
    "memory and the files that it may open."
)
"""Help text of `--robot`."""
RobotOption = Annotated[str, typer.Option("--robot", help=ROBOT_HELP)]
SceneOption = Annotated[Path, typer.Option("--scene", help="MoveIt PlanningScene in YAML.")]
RequestOption = Annotated[Path, typer.Option("--request", help="MoveIt MotionPlanRequest in YAML.")]
SrdfOption = Annotated[Path | None, typer.Option("--srdf", help="With a URDF file: its SRDF.")]
LimitsOption = Annotated[
    Path | None, typer.Option("--limits", help="With a URDF file: MoveIt's joint_limits.yaml.")
]
PackageOption = Annotated[
    list[Path] | None,
    typer.Option("--package-dir", help="With a URDF file: where package:// meshes are (repeatable)."),
]
MotionsOption = Annotated[
    Path | None,
    typer.Option("--motions", help="How objects of the scene move, appear and expire (YAML, JSON)."),
]
TorqueOption = Annotated[
    float,
    typer.Option("--torque-scaling", metavar="X", help="Factor on the limits of torque; inf turns them off."),
]
JerkOption = Annotated[
    bool,
    typer.Option("--limit-jerk", help="Limit the jerk of joints that state no limit: acceleration in 0.1 s."),
]
ExactOption = Annotated[
    bool,
    typer.Option("--exact-meshes", help="With a URDF file: keep collision meshes as triangles."),
]
PortfolioOption = Annotated[
    bool,
    typer.Option(
        "--portfolio/--no-portfolio",
        help="Other seeds where the straight line fails; without, the straight line alone.",
    ),
]
TimeBudgetOption = Annotated[
    float | None, typer.Option("--time-budget", metavar="S", help=r"Time that planning may take \[s].")
]
DwellOption = Annotated[
    float, typer.Option("--dwell", help=r"Stay clear at the goal, at rest, for so long after the end \[s].")
]
FinishByOption = Annotated[
    float | None,
    typer.Option("--finish-by", help=r"Be at the goal so long after the start, or sooner \[s]."),
]
ExperienceOption = Annotated[
    Path | None,
    typer.Option(
        "--experience",
        help="Begin from similar motions in this warehouse, and remember new ones.",
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON in place of text.")]


@dataclass(frozen=True)
class Ending:
    """Requirements on the end of a motion, in addition to the request.

    Attributes:
        dwell: Time for which the robot stays clear at the goal [s].
        finish_by: Deadline [s]; None without one.
    """

    dwell: float = 0.0
    finish_by: float | None = None

    def of(self, problem: Problem) -> Problem:
        """Return a problem with these requirements.

        Raises:
            ProblemError: If a time is negative, or the deadline is not after the start.
        """
        return replace(problem, dwell=self.dwell, finish_by=self.finish_by)

    def as_dict(self) -> dict[str, object]:
        """Return plain data."""
        asked = {"dwell": self.dwell or None, "finish_by": self.finish_by}
        return {name: value for name, value in asked.items() if value is not None}


@dataclass(frozen=True)
class RobotSource:
    """The source of a robot: a name, or files.

    Attributes:
        robot: Name of an installed robot or path of a URDF file.
        srdf: SRDF file.
        limits: MoveIt's `joint_limits.yaml`.
        package_dirs: Folders of packages.
        exact_meshes: Whether collision meshes stay triangles.
        torque_scaling: Factor on the torque limits.
        limit_jerk: Whether joints without a jerk limit get one.
    """

    robot: str
    srdf: Path | None = None
    limits: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    exact_meshes: bool = False
    torque_scaling: float = 1.0
    limit_jerk: bool = False

    def load(self) -> Robot:
        """Load the robot; print a line while the convex pieces of new meshes are computed."""
        with status_line(f"loading {self.robot}: covering its meshes, once"):
            return self._load()

    def _load(self) -> Robot:
        return load(
            self.robot,
            srdf=self.srdf,
            limits=self.limits,
            package_dirs=self.package_dirs,
            meshes=MeshPolicy(exact=True) if self.exact_meshes else None,
            torque_scaling=self.torque_scaling,
            limit_jerk=self.limit_jerk,
        )

    def as_dict(self) -> dict[str, object]:
        """Return plain data from which `from_dict` makes the same source, on this machine."""
        is_file = Path(self.robot).is_file()
        return {
            "robot": str(Path(self.robot).resolve()) if is_file else self.robot,
            "srdf": None if self.srdf is None else str(self.srdf.resolve()),
            "limits": None if self.limits is None else str(self.limits.resolve()),
            "package_dirs": [str(folder.resolve()) for folder in self.package_dirs],
            "exact_meshes": self.exact_meshes,
            "torque_scaling": self.torque_scaling if isfinite(self.torque_scaling) else None,
            "limit_jerk": self.limit_jerk,
        }

    @staticmethod
    def from_dict(path: Path, document: dict[str, object]) -> "RobotSource":
        """Read the data of `as_dict`.

        Raises:
            FileFormatError: If it names no robot.
        """
        robot, folders = document.get("robot"), document.get("package_dirs")
        if not isinstance(robot, str):
            raise FileFormatError(str(path), "names no robot; give --robot, --scene and --request")
        srdf, limits = document.get("srdf"), document.get("limits")
        return RobotSource(
            robot,
            Path(srdf) if isinstance(srdf, str) else None,
            Path(limits) if isinstance(limits, str) else None,
            tuple(Path(str(folder)) for folder in cast("list[object]", folders))
            if isinstance(folders, list)
            else (),
            bool(document.get("exact_meshes")),
            _torque_scaling(path, document.get("torque_scaling", 1.0)),
            bool(document.get("limit_jerk")),
        )


def _torque_scaling(path: Path, written: object) -> float:
    """Return the factor in a file; missing for infinity, which JSON does not have."""
    found = inf if written is None else number_of(written)
    if found is None:
        raise FileFormatError(str(path), f"torque_scaling must be a number or null, is {shown(written)}")
    return found


def budget_of(
    time_budget: float | None,
    portfolio: bool,
    *,
    improve: bool = False,
    workers: int = 1,
    clock: Callable[[], float] = time.monotonic,
) -> Budget:
    """Return the budget of the options.

    Raises:
        ProblemError: If they contradict each other, or improvement has no end.
    """
    if improve and time_budget is None and portfolio:
        raise ProblemError("--improve uses the whole time budget: give --time-budget, in seconds, too")
    attempts = None if portfolio else 1
    return Budget(time_budget, attempts=attempts, workers=workers, improve=improve, clock=clock)


def read_files(
    robot: Robot, scene: Path, request: Path, motions: Path | None = None
) -> tuple[SceneFile, RequestFile]:
    """Read a scene, optionally the motions of its objects, and a request.

    Raises:
        FileFormatError: If a file is missing or invalid.
    """
    around = read_scene(scene, robot)
    if motions is not None:
        around = replace(around, scene=read_motions(motions, around.scene))
    return around, read_request(request, around)
