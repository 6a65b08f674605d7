"""Changed proofs that the checker accepts are true at all sampled times."""

import copy
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.proof_mutations import CRASH, FALSE, KINDS, MALFORMED, UNSHOWN, outcome, proofs
from tests.files.proof.conftest import Checker, Document, Proof
from tests.files.proof.dense import refuted


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> list[Proof]:
    return proofs(tmp_path_factory.mktemp("sound"))


@pytest.mark.parametrize("kind", KINDS)
def test_no_false_statement_is_accepted(
    kind: str, sound: list[Proof], tmp_path: Path, checker: Checker
) -> None:
    found = set[str]()
    for seed in range(16):
        proof, other = sound[seed % len(sound)], sound[(seed + 1) % len(sound)]
        data = KINDS[kind](proof, other, np.random.default_rng(seed))
        found.add(outcome(checker, data, proof.statement, tmp_path / "x.proof")[0])
    assert found & {MALFORMED, UNSHOWN}
    assert not found & {FALSE, CRASH}


MADE_FALSE: dict[str, Callable[[Document], object]] = {
    "clearance": lambda s: [pair.__setitem__(2, 0.3) for pair in s["pairs"]],
    "pairs": lambda s: s["pairs"].clear(),
    "limits": lambda s: s["joints"][0].update(velocity=0.1),
    "start": lambda s: s["ends"]["positions"].__setitem__(0, 0.0),
    "end": lambda s: s["motion"]["values"][1][-1].__setitem__(0, 0.1),
    "jump": lambda s: s["motion"]["values"][2][-1].__setitem__(0, 0.5),
    "requirements": lambda s: [UNMET[each["kind"]](each) for each in s["requirements"]],
}
UNMET: dict[str, Callable[[Document], object]] = {
    "joint positions": lambda each: each["ranges"][0].__setitem__(2, -3.0),
    "axis alignment": lambda each: each.update(direction=[0.3, 0.0, 1.0]),
    "position in region": lambda each: each["members"][0][2].update(translation=[9.0, 0.0, 0.0]),
    "frame placement": lambda each: each["goal"].update(rotation=[1.0, 0.0, 0.0, 0.0]),
    "tool speed": lambda each: each.update(limit=0.3),
    "angular speed": lambda each: each.update(limit=0.3),
    "torque": lambda each: each["limits"].__setitem__(0, [0, 0.01]),
    "held placement": lambda each: each.update(position=[0.01, 0.01, 0.01]),
    "part": lambda each: each.update(since=0.0),
    "rest": lambda each: each.update(since=0.5),
    "steady speed": lambda each: each.update(least=1.0),
    "gravity torque": lambda each: each["limits"].__setitem__(0, [0, 0.0]),
    "cloud": lambda each: each["inside"][-1][1][0].__setitem__(2, 9.0),
    "waypoint": lambda each: each.update(time=each["time"] + 0.1),
}


@pytest.mark.parametrize("name", MADE_FALSE)
def test_the_dense_check_refutes_false_statements(name: str, sound: list[Proof]) -> None:
    for proof in sound:
        assert list(refuted(proof.statement)) == []
        statement = copy.deepcopy(proof.statement)
        MADE_FALSE[name](statement)
        assert len(list(refuted(statement))) >= (
            len(statement["requirements"]) if name == "requirements" else 1
        )


def test_the_dense_check_is_not_misled_by_huge_shapes(sound: list[Proof]) -> None:
    """Coal reports contact with a box that has one corner far above the arm."""
    statement = copy.deepcopy(sound[3].statement)
    late = next(part for part in statement["parts"] if part["owner"] == "late")
    late["shape"]["vertices"][1][2] = 9e11
    assert list(refuted(statement)) == []


def test_the_dense_check_is_not_misled_by_far_points(sound: list[Proof]) -> None:
    """Far up along the arm's axes a point is as fast as below, but its differences are rounded."""
    statement = copy.deepcopy(sound[1].statement)
    speed = next(each for each in statement["requirements"] if each["kind"] == "tool speed")
    speed["place"]["translation"][2] = 9e11
    assert list(refuted(statement)) == []
