"""`trajopt demo`: the main job from problem to simulated motion, with files to look at."""

import json
import time
from pathlib import Path
from typing import Annotated

import typer

from trajopt.cli.options import JsonOption
from trajopt.cli.plan import report
from trajopt.cli.progress import ProgressLine, progress_line
from trajopt.files.moveit import write_trajectory
from trajopt.planning.plan import plan
from trajopt.planning.result import Plan
from trajopt.problem.problem import named_problem
from trajopt.simulation import Rollout, render, simulate
from trajopt.values.documents.document import write_json
from trajopt.viewer.plots import plot_motion

OutOption = Annotated[Path, typer.Option("--out", help="Folder for the files.")]
ProblemOption = Annotated[str, typer.Option("--problem", help="Name of an installed problem.")]
PictureOption = Annotated[
    bool, typer.Option("--picture/--no-picture", help="Render the rollout (needs OpenGL or software GL).")
]


def demo(
    out: OutOption = Path("out/demo"),
    problem: ProblemOption = "cup_past_pillar",
    picture: PictureOption = True,
    as_json: JsonOption = False,
) -> None:
    """Plan a Panda carrying an upright cup past a pillar, verify it, simulate it, draw it.

    Exit status 0 verified, 1 no plan, 2 bad input.
    """
    asked = named_problem(problem)
    with progress_line() as line:
        result = plan(asked, progress=line.show)
    if not as_json:
        typer.echo(report(result))
    if not result.verified:
        if as_json:
            typer.echo(json.dumps(result.as_dict(), allow_nan=False))
        raise typer.Exit(1)
    with progress_line() as line:
        begin = time.process_time()
        line.show("simulate", None)
        rollout, files = _produce(result.require(), result.as_dict() | {"source": {"problem": problem}}, out)
        if picture:
            files |= _pictures(result.require(), rollout, out, line)
        used = time.process_time() - begin
    if as_json:
        document = {
            **result.as_dict(),
            "rollout": rollout.as_dict(),
            "files": {name: str(path) for name, path in files.items()},
        }
        typer.echo(json.dumps(document, allow_nan=False))
        return
    typer.echo(f"\nsimulated in MuJoCo\n  {rollout.summary()}")
    typer.echo(f"\nfiles (simulation and pictures took {used:.1f} s of CPU)")
    for name, path in files.items():
        typer.echo(f"  {name:<12} {path}")
    typer.echo(f"\nlook at it: trajopt view {files['plan']}")


def _produce(plan: Plan, document: dict[str, object], out: Path) -> tuple[Rollout, dict[str, Path]]:
    reduced, trajectory = plan.problem.reduced, plan.trajectory
    files = {
        "plan": out / "plan.json",
        "for MoveIt": out / "robot_trajectory.yaml",
        "plot": out / "motion.png",
    }
    write_json(files["plan"], document)
    write_trajectory(trajectory, files["for MoveIt"])
    plot_motion(
        reduced,
        trajectory,
        files["plot"],
        limits=plan.problem.limits,
        constraints=plan.problem.requirements,
        title=plan.problem.name,
    )
    return simulate(reduced, trajectory), files


def _pictures(plan: Plan, rollout: Rollout, out: Path, line: ProgressLine) -> dict[str, Path]:
    def show(share: float) -> None:
        line.show(f"rendering {share:.0%}", None)

    still, clip = out / "rollout.png", out / "rollout.gif"
    moments = [share * plan.trajectory.duration for share in (0.0, 1 / 3, 2 / 3, 1.0)]
    render(plan.problem.reduced, rollout, still, moments=moments, progress=show)
    render(plan.problem.reduced, rollout, clip, progress=show)
    return {"still": still, "clip": clip}
