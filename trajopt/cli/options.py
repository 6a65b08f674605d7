"""Options that commands share, and the robot, scene and request that they name."""

import inspect
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf, isfinite
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from trajopt.cli.progress import status_line
from trajopt.files.moveit import RequestFile, SceneFile, read_motions, read_request, read_scene
from trajopt.planning.budget import Budget
from trajopt.problem.problem import Problem
from trajopt.robot.bodies import MeshPolicy
from trajopt.robot.load import load
from trajopt.robot.robot import Robot
from trajopt.values.documents.files import number_of
from trajopt.values.errors import FileFormatError, ModelError, ProblemError, shown

ROBOT_HELP = (
    "Installed robot (panda, ur5, ...), or a URDF, xacro or MJCF file, which is read with bounds on time, "
    "memory and the files that it may open."
)
SceneOption = Annotated[Path, typer.Option("--scene", help="MoveIt PlanningScene in YAML.")]
RequestOption = Annotated[Path, typer.Option("--request", help="MoveIt MotionPlanRequest in YAML.")]
SrdfOption = Annotated[Path | None, typer.Option("--srdf", help="With a URDF file: its SRDF.")]
PackageOption = Annotated[
    list[Path] | None,
    typer.Option("--package-dir", help="With a URDF file: folder of package:// meshes (repeatable)."),
]
GroupOption = Annotated[str, typer.Option("--group", help="Planning group; default: the only one.")]
MotionsOption = Annotated[
    Path | None,
    typer.Option("--motions", help="Motions, appearance and expiry of the scene's objects (YAML or JSON)."),
]
PortfolioOption = Annotated[
    bool,
    typer.Option(
        "--portfolio/--no-portfolio",
        help="Whether to try other seeds if the straight line fails.",
    ),
]
TimeBudgetOption = Annotated[
    float | None, typer.Option("--time-budget", metavar="S", help=r"Time limit of planning \[s].")
]
DwellOption = Annotated[
    float, typer.Option("--dwell", help=r"Time at rest at the goal, free of collisions \[s].")
]
FinishByOption = Annotated[
    float | None,
    typer.Option("--finish-by", help=r"Latest arrival at the goal, from the start \[s]."),
]
ExperienceOption = Annotated[
    Path | None,
    typer.Option(
        "--experience",
        help="Warehouse of motions: similar ones are tried first, new ones are stored.",
    ),
]
PortOption = Annotated[int, typer.Option("--port", help="Port of the page.")]
HostOption = Annotated[str, typer.Option("--host", help="Address of the page.")]
SecondsOption = Annotated[
    float | None, typer.Option("--seconds", help="Close after this time \\[s]; default: on Ctrl-C.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]


@dataclass(frozen=True)
class Ending:
    """Dwell clear at the goal, and deadline [s], in addition to the request."""

    dwell: float = 0.0
    finish_by: float | None = None

    def of(self, problem: Problem) -> Problem:
        return replace(problem, dwell=self.dwell, finish_by=self.finish_by)

    def as_dict(self) -> dict[str, object]:
        asked = {"dwell": self.dwell or None, "finish_by": self.finish_by}
        return {name: value for name, value in asked.items() if value is not None}


@dataclass(frozen=True)
class RobotSource:
    """The source of a robot: a name, or files.

    Attributes:
        robot: Name of an installed robot or path of a URDF file.
        exact_meshes: Whether collision meshes stay triangles.
    """

    robot: str
    srdf: Path | None = None
    limits: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    exact_meshes: bool = False
    torque_scaling: float = 1.0
    limit_jerk: bool = False

    def load(self) -> Robot:
        with status_line(f"loading {self.robot}: covering its meshes, once"):
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
        """Read the data of `as_dict`."""
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


ROBOT_OPTIONS: Mapping[str, tuple[object, object]] = {
    "srdf": (SrdfOption, None),
    "limits": (
        Annotated[
            Path | None, typer.Option("--limits", help="With a URDF file: MoveIt's joint_limits.yaml.")
        ],
        None,
    ),
    "package_dir": (PackageOption, None),
    "exact_meshes": (
        Annotated[
            bool,
            typer.Option("--exact-meshes", help="With a URDF file: keep collision meshes as triangles."),
        ],
        False,
    ),
    "torque_scaling": (
        Annotated[
            float,
            typer.Option(
                "--torque-scaling", metavar="X", help="Factor on the torque limits; inf removes them."
            ),
        ],
        1.0,
    ),
    "limit_jerk": (
        Annotated[
            bool,
            typer.Option(
                "--limit-jerk",
                help="Limit the jerk of joints without a limit to their acceleration limit / 0.1 s.",
            ),
        ],
        False,
    ),
}
"""Options of a robot in addition to `--robot`: type and default of each, in the order of `RobotSource`."""
RobotOption = Annotated[str, typer.Option("--robot", help=ROBOT_HELP)]
OptionalRobot = Annotated[
    str | None,
    typer.Option("--robot", help=f"Needed unless the problem or the file names its robot. {ROBOT_HELP}"),
]
RobotsOption = Annotated[list[str], typer.Option("--robot", help=f"{ROBOT_HELP} Repeatable.")]


def robot_options(command: Callable[..., None]) -> Callable[..., None]:
    """Replace the parameter `robot` of a command by the options of a robot.

    Args:
        command: Its parameter is a `RobotSource`, or a list of them for a repeatable `--robot`. With the
            default None the command line need not name a robot.
    """
    signature = inspect.signature(command, eval_str=True)
    robot = signature.parameters["robot"]
    several = robot.annotation == list[RobotSource]
    one = RobotOption if robot.default is robot.empty else OptionalRobot
    expanded = {
        "robot": [
            robot.replace(annotation=RobotsOption if several else one),
            *(
                inspect.Parameter(name, robot.kind, annotation=option, default=default)
                for name, (option, default) in ROBOT_OPTIONS.items()
            ),
        ]
    }
    parameters = [
        each.replace(kind=each.KEYWORD_ONLY)
        for name, stated in signature.parameters.items()
        for each in expanded.get(name, [stated])
    ]

    def run(**given: Any) -> None:
        name, folders = given.pop("robot"), tuple(given.pop("package_dir") or ())
        stated = {key: given.pop(key) for key in ROBOT_OPTIONS if key != "package_dir"}
        named = [] if name is None else name if several else [name]
        sources = sources_of(named, package_dirs=folders, **stated)
        command(**given, robot=sources if several else next(iter(sources), None))

    run.__name__, run.__doc__, run.__module__ = command.__name__, command.__doc__, command.__module__
    run.__annotations__ = {each.name: each.annotation for each in parameters}
    vars(run)["__signature__"] = signature.replace(parameters=parameters)
    return run


def sources_of(robots: list[str], **stated: Any) -> list[RobotSource]:
    described = [each for each in robots if Path(each).is_file()]
    if len(described) > 1 and (stated["srdf"] is not None or stated["limits"] is not None):
        raise ModelError(f"--srdf and --limits are of one robot, and {len(described)} descriptions are given")
    none: dict[str, Any] = {"srdf": None, "limits": None, "package_dirs": ()}
    return [
        RobotSource(each, **stated if each in described or not described else {**stated, **none})
        for each in robots
    ]


def _torque_scaling(path: Path, written: object) -> float:
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
    if improve and time_budget is None and portfolio:
        raise ProblemError("--improve uses the whole time budget: give --time-budget, in seconds, too")
    attempts = None if portfolio else 1
    return Budget(time_budget, attempts=attempts, workers=workers, improve=improve, clock=clock)


def read_files(
    robot: Robot, scene: Path, request: Path, motions: Path | None = None
) -> tuple[SceneFile, RequestFile]:
    around = read_scene(scene, robot)
    if motions is not None:
        around = replace(around, scene=read_motions(motions, around.scene))
    return around, read_request(request, around)
