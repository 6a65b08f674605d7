"""The same campaign has the same ids everywhere; what is planned otherwise has others."""

import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace

import pytest

import trajopt as to
from trajopt.lab.campaign import (
    Campaign,
    Options,
    ProblemSource,
    from_problems,
    installed,
    perturbed,
    random_motions,
)
from trajopt.lab.campaign.recipes import Packer
from trajopt.values.errors import ProblemError, SolverNotFound

ELSEWHERE = """
import trajopt as to
from trajopt.lab.campaign import Campaign, random_motions, perturbed
from trajopt.lab.campaign.recipes import Packer
robot = to.load("planar2")
scene = to.Scene(robot).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
problem = to.Problem(scene=scene, start=[0.0, 0.4], goal={"joint1": 1.4, "joint2": 0.4}, name="past a ball")
sources = [random_motions(scene, 3), perturbed(problem, 2, shift=0.05)]
print(" ".join(task.id for task in Campaign("x", sources).tasks(Packer())))
"""


def ids(sources: Sequence[ProblemSource], **settings: object) -> list[str]:
    made = Campaign("x", sources, **settings)  # type: ignore[arg-type]
    return [task.id for task in made.tasks(Packer())]


@pytest.mark.parametrize("hashing", ["1", "2"])
def test_another_process_gives_the_same(scene: to.Scene, task: to.Problem, hashing: str) -> None:
    environment = {**os.environ, "PYTHONHASHSEED": hashing}
    code = [sys.executable, "-c", ELSEWHERE]
    done = subprocess.run(code, capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.split() == ids([random_motions(scene, 3), perturbed(task, 2, shift=0.05)])


def test_first_problems_do_not_depend_on_count_and_order(scene: to.Scene, task: to.Problem) -> None:
    few, many = random_motions(scene, 3), random_motions(scene, 30)
    own = from_problems("own", [task])
    assert ids([few]) == ids([many])[:3]
    assert sorted(ids([few, own])) == sorted(ids([own, few]))


def test_options_change_the_id_and_not_the_problem(scene: to.Scene) -> None:
    source = random_motions(scene, 2)
    both = Campaign("x", [source], [Options(), Options(work=10_000)])
    tasks = list(both.tasks(Packer()))
    assert len({task.id for task in tasks}) == 4 and len({task.problem_id for task in tasks}) == 2
    seeds = list(Campaign("x", [source], seeds=(0, 1)).tasks(Packer()))
    assert len({task.id for task in seeds}) == len({task.problem_id for task in seeds}) == 4


def test_contents_change_the_problem(scene: to.Scene, task: to.Problem) -> None:
    slow = replace(scene.robot, limits=scene.robot.limits.scaled(velocity=0.5, acceleration=1.0))
    others = (
        random_motions(scene.move("ball", to.placement((0.65, 0.65, 0.11))), 1),
        random_motions(scene.with_clearance(0.001), 1),
        random_motions(replace(scene, robot=slow), 1),
        random_motions(scene, 1, seed=1),
        perturbed(task, 1, shift=0.01),
        perturbed(task, 1, shift=0.02),
        perturbed(replace(task, velocity_scaling=0.5), 1, shift=0.02),
        from_problems("own", [task]),
        installed("planar_fold"),
    )
    found = [*ids([random_motions(scene, 1)]), *(ids([other])[0] for other in others)]
    assert len(set(found)) == len(found)


def test_visual_shapes_do_not_change_the_id(scene: to.Scene) -> None:
    bare = replace(scene, robot=replace(scene.robot, visuals={}))
    assert ids([random_motions(bare, 1)]) == ids([random_motions(scene, 1)])


def test_the_same_scene_read_again_is_the_same(scene: to.Scene) -> None:
    again = to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    assert ids([random_motions(again, 1)]) == ids([random_motions(scene, 1)])


def test_versions_change_the_id_and_not_the_problem(scene: to.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    source = random_motions(scene, 1)
    (before,) = Campaign("x", [source]).tasks(Packer())
    monkeypatch.setattr("trajopt.lab.campaign.campaign.versions", lambda: {"trajopt": "99", "python": "3"})
    (after,) = Campaign("x", [source]).tasks(Packer())
    assert before.problem_id == after.problem_id and before.id != after.id


def test_invalid_campaigns_are_refused(scene: to.Scene) -> None:
    source = random_motions(scene, 1)
    with pytest.raises(ProblemError, match="sources is empty"):
        Campaign("x", [])
    with pytest.raises(ProblemError, match="seeds must not be negative"):
        Campaign("x", [source], seeds=(-1,))
    with pytest.raises(ProblemError, match="most_seconds must be positive"):
        Campaign("x", [source], most_seconds=0.0)
    with pytest.raises(SolverNotFound, match="did you mean 'chomp'"):
        Options(method="chom")
    with pytest.raises(ProblemError, match="count must be positive"):
        random_motions(scene, 0)
