"""Experience on MotionBenchMaker: problems planned, then planned again with displaced objects.

python -m benchmarks.experience DATA [--robots panda,ur5] [--limit K] [--apart M] [--page FILE]

Each object that stands in the world is moved by itself, uniformly within a ball; the seed is 0 and the place
of the problem among those of its robot. What was moved is planned twice, cold and with the experience of the
problems as they were, in turn, in one process; the experience goes on learning. Left out is what nobody can
answer: where an object was moved into the start or the goal.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.lab.suite import Instance
from trajopt.lab.suite.instance import find_instances
from trajopt.planning import Certainty
from trajopt.planning import Result as PlanResult
from trajopt.planning.experience import Experience

SEED = 0


@dataclass(frozen=True)
class Run:
    """One plan of a moved problem.

    Attributes:
        verified: Whether a motion was proven.
        optimise: CPU of the optimisation [s].
        total: CPU of the whole plan [s].
        duration: Of the motion [s]; 0 without one.
        remembered: Whether the motion came from a memory.
    """

    verified: bool
    optimise: float
    total: float
    duration: float
    remembered: bool


@dataclass(frozen=True)
class Pair:
    """A moved problem, planned cold and with experience."""

    robot: str
    problem: str
    cold: Run
    warm: Run

    @property
    def family(self) -> str:
        """The set of the problem."""
        return self.problem.split("/")[0]


def main() -> None:
    """Measure, and write the section of the page and the numbers."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--robots", default="panda,ur5", help="names, separated by commas")
    parser.add_argument("--limit", type=int, help="problems of each set at most")
    parser.add_argument("--apart", type=float, default=0.03, help="how far objects are moved at most [m]")
    parser.add_argument("--results", type=Path, help="file for the numbers")
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    pairs = list[Pair]()
    for name in given.robots.split(","):
        pairs += measured(given.data, name, given.limit, given.apart)
    text = page(pairs)
    print(text)
    if given.results is not None:
        given.results.write_text("".join(json.dumps(asdict(pair)) + "\n" for pair in pairs))
    if given.page is not None:
        write_section(given.page, "experience", text)


def measured(data: Path, name: str, limit: int | None, apart: float) -> list[Pair]:
    """Return the outcomes of a robot's problems."""
    folder = data / name / "robot"
    robot = (
        to.load("panda")
        if name == "panda"
        else to.Robot.from_urdf(folder / f"{name}.urdf", srdf=folder / f"{name}.srdf")
    )
    instances, experience = find_instances(data / name, robot, limit=limit), Experience()
    for instance in instances:
        to.plan(instance.make(), experience=experience)
    print(f"{name}: {len(experience)} memories of {len(instances)} problems", flush=True)
    pairs = list[Pair]()
    for place, instance in enumerate(instances):
        if place % 2:
            warm, _ = planned(instance, place, apart, experience)
            cold, result = planned(instance, place, apart, None)
        else:
            cold, result = planned(instance, place, apart, None)
            warm, _ = planned(instance, place, apart, experience)
        if result.verified or result.certainty is not Certainty.PROVEN:
            pairs.append(Pair(name, instance.name, cold, warm))
    return pairs


def planned(
    instance: Instance, place: int, apart: float, experience: Experience | None
) -> tuple[Run, PlanResult]:
    """Plan a problem with moved objects; it is created again, so that nothing is cached."""
    problem = moved(instance.make(), np.random.default_rng((SEED, place)), apart)
    begin = time.process_time()
    result = to.plan(problem, experience=experience)
    took = time.process_time() - begin
    recalled = None if result.arguments is None else result.arguments.recalled
    run = Run(
        verified=result.verified,
        optimise=result.cpu_seconds.get("optimise", 0.0),
        total=took,
        duration=result.cost if result.verified else 0.0,
        remembered=bool(recalled and recalled.memories and result.won and result.won.kind.name == "GIVEN"),
    )
    return run, result


def moved(problem: to.Problem, rng: np.random.Generator, apart: float) -> to.Problem:
    """Return a problem with each object of the world moved, uniformly within a ball [m]."""
    scene = problem.scene
    for name, item in scene.objects.items():
        if item.frame == "world":
            way = rng.normal(size=3)
            way *= apart * rng.uniform() ** (1.0 / 3.0) / np.linalg.norm(way)
            at = item.placement
            scene = scene.move(name, replace(at, translation=np.array(at.translation) + way))
    return replace(problem, scene=scene)


def page(pairs: Sequence[Pair]) -> str:
    """Return the section of the page."""
    rows = list[list[str]]()
    for robot in dict.fromkeys(pair.robot for pair in pairs):
        of_it = [pair for pair in pairs if pair.robot == robot]
        rows += [
            row(f"{robot} {family}", [pair for pair in of_it if pair.family == family])
            for family in dict.fromkeys(pair.family for pair in of_it)
        ]
        rows.append(row(f"**{robot}**", of_it))
    rows.append(row("**all**", pairs))
    head = (
        *("set", "problems", "verified cold / with", "from memory", "optimisation ms, cold / with"),
        *("ratio", "plan ms p90, cold / with", "ratio", "motion, ratio: median, mean"),
    )
    return table(head, rows)


def row(name: str, pairs: Sequence[Pair]) -> list[str]:
    """Return a row of the table."""
    cold, warm = [pair.cold for pair in pairs], [pair.warm for pair in pairs]
    optimise = [1e3 * float(np.median([run.optimise for run in runs])) for runs in (cold, warm)]
    whole = [1e3 * float(np.percentile([run.total for run in runs], 90)) for runs in (cold, warm)]
    longer = [
        pair.warm.duration / pair.cold.duration for pair in pairs if pair.cold.verified and pair.warm.verified
    ]
    return [
        name,
        str(len(pairs)),
        f"{sum(run.verified for run in cold)} / {sum(run.verified for run in warm)}",
        str(sum(run.remembered for run in warm)),
        f"{optimise[0]:.1f} / {optimise[1]:.1f}",
        f"{optimise[1] / optimise[0]:.2f}",
        f"{whole[0]:.0f} / {whole[1]:.0f}",
        f"{whole[1] / whole[0]:.2f}",
        f"{np.median(longer):.3f}, {np.mean(longer):.3f}",
    ]


if __name__ == "__main__":
    main()
