"""Every installed problem, by the judge alone: what is asked holds, what cannot be done is refused."""

import numpy as np
import pytest

import trajopt as to
from trajopt.lab.suite import Definition, definitions, run
from trajopt.planning.judgement import judge

RANDOM = 10
"""Random instances of each problem that has some."""

PROBLEMS = definitions()


def identify(value: object) -> str:
    return value.name if isinstance(value, Definition) else str(value)


def as_expected(definition: Definition, draw: int) -> None:
    try:
        outcome = run(definition.instance(draw))
    except to.MissingExtra as error:
        pytest.skip(str(error))
    assert outcome.status is definition.expected, f"{outcome.status.name}: {outcome.message}"
    assert [item for item in outcome.constraints if not item.holds] == []
    assert outcome.good
    if outcome.status is to.Status.SOLVED:
        judged = {item.name.split(":")[0] for item in outcome.constraints}
        assert {"clearance", "start", "velocity", "acceleration"} <= judged, judged


@pytest.mark.parametrize("definition", PROBLEMS, ids=identify)
def test_fixed_instance(definition: Definition) -> None:
    as_expected(definition, 0)


@pytest.mark.slow
@pytest.mark.parametrize("draw", range(1, RANDOM + 1))
@pytest.mark.parametrize("definition", [item for item in PROBLEMS if item.randomised], ids=identify)
def test_random_instance(definition: Definition, draw: int) -> None:
    as_expected(definition, draw)


def test_there_is_enough_to_prove() -> None:
    refusals = {item.expected for item in PROBLEMS} - {to.Status.SOLVED}
    assert len(PROBLEMS) >= 24
    assert sum(item.expected is not to.Status.SOLVED for item in PROBLEMS) >= 6
    assert len(refusals) >= 6, "each without a solution for another reason"


@pytest.mark.parametrize("definition", PROBLEMS, ids=identify)
def test_the_docstring_states_the_difficulty(definition: Definition) -> None:
    said = definition.make.__doc__ or ""
    assert said.startswith("Return the problem")
    assert "What is hard: " in said and "Expected outcome: " in said
    assert ("Expected outcome: solved" in said) is (definition.expected is to.Status.SOLVED)


def test_random_instances_differ_and_come_again() -> None:
    (definition,) = (item for item in PROBLEMS if item.name == "past_pillar_panda")
    first, again, other = (definition.instance(draw).make().start_positions for draw in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 1e-3


def test_judge_refuses_a_motion_through_the_pillar() -> None:
    """The suite would see it if a planner called such a motion a success."""
    problem = to.named_problem("past_pillar_panda")
    motion = to.plan(problem).require().trajectory
    through = to.Trajectory(
        motion.joint_names,
        np.array([0.0, 9.0]),
        np.stack((motion(0.0), motion(motion.duration))),
        np.zeros((2, len(motion.joint_names))),
        np.zeros((2, len(motion.joint_names))),
    )
    refused = {check.name.split(":")[0] for check in judge(problem, through).failed}
    assert refused == {"clearance"}, refused
