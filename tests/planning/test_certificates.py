"""What a result knows of its motion: proven when it is returned, measured when somebody asks how nearly."""

import pickle

import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.planning.judgement import decide
from trajopt.planning.status import Status
from trajopt.verify import Judge

START = {"pan": -1.0, "reach": 0.1, "elbow": 0.3, "wrist": 0.0}
GOAL = START | {"pan": 1.0}


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> to.Problem:
    scene = to.Scene(odd_arm(tmp_path_factory.mktemp("robot")))
    scene = scene.add("pillar", to.Cylinder(0.08, 1.0), to.placement((0.72, 0.0, 0.3)))
    return to.Problem(scene=scene, start=START, goal=to.joint_positions(GOAL))


def test_planning_decides_and_the_result_measures_on_request(problem: to.Problem) -> None:
    result = to.plan(problem)
    assert result.verified and result.judged is not None and result.judged.known is None
    certificate = result.certificate
    assert certificate is not None and certificate is result.require().certificate
    assert certificate == to.judge(problem, result.require().trajectory)
    assert result.counts["judge_distance_calls"] < certificate.counts.distances


def test_a_printed_clearance_is_measured(problem: to.Problem) -> None:
    result = to.plan(problem)
    certificate = to.judge(problem, result.require().trajectory)
    near = certificate.pairs[0]
    assert near.proven is not None and near.proven <= near.measured <= near.proven / 0.75 + 1e-3
    for text in (str(result.certificate), repr(result), repr(result.require())):
        assert certificate.closest in text or str(near) in text
    assert result.as_dict()["certificate"] == certificate.as_dict()


def test_a_refused_motion_keeps_the_certificate_with_the_reason(problem: to.Problem) -> None:
    found = to.plan(problem).require()
    ends, times = found.path.knots[[0, -1]], found.trajectory.times[[0, -1]]
    straight = to.Trajectory(found.trajectory.joint_names, times, ends)
    judged, distances = decide(problem, straight, Judge(problem.reduced))
    assert not judged.verified and judged.known is not None and distances > 0
    assert judged.certificate is judged.known
    assert "clearance" in {check.name for check in judged.certificate.failed}


def test_motions_of_other_threads_have_certificates(problem: to.Problem) -> None:
    result = to.plan(problem, budget=to.Budget(workers=2, improve=True, attempts=4))
    assert result.status is Status.SOLVED and result.judged is not None
    assert str(result.certificate) == str(to.judge(problem, result.require().trajectory))


def test_a_result_that_was_stored_measures_its_own_motion(problem: to.Problem) -> None:
    result = to.plan(problem)
    again: to.Result = pickle.loads(pickle.dumps(result))
    assert again.judged is not None and again.judged.known is None
    assert str(again.certificate) == str(result.certificate)
