"""The certificate: readable as text, plain as data, and honest about user code and notes."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from tests.verify.arms import joint, link, planar_arm, quintic, reduced, robot
from trajopt.problem.requirements import joint_positions
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import ProblemError, ShapeError
from trajopt.values.placement import placement
from trajopt.values.shapes.shapes import Box, Sphere
from trajopt.verify import Certificate, Evidence, Judge, Specification, verify

SWEEP = [[-1.0, 0.0], [1.0, 0.0]]


@dataclass(frozen=True)
class Height:
    """A user's own constraint: the tip's height, by a formula of theirs."""

    most: ArrayLike
    name: str = "tip height"

    def evaluate(self, times: Floats, positions: Floats) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
        shoulder, both = positions[:, 0], positions.sum(axis=1)
        return 0.5 * np.sin(shoulder) + 0.5 * np.sin(both), -np.inf, self.most


@pytest.fixture
def model(tmp_path: Path) -> ReducedModel:
    scene = Scene(planar_arm(tmp_path)).add("post", Sphere(0.1), placement((1.15, 0.0, 0.0)))
    return reduced(scene.add("far", Box(0.1, 0.1, 0.1), placement((5.0, 0, 0))), SWEEP[0])


def judged(model: ReducedModel, *constraints: Height) -> Certificate:
    goal = joint_positions(dict(zip(model.joint_names, SWEEP[1], strict=True)))
    return verify(model, quintic(model, SWEEP, 1.0), goals=[goal], sampled=constraints)


def test_the_text_is_an_aligned_table(model: ReducedModel) -> None:
    lines = str(judged(model)).splitlines()
    assert lines[0] == "verified: all 9 checks hold"
    header, first = lines[2], lines[3]
    assert first.startswith("ok")
    assert "lower - post" in first
    for title, entry in (("check", "clearance"), ("subject", "lower - post"), ("evidence", "proven")):
        assert header.index(title) == first.index(entry)
    assert any(line.strip().startswith("lower - post: measured 49.") for line in lines)
    assert all(len(line) == len(line.rstrip()) for line in lines)


def test_failures_are_named_first(model: ReducedModel) -> None:
    certificate = judged(model, Height(0.8))
    assert not certificate.verified
    assert str(certificate).startswith("not verified: path: tip height (user code")
    assert "FAIL" in str(certificate)


def test_as_data_it_survives_json(model: ReducedModel) -> None:
    plain = judged(model, Height(2.0)).as_dict()
    again = json.loads(json.dumps(plain, allow_nan=False))
    assert again == plain
    assert again["verified"] is True
    assert again["clearance"] == pytest.approx(0.0495, abs=6e-4)
    assert again["checks"][0]["evidence"] == "proven"
    assert again["pairs"][0]["first"] == "lower"
    assert again["unproven"] is None
    assert again["margin"] == [0.01, 0.01]
    assert again["counts"]["distances"] > 0


def test_infinite_numbers_become_none(tmp_path: Path) -> None:
    model = reduced(Scene(planar_arm(tmp_path)), SWEEP[0])
    assert verify(model, quintic(model, SWEEP, 1.0), goals=()).as_dict()["clearance"] is None


def test_user_code_is_sampled(model: ReducedModel) -> None:
    certificate = judged(model, Height(0.85), Height(0.84))
    named = [check for check in certificate.checks if check.name == "path: tip height"]
    assert [check.holds for check in named] == [True, False]
    assert all(check.evidence is Evidence.SAMPLED for check in named)
    assert named[0].value == pytest.approx(np.sin(1.0))
    assert named[1].time == pytest.approx(1.0)
    assert named[1].slack == pytest.approx(0.84 - np.sin(1.0))


def test_user_code_that_returns_nonsense(model: ReducedModel) -> None:
    with pytest.raises(ShapeError, match="tip height"):
        judged(model, Height(np.zeros(7)))
    undefined = judged(model, Height(np.nan))
    assert not undefined.verified
    json.dumps(undefined.as_dict(), allow_nan=False)


def test_rows_of_user_code_are_judged_separately(model: ReducedModel) -> None:
    class Both:
        name = "both joints"

        def evaluate(self, times: Floats, positions: Floats) -> tuple[ArrayLike, ArrayLike, ArrayLike]:
            return positions, (-2.0, -0.1), (2.0, -0.05)

    certificate = verify(model, quintic(model, SWEEP, 1.0), goals=(), sampled=[Both()])
    check = next(check for check in certificate.checks if check.name == "path: both joints")
    assert check.subject == "row 1"
    assert check.slack == pytest.approx(-0.05)


def test_notes_list_the_assumptions(tmp_path: Path) -> None:
    two = robot(
        tmp_path,
        link("base"), link("a", length=0.2), link("b", length=0.2), link("c", length=0.2),
        joint("j1", "base", "a"), joint("j2", "a", "b", x=0.3), joint("j3", "b", "c", x=0.3),
    )  # fmt: skip
    one = replace(two, groups={"arm": replace(two.group("all"), name="arm", joints=("j1",))})
    scene = (
        Scene(one)
        .add("table", Box(0.1, 0.1, 0.1), placement((0, 0, -1)))
        .allow_contact("rest", "a", "table", depth=2e-3, first=0.1)
    )
    model = reduce_model(scene, "arm", one.positions({"j2": 3.5}))
    notes = " / ".join(verify(model, quintic(model, [[0.0], [0.5]], 1.0), goals=()).notes)
    assert "j2 stands 28.65 deg outside its limits" in notes
    assert "limit chosen: j1 acceleration" in notes
    assert "contact of a and table is accepted (rest): at most 2 mm" in notes
    assert "do not move against each other, not judged: a - c" in notes


def test_one_judge_for_many_motions(model: ReducedModel) -> None:
    judge = Judge(model)
    asked = Specification(goals=[joint_positions({"shoulder": 1.0})])
    first, again = (judge.certify(quintic(model, SWEEP, 1.0), asked) for _ in range(2))
    assert first.as_dict() == again.as_dict()
    assert (
        judge.certify(quintic(model, [[-1.0, 0.0], [0.5, 0.0]], 1.0), asked).failed[0].name == "goal: joints"
    )


def test_scaled_limits_are_the_ones_judged(model: ReducedModel) -> None:
    slow = model.limits.scaled(velocity=0.1, acceleration=1.0)
    certificate = verify(model, quintic(model, SWEEP, 1.0), goals=(), limits=slow)
    assert [check.name for check in certificate.failed] == ["velocity"]
    with pytest.raises(ProblemError, match="limits are of shoulder"):
        verify(model, quintic(model, SWEEP, 1.0), goals=(), limits=slow.take(np.array([0])))
