"""Required clearance: proven by the judge against its own value, refused where it is undercut."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.oracles.judge import PlainJudge
from tests.verify.arms import joint, link, quintic, reduced, robot
from trajopt.scene.scene import Scene
from trajopt.values.arrays import Floats
from trajopt.values.errors import FrameNotFound, ModelError, ShapeError
from trajopt.verify import Certificate, Check, Evidence, Judge, Moment, Specification

JUDGES = (PlainJudge, Judge)
RADIUS = 0.05


def gantry(folder: Path) -> Scene:
    """A ball of radius 0.05 m on three slides along x, y and z."""
    frame = robot(
        folder,
        link("base"),
        link("rail"),
        link("bridge"),
        link("hand"),
        joint("x", "base", "rail", kind="prismatic", axis="1 0 0"),
        joint("y", "rail", "bridge", kind="prismatic", axis="0 1 0"),
        joint("z", "bridge", "hand", kind="prismatic", axis="0 0 1"),
    )
    return Scene(frame).add("ball", to.Sphere(RADIUS), frame="hand", touch_links=["hand"])


def walled(folder: Path) -> Scene:
    """The ball with a wall whose face is at x = 0.15 m: 0.1 m from the ball at x = 0."""
    return gantry(folder).add("wall", to.Box(0.1, 2.0, 2.0), to.placement((0.2, 0.0, 0.0)))


def judged(scene: Scene, knots: list[list[float]], judge: type[Judge]) -> Certificate:
    model = reduced(scene, knots[0])
    return judge(model).certify(quintic(model, knots, 1.0), Specification(goals=()))


def rows(certificate: Certificate) -> list[Check]:
    return [check for check in certificate.checks if check.name == "clearance"]


THERE_AND_BACK = [[0.0, 0.0, 0.0], [0.07, 0.0, 0.0], [0.0, 0.0, 0.0]]
"""It comes within exactly 30 mm of the wall."""


@pytest.mark.parametrize("judge", JUDGES)
def test_a_required_clearance_is_proven_and_shown(tmp_path: Path, judge: type[Judge]) -> None:
    certificate = judged(walled(tmp_path).with_clearance(0.0299), THERE_AND_BACK, judge)
    (row,) = rows(certificate)
    assert certificate.verified and row.evidence is Evidence.PROVEN
    assert row.bound == 0.0299 and row.value is not None and 0.0299 < row.value <= 0.03
    assert row.slack == pytest.approx(row.value - 0.0299)
    assert row.detail.endswith("29.9 mm are required") and "29.9  mm" in str(certificate)
    assert certificate.required == (0.0299, 0.0299)
    assert certificate.as_dict()["required"] == [0.0299, 0.0299]
    assert certificate.pairs[0].required == 0.0299


@pytest.mark.parametrize("judge", JUDGES)
def test_a_motion_below_the_required_clearance_is_refused(tmp_path: Path, judge: type[Judge]) -> None:
    certificate = judged(walled(tmp_path).with_clearance(0.0301), THERE_AND_BACK, judge)
    (row,) = rows(certificate)
    assert not certificate.verified and row.evidence is Evidence.SAMPLED
    assert row.bound == 0.0301 and row.value == pytest.approx(0.03, abs=1e-5)
    assert row.slack == pytest.approx(-1e-4, abs=1e-5) and row.time == pytest.approx(0.5, abs=0.01)
    assert "ball - wall come within 30.00 mm" in row.detail.replace("wall - ball", "ball - wall")
    assert "30.1 mm are required" in row.detail


@pytest.mark.parametrize("judge", JUDGES)
def test_one_pair_has_its_own(tmp_path: Path, judge: type[Judge]) -> None:
    scene = walled(tmp_path).add("person", to.Sphere(0.1), to.placement((0.0, 0.4, 0.0)))
    # The person is 0.25 m away all the time, the wall comes within 30 mm.
    kept = judged(scene.with_clearance(0.24, "ball", "person"), THERE_AND_BACK, judge)
    assert kept.verified
    wall, person = rows(kept)
    assert (wall.bound, person.bound) == (0.0, 0.24)
    assert "wall" in wall.subject and "person" in person.subject
    assert wall.value == pytest.approx(0.03, abs=2e-3) and person.value == pytest.approx(0.25, abs=3e-3)
    assert "of which 240 mm are required" in person.detail
    broken = judged(scene.with_clearance(0.26, "ball", "person"), THERE_AND_BACK, judge)
    (row,) = broken.failed
    assert "person" in row.subject and row.bound == 0.26 and row.value == pytest.approx(0.25, abs=1e-5)
    everywhere = scene.with_clearance(0.2).with_clearance(0.02, "ball", "wall")
    assert judged(everywhere, THERE_AND_BACK, judge).verified


@pytest.mark.parametrize("judge", JUDGES)
def test_meant_contact_is_free_of_it_in_its_window_only(tmp_path: Path, judge: type[Judge]) -> None:
    scene = walled(tmp_path).with_clearance(0.02)
    leaving = [[0.0995, 0.0, 0.0], [0.0, 0.0, 0.0]]
    assert not judged(scene, leaving, judge).verified
    # A minimum-jerk way of 0.1 m in 1 s is 20 mm away after 0.33 s.
    meant = scene.allow_contact("lift off", "ball", "wall", first=0.4)
    assert judged(meant, leaving, judge).verified
    short = judged(scene.allow_contact("lift off", "ball", "wall", first=0.3), leaving, judge)
    assert [check.bound for check in short.failed if check.name == "clearance"] == [0.02]


@pytest.mark.parametrize("judge", JUDGES)
def test_verdicts_on_random_motions_match_a_formula(tmp_path: Path, judge: type[Judge]) -> None:
    rng = np.random.default_rng(11)
    verdicts: list[bool] = []
    empty = gantry(tmp_path)
    for _ in range(40):
        scene, required = empty, dict[str, float]()
        centres, sizes = rng.uniform(-0.8, 0.8, (4, 3)), rng.uniform(0.02, 0.2, 4)
        for number, (centre, size) in enumerate(zip(centres, sizes, strict=True)):
            name = f"ball{number}"
            required[name] = float(rng.choice((0.0, 0.03, 0.15)))
            scene = scene.add(name, to.Sphere(float(size)), to.placement(tuple(centre)))
            scene = scene.with_clearance(required[name], "ball", name)
        model = reduced(scene, [0.0, 0.0, 0.0])
        motion = quintic(model, rng.uniform(-0.8, 0.8, (3, 3)), 1.0)
        way: Floats = motion(np.linspace(0.0, 1.0, 20001))
        apart = np.linalg.norm(way[:, None] - centres, axis=2).min(axis=0) - sizes - RADIUS
        spare = apart - np.array(list(required.values()))
        if abs(spare).min() < 1e-4:
            continue
        certificate = judge(model).certify(motion, Specification(goals=()))
        held = all(check.holds for check in rows(certificate))
        assert held == (spare.min() > 0.0)
        verdicts.append(held)
        for row in rows(certificate):
            mine = [number for number, value in enumerate(required.values()) if value == row.bound]
            assert row.value is not None and row.value <= apart[mine].min() + 1e-4
    assert 5 < sum(verdicts) < len(verdicts) - 5


@pytest.mark.parametrize(("judge", "moment"), tuple(product(JUDGES, Moment)))
def test_a_configuration_is_examined_against_it(tmp_path: Path, judge: type[Judge], moment: Moment) -> None:
    scene = walled(tmp_path).add("far", to.Sphere(0.1), to.placement((-1.0, 0.0, 0.0)))
    seen = judge(reduced(scene.with_clearance(0.12), [0.0] * 3)).examine(np.zeros(3), moment=moment)
    (pair,) = seen.collisions
    assert {pair.first, pair.second} == {"ball", "wall"} and pair.required == 0.12
    assert pair.distance == pytest.approx(0.1, abs=2e-6)
    assert (
        pair.words.endswith("is 100.0 mm from wall, 120 mm are required") or "wall is 100.0 mm" in pair.words
    )
    assert judge(reduced(scene.with_clearance(0.09), [0.0] * 3)).examine(np.zeros(3)).clear


@pytest.mark.parametrize("judge", JUDGES)
def test_the_farther_pair_may_be_the_one_too_near(tmp_path: Path, judge: type[Judge]) -> None:
    scene = walled(tmp_path).add("person", to.Sphere(0.1), to.placement((0.0, 0.75, 0.0)))
    scene = scene.with_clearance(0.7, "ball", "person")
    seen = judge(reduced(scene, [0.0] * 3)).examine(np.zeros(3))
    (pair,) = seen.collisions
    assert {pair.first, pair.second} == {"ball", "person"}
    assert pair.distance == pytest.approx(0.6, abs=2e-6)


def test_invalid_required_clearances_are_refused(tmp_path: Path) -> None:
    scene = walled(tmp_path)
    for value, words in ((-0.01, "required clearance"), (np.nan, "value"), (np.inf, "value")):
        with pytest.raises(ShapeError, match=words):
            scene.with_clearance(value)
        with pytest.raises(ShapeError, match=words):
            scene.with_clearance(value, "ball", "wall")
    with pytest.raises(FrameNotFound, match="did you mean 'wall'"):
        scene.with_clearance(0.01, "ball", "wal")
    with pytest.raises(ModelError, match="with_clearance: name both"):
        scene.with_clearance(0.01, "ball")
    removed = scene.with_clearance(0.03, "ball", "wall").remove("wall")
    assert not removed.clearances.pairs


def test_the_margin_is_at_least_the_required_clearance(tmp_path: Path) -> None:
    scene = walled(tmp_path).with_margin(0.01).with_clearance(0.03)
    assert scene.margin_of("ball", "wall") == pytest.approx(0.035)
    assert scene.with_margin(0.05).margin_of("ball", "wall") == 0.05
    pairs = reduced(scene, [0.0] * 3).pairs
    assert (pairs.required == 0.03).all() and np.allclose(pairs.margin, 0.035)
    assert "clearance 30 mm required, margin 10 mm" in str(scene)
