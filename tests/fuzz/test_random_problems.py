"""A fixed part of the random problems, and that its own check sees what is wrong."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from benchmarks.rows import Rows
from benchmarks.workers import run
from tests.fuzz.hanging import hang_or_die
from tests.fuzz.random_problems.any_robot import any_robot
from tests.fuzz.random_problems.arms import installed, random_arm
from tests.fuzz.random_problems.asked import near
from tests.fuzz.random_problems.attack import AT_GOAL, AT_START
from tests.fuzz.random_problems.case import Case, Contact, Thing
from tests.fuzz.random_problems.check import fault_of_configuration, fault_of_path, fault_of_trajectory
from tests.fuzz.random_problems.drawing import at, moving
from tests.fuzz.random_problems.registry import FAMILIES, case, keys
from tests.fuzz.random_problems.shapes import ball, box, prism, sphere
from tests.fuzz.random_problems.summary import summary
from tests.fuzz.random_problems.trial import FALSE, trial

SLOW, CHUNK = 500, 50
ELSEWHERE = 100_000
"""Seed from which the slow part begins: none of the quick part's."""


def wrong(part: list[tuple[str, int]]) -> str:
    """Ask problems and say which ended as none may."""
    rows = [trial(family, seed) for family, seed in part]
    bad = [row for row in rows if row["outcome"] in FALSE]
    return summary(rows) if bad else ""


HELD = tuple(FAMILIES)
"""Families of which no problem ends as none may."""


@pytest.mark.parametrize("family", HELD)
def test_two_of_each_family(family: str) -> None:
    assert not wrong(list(keys(2, families=[family])))


@pytest.mark.slow
@pytest.mark.timeout(1200)
@pytest.mark.parametrize("chunk", range(0, SLOW, CHUNK))
def test_a_fixed_part_of_the_random_problems(chunk: int) -> None:
    assert not wrong(list(keys(SLOW, start=ELSEWHERE, families=HELD))[chunk : chunk + CHUNK])


def test_most_known_motions_are_found() -> None:
    rows = [trial(*key) for key in keys(24, families=["open_meshes", "margins", "walls"])]
    known = [row for row in rows if row["known"] == "feasible"]
    assert len(known) >= 20
    assert sum(row["outcome"] == "verified" for row in known) >= len(known) - 2


def test_margins_are_kept_or_give_way() -> None:
    """These ended without a motion once: wishes that nothing keeps, or that an end is far from."""
    for seed in (3, 8, 18, 21, 28, 38, 48, 52, 70, 107, 70020):
        assert trial("margins", seed)["outcome"] == "verified"
    for seed in (48, 107):
        result = to.plan(case("margins", seed).problem())
        assert "no motion keeps the margin of" in result.remarks[-1]
        assert len(result.attempts) < 10, "nor is it looked for with all seeds"


def test_goals_that_hold_with_a_path_constraint_only_near_bounds_are_found() -> None:
    for seed in (70005, 90088):
        assert trial("kept_requirements", seed)["outcome"] == "verified"


ANY_ROBOT = ("serial_robots", "tree_robots", "mimic_robots")


def test_unknown_robots_are_loaded_and_planned() -> None:
    rows = [trial(*key) for key in keys(24, start=2, families=ANY_ROBOT)]
    assert not [row for row in rows if row["outcome"] in (*FALSE, "refused")], summary(rows)
    assert sum(row["outcome"] == "verified" for row in rows) >= len(rows) - 1


def test_robots_are_of_all_kinds() -> None:
    """Few and many joints, odd names, joints called as links, meshes, no mass, groups, limits of load."""
    arms = [case(*key).arm for key in keys(30, families=ANY_ROBOT)]
    counts = {len(arm.chain.driven) for arm in arms}
    assert min(counts) <= 3 and max(counts) >= 13
    assert {joint.kind for arm in arms for joint in arm.chain.joints} == {
        "revolute", "continuous", "prismatic", "fixed"
    }  # fmt: skip
    followers = [joint for arm in arms for joint in arm.chain.moving if joint.mimic]
    assert any(joint.mimic[0] in {other.name for other in followers} for joint in followers), "chains of them"
    links = [{arm.chain.root, *(joint.child for joint in arm.chain.joints)} for arm in arms]
    assert any({joint.name for joint in arm.chain.joints} & own for arm, own in zip(arms, links, strict=True))
    assert any(" " in name for own in links for name in own)
    assert any(not name.isascii() for own in links for name in own)
    parents = [[joint.parent for joint in arm.chain.joints] for arm in arms]
    assert any(len(set(names)) < len(names) for names in parents), "trees"
    assert {item.body.kind for arm in arms for item in arm.chain.bodies} == {
        "box", "cylinder", "sphere", "mesh"
    }  # fmt: skip
    assert any('<mass value="0.0"/>' in arm.source.urdf for arm in arms)
    assert any(arm.efforts for arm in arms) and any(arm.source.srdf for arm in arms)


def test_the_same_key_reproduces_a_problem() -> None:
    for family in ("mimic_chain", "closed_meshes", "conflicts", "tree_robots"):
        one, other = (case(family, 3) for _ in range(2))
        assert (one.start == other.start).all() and one.impossible == other.impossible
        assert len(one.things) == len(other.things)


def test_families_go_on_from_a_seed() -> None:
    first, later = list(keys(200)), list(keys(200, start=50))
    assert len(set(first)) == 200
    assert {family for family, _ in first} == set(FAMILIES)
    assert min(seed for _, seed in later) == 50


# ----------------------------------------------------------------- the check sees what is wrong


def planned() -> tuple[Case, to.Trajectory]:
    """A random problem and a motion for it."""
    drawn = case("joint_tolerance", 0)
    return drawn, to.plan(drawn.problem()).require().trajectory


def test_own_kinematics_match_pinocchio() -> None:
    rng = np.random.default_rng(5)
    drawn = [any_robot(rng, tree=True, mimics=mimics) for mimics in (False, True, True)]
    for arm in (
        random_arm(rng),
        random_arm(rng, mimics=True),
        random_arm(rng, mimics=True, tight=True),
        *drawn,
    ):
        robot = arm.source.robot()
        q = rng.uniform(*arm.chain.bounds())
        everywhere = robot.positions(dict(zip(arm.chain.driven, q.tolist(), strict=True)))
        places = arm.chain.places(q[None])
        scene = to.Scene(robot)
        for link in robot.links:
            expected = scene.placement_of(link, everywhere)
            assert places[link][0][:3, 3] == pytest.approx(expected.translation, abs=1e-12)
            assert places[link][0][:3, :3] == pytest.approx(expected.rotation, abs=1e-12)


def test_a_sound_motion_has_no_fault() -> None:
    assert fault_of_trajectory(*planned()) == ""


def test_a_motion_too_fast_elsewhere_or_restless_is_seen() -> None:
    drawn, motion = planned()
    speeds, pushes = motion.velocities, motion.accelerations
    assert speeds is not None and pushes is not None
    fast = to.Trajectory(motion.joint_names, motion.times / 2, motion.positions, 2 * speeds, 4 * pushes)
    assert "beyond its limit" in fault_of_trajectory(drawn, fast)
    shifted = replace(drawn, start=drawn.start + 1e-4)
    assert "does not begin" in fault_of_trajectory(shifted, motion)
    part = motion.between(0.0, motion.duration * 0.6)
    assert "does not rest" in fault_of_trajectory(drawn, part)
    far = near(dict(zip(motion.joint_names, (motion.positions[-1] + 0.01).tolist(), strict=True)), 9e-3)
    assert "misses" in fault_of_trajectory(replace(drawn, goals=(far,)), motion)


def test_a_thing_on_the_way_is_seen_and_how_near_it_may_be() -> None:
    drawn, motion = planned()
    middle = motion(motion.duration / 2)[None]
    tip = next(item for item in drawn.arm.chain.bodies if item.link == drawn.arm.tip)
    spot = (drawn.arm.chain.places(middle)[tip.link] @ tip.place)[0][:3, 3]
    blocked = replace(drawn, things=(Thing("thing", sphere(0.01), at(spot)),))
    assert "thing" in fault_of_trajectory(blocked, motion)
    assert "keep" in fault_of_trajectory(replace(drawn, required=5.0), motion)


def test_a_joint_that_bears_too_much_is_seen() -> None:
    drawn = next(asked for key in keys(30, families=ANY_ROBOT) if (asked := case(*key)).arm.efforts)
    motion = to.plan(drawn.problem()).require().trajectory
    assert fault_of_trajectory(drawn, motion) == ""
    weak = dict.fromkeys(drawn.arm.efforts, 1e-3)
    weaker = replace(drawn, arm=replace(drawn.arm, efforts=weak))
    assert "bears" in fault_of_trajectory(weaker, motion)


def test_a_follower_beyond_its_limits_is_seen() -> None:
    rng = np.random.default_rng(3)
    arm = random_arm(rng, mimics=True, tight=True)
    low, high = arm.chain.bounds()
    seen = [fault_of_configuration(Case(arm=arm, start=q, goals=()), q, goals=False)
            for q in rng.uniform(low, high, (50, len(low)))]  # fmt: skip
    assert any(fault == "is outside the limits" for fault in seen)


def test_objects_inside_a_closed_mesh_collide() -> None:
    turns = np.linspace(0.0, 2 * np.pi, 12, endpoint=False)
    outline = np.stack((np.cos(turns), np.sin(turns)), axis=1)
    for solid in (ball(1.0), prism(outline, 2.0, lids=True)):
        inside = solid.inside(np.array([(0.0, 0.1, 0.2), (0.7, 0.0, 0.0), (1.2, 0.0, 0.0), (0.0, 0.0, 3.0)]))
        assert inside.tolist() == [True, True, False, False]
    drawn = moving(np.random.default_rng(1))
    tip = drawn.arm.chain.places(drawn.start[None])[drawn.arm.tip][0]
    beyond = at(np.array((0.5, 0.0, 0.0)))
    chip = Thing("chip", box(0.01, 0.01, 0.01), beyond, drawn.arm.tip, (drawn.arm.tip,))
    around = Thing("around", ball(0.08), at((tip @ beyond)[:3, 3]))
    still = np.stack((drawn.start, drawn.start))
    inside = replace(drawn, things=(chip, around))
    assert "chip and around" in fault_of_path(inside, still)
    deep = replace(inside, contacts=(Contact("chip", "around", 1e-3, 0.5, 0.5),))
    assert "deep" in fault_of_path(deep, still)
    assert fault_of_path(replace(drawn, things=(chip,)), still) == ""


def test_the_panda_is_read_as_it_is() -> None:
    arm = installed("panda")
    assert len(arm.chain.driven) == 7
    assert arm.chain.limits()[1][:7] == pytest.approx([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0])


# ----------------------------------------------------------------- it can be stopped, and goes on


def test_one_that_hangs_or_dies_costs_its_problem_only(tmp_path: Path) -> None:
    rows = Rows(tmp_path / "rows.jsonl")
    run([("any", seed) for seed in range(4)], ask=hang_or_die, workers=2, seconds=3.0, keep=rows.append)
    ended = {key: row["outcome"] for key, row in Rows(tmp_path / "rows.jsonl").done.items()}
    assert ended == {
        "any-0": "verified", "any-1": "hang", "any-2": "crash", "any-3": "verified"
    }  # fmt: skip
    assert "any-1: hang" in summary(list(rows.done.values()))


def test_an_incomplete_row_is_planned_again(tmp_path: Path) -> None:
    file = tmp_path / "rows.jsonl"
    Rows(file).append({"key": "a-0", "outcome": "verified"})
    whole = file.read_text()
    file.write_text(whole + '{"key": "a-1", "outc')
    rows = Rows(file)
    assert list(rows.done) == ["a-0"]
    rows.append({"key": "a-1", "outcome": "failed"})
    assert list(Rows(file).done) == ["a-0", "a-1"]
    assert file.read_text().startswith(whole)


def test_every_verdict_on_an_end_is_attacked_as_one() -> None:
    """But a start in motion, and a goal that something passes, which no random problem has."""
    of_start = {status for status in to.Status if status.name.startswith("START_")}
    of_goal = {status for status in to.Status if status.name.startswith("GOAL_")}
    assert of_start - {to.Status.START_TOO_FAST} == set(AT_START)
    assert of_goal - {to.Status.GOAL_OCCUPIED} <= set(AT_GOAL)


def test_a_configuration_that_overloads_a_joint_is_at_fault() -> None:
    weak = next(found for seed in range(40) if (found := case("serial_robots", seed)).arm.efforts)
    assert weak.arm.efforts
    still = replace(weak, arm=replace(weak.arm, efforts=dict.fromkeys(weak.arm.efforts, 0.0)))
    assert "bears" in fault_of_configuration(still, weak.start, goals=False)
