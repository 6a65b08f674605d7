"""Rows become experience: what a campaign planned is where planning begins."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.lab.campaign import (
    Campaign,
    CampaignFolder,
    Local,
    from_problems,
    problem_of,
    remember,
    run_campaign,
)
from trajopt.lab.campaign.columns import encoded
from trajopt.planning.experience import Experience
from trajopt.planning.seeds import SeedKind
from trajopt.server.warehouse import Warehouse

pytestmark = pytest.mark.timeout(200)


def test_a_warehouse_stores_the_plans_of_a_campaign(planned: CampaignFolder, tmp_path: Path) -> None:
    with Warehouse(tmp_path / "cell.warehouse") as kept:
        count = remember(planned, kept.experience())
        assert count == len(kept.experience()) == 12
        problem = problem_of(planned, next(iter(planned.tasks())).id)
        result = to.plan(problem, experience=kept.experience(learning=False))
        assert result.verified and result.won is not None and result.won.kind is SeedKind.GIVEN
        assert remember(planned, kept.experience()) == 0, "it is remembered already"


def test_the_files_that_rows_are_in_do_not_matter(
    planned: CampaignFolder, small: Campaign, tmp_path: Path
) -> None:
    rows = sorted(planned.rows(), key=lambda row: row["id"])
    other = CampaignFolder.begin(small, tmp_path)
    for row in rows:
        other.write(encoded([row]))
    first, second = Experience(most=5), Experience(most=5)
    assert remember(planned, first) == remember(other, second) == 5
    for number, memory in first.storage.all().items():
        assert np.array_equal(memory.knots, second.storage.all()[number].knots)


def test_earlier_memories_stay_when_the_memory_is_full(planned: CampaignFolder) -> None:
    experience = Experience(most=5)
    assert remember(planned, experience) == 5
    assert sorted(experience.storage.all()) == [1, 2, 3, 4, 5]
    assert remember(planned, Experience(learning=False)) == 0


def test_failures_are_left_out_and_sets_are_remembered_by_the_goal_reached(
    task: to.Problem, scene: to.Scene, tmp_path: Path
) -> None:
    inside = scene.move("ball", to.placement((0.2, 0.6, 0.1)))
    blocked = to.Problem(scene=inside, start=[0.0, 0.4], goal={"joint1": 1.2, "joint2": 0.1})
    near = to.joint_positions({"joint1": 0.3, "joint2": 0.4})
    either = to.any_of({"far": to.joint_positions({"joint1": 1.4, "joint2": 0.4}), "near": near})
    choice = to.Problem(scene=scene, start=[0.0, 0.4], goal=either)
    campaign = Campaign("some", [from_problems("some", [blocked, choice])])
    experience = Experience()
    assert remember(run_campaign(campaign, tmp_path, Local(1)), experience) == 1
    alone = to.Problem(scene=scene, start=[0.05, 0.4], goal={"joint1": 0.3, "joint2": 0.4})
    assert experience.recall(alone).memories == (1,)
