"""`trajopt plan`: plan from a start to a goal, or a MoveIt request in a MoveIt scene."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli import options
from trajopt.cli.problems import Ends, scene_around
from trajopt.cli.progress import progress_line
from trajopt.planning.plan import plan as plan_problem
from trajopt.planning.result import Result, improvement, table
from trajopt.problem.problem import Problem
from trajopt.robot.joints import joint_unit
from trajopt.server.warehouse import Warehouse
from trajopt.values.documents.document import write_json
from trajopt.values.errors import ProblemError
from trajopt.values.printed import in_unit

OptionalScene = Annotated[
    Path | None,
    typer.Option("--scene", help="MoveIt PlanningScene in YAML; default: the robot alone."),
]
OptionalRequest = Annotated[
    Path | None,
    typer.Option("--request", help="MoveIt MotionPlanRequest in YAML, instead of --start and --goal."),
]
StartOption = Annotated[
    str | None,
    typer.Option("--start", help=r'Named state, "j1 j2 ..." or "joint=position ..." \[rad | m].'),
]
GoalOption = Annotated[
    str | None,
    typer.Option(
        "--goal",
        help=r'Tool pose "x y z roll pitch yaw" \[m, rad], or as --start; '
        "write six joints as joint=position.",
    ),
]
DegreesOption = Annotated[
    bool, typer.Option("--degrees", help="Angles of --start and --goal are in degrees.")
]
ExplainOption = Annotated[
    bool,
    typer.Option("--explain", help="If there is no plan, plan variants to find changes that help."),
]
ImproveOption = Annotated[
    bool,
    typer.Option(
        "--improve", help="Use the whole --time-budget to shorten the motion; Ctrl-C ends it early."
    ),
]
FreeOption = Annotated[
    bool,
    typer.Option(
        "--free-duration",
        help="Optimise path and timing together, for a shorter motion.",
    ),
]
EveryOption = Annotated[
    bool, typer.Option("--every-goal", help="Plan to every goal of the request and compare the motions.")
]
WorkersOption = Annotated[
    int, typer.Option("--workers", min=1, help="Threads for all seeds after the straight line.")
]
OutOption = Annotated[
    Path | None,
    typer.Option("--out", help="Write the plan here as JSON, or a bundle (x.trajopt)."),
]
SaveOption = Annotated[
    Path | None,
    typer.Option("--save", help="Write a bundle here: one file for check, view and replay on any machine."),
]


@options.robot_options
def plan(
    robot: options.RobotSource,
    scene: OptionalScene = None,
    request: OptionalRequest = None,
    start: StartOption = None,
    goal: GoalOption = None,
    group: options.GroupOption = "",
    degrees: DegreesOption = False,
    out: OutOption = None,
    save: SaveOption = None,
    motions: options.MotionsOption = None,
    dwell: options.DwellOption = 0.0,
    finish_by: options.FinishByOption = None,
    explain: ExplainOption = False,
    as_json: options.JsonOption = False,
    portfolio: options.PortfolioOption = True,
    time_budget: options.TimeBudgetOption = None,
    improve: ImproveOption = False,
    free_duration: FreeOption = False,
    every_goal: EveryOption = False,
    workers: WorkersOption = 1,
    experience: options.ExperienceOption = None,
) -> None:
    """Plan a motion and judge it. Exit status 0 verified, 1 no plan, 2 bad input.

    Give a scene and a request of MoveIt, or --start and --goal: trajopt plan --robot panda --group panda_arm
    --start ready --goal "0.4 0.1 0.5 3.14 0 0".
    """
    budget = options.budget_of(time_budget, portfolio, improve=improve, workers=workers)
    ends = _ends(start, goal, group, degrees=degrees, request=request)
    problem, notes = _problem(robot, scene, request, motions, ends)
    ending = options.Ending(dwell, finish_by)
    with progress_line() as line:
        result = plan_problem(
            ending.of(problem),
            improve=free_duration,
            every_goal=every_goal,
            experience=None if experience is None else Warehouse(experience).experience(),
            budget=budget,
            progress=line.show,
            on_incumbent=line.have,
        )
    notes += result.remarks
    document = {
        **result.as_dict(),
        "notes": notes,
        "source": {
            **robot.as_dict(),
            **({} if scene is None else {"scene": str(scene.resolve())}),
            **({} if request is None else {"request": str(request.resolve())}),
            **({} if ends is None else ends.as_dict()),
            **({} if motions is None else {"motions": str(motions.resolve())}),
            **ending.as_dict(),
        },
    }
    explanation = result.explain(plan_again=True) if explain and not result.verified else None
    if explanation is not None:
        document["explanation"] = explanation.as_dict()
    if out is not None and out.suffix == ".trajopt":
        result.save(out)
    elif out is not None:
        write_json(out, document)
    if save is not None:
        result.save(save)
    if as_json:
        typer.echo(json.dumps(document, allow_nan=False))
    else:
        typer.echo(report(result, notes))
        if explanation is not None:
            typer.echo(f"\nexplanation\n{explanation}")
        for path in (each for each in (out, save) if each is not None):
            typer.echo(f"\nwritten to {path}")
    raise typer.Exit(0 if result.verified else 1)


def _ends(
    start: str | None, goal: str | None, group: str, *, degrees: bool, request: Path | None
) -> Ends | None:
    if request is not None:
        if start is not None or goal is not None or group or degrees:
            raise ProblemError("--request has a start, a goal and a group: leave out the options for them")
        return None
    if start is None or goal is None:
        raise ProblemError("give --start and --goal, or a --scene and a --request in YAML")
    return Ends(start, goal, group, degrees)


def _problem(
    source: options.RobotSource,
    scene: Path | None,
    request: Path | None,
    motions: Path | None,
    ends: Ends | None,
) -> tuple[Problem, list[str]]:
    if ends is not None:
        around, notes = scene_around(source, scene, motions)
        return ends.problem(around), notes
    if scene is None or request is None:
        raise ProblemError("--request needs the --scene that it is for")
    read, asked = options.read_files(source.load(), scene, request, motions)
    return asked.problem(), [*read.scene.robot.notes, *read.notes, *asked.notes]


def _in_joint_space(problem: Problem, length: float) -> str:
    units = {joint_unit(problem.scene.robot.model, joint) for joint in problem.reduced.joint_names}
    return f"{in_unit(length, units.pop()) if len(units) == 1 else f'{length:.3g}'} in joint space"


def report(result: Result, notes: Sequence[str] = ()) -> str:
    """Return the report of a result."""
    lines = ["asked", *_indented(str(result.problem)), "", "answer", f"  {result.reason}"]
    trajectory, path = result.trajectory, result.path
    if trajectory is not None and path is not None:
        motion = f"motion of {trajectory.duration:.3f} s in {len(trajectory.times)} points"
        motion += f", path of {_in_joint_space(result.problem, path.length)}"
        if result.timed is not None:
            motion += f", at most {result.timed.deviation * 1000:.1f} mm from the checked path"
            shares = result.timed.binding.items()
            decisive = ", ".join(f"{kind} {part:.0%}" for kind, part in shares) or "none decides"
            motion += f"\n  as fast along its path as its limits allow: {decisive} of the time"
        lines.append(f"  {motion}")
    if trajectory is not None and result.along_path is not None:
        lines.append(f"  improved {improvement(result.along_path, trajectory.duration)}")
    if result.because:
        lines.append(f"  method {result.method}: {result.because}")
    if result.of_each_goal:
        lines += ["", "every goal", *(f"  {line}" for line in table(result.compared))]
    if result.certificate is not None:
        lines += ["", "certificate", *_indented(str(result.certificate))]
    if notes:
        lines += ["", "notes", *(f"  {note}" for note in notes)]
    return "\n".join([*lines, "", "cost", *_indented(cost(result))])


def cost(result: Result) -> str:
    stages = ", ".join(f"{name} {1000 * used:.0f}" for name, used in result.cpu_seconds.items())
    total = 1000 * sum(result.cpu_seconds.values())
    counts = ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in result.counts.items())
    return f"CPU {total:.0f} ms ({stages})\n{counts}"


def _indented(text: str) -> list[str]:
    return [f"  {line}".rstrip() for line in text.splitlines()]
