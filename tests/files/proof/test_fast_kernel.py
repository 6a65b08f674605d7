"""The fast kernel agrees with the checker on every leaf, and accepts nothing that the checker refuses."""

import copy
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import trajopt as to
from benchmarks.proof_mutations import KINDS, proofs
from tests.cli.process import trajopt
from tests.files.proof.conftest import Checker, Document, Proof
from tests.files.proof.test_attacks import BAD, changed
from trajopt.files.proof import MotionProof
from trajopt.native.checker import StatedProof
from trajopt.values.errors import FileFormatError


class Recorder:
    """Numpy, with the failing leaves that the checker looks for at both ends."""

    def __init__(self) -> None:
        self.failing: list[Any] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)

    def flatnonzero(self, values: Any) -> Any:
        self.failing.append(np.flatnonzero(values))
        return self.failing[-1][:0]


@pytest.fixture
def failing(checker: Checker, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Proof], set[int]]]:
    """Return all leaves that the checker refuses."""
    module: ModuleType = checker.modules["clearance"]
    modules = checker.modules

    def found(proof: Proof) -> set[int]:
        recorder = Recorder()
        monkeypatch.setattr(module, "np", recorder)
        statement = modules["statement"].read_statement(proof.statement)
        witness = modules["witness"].read_witness(proof.witness, statement)
        arm = modules["kinematics"].GridKinematics(statement, witness.grid)
        assert list(module.check(statement, witness, arm)) == []
        return {int(leaf) for leaves in recorder.failing for leaf in leaves}

    yield found


def fast_failing(proof: Proof) -> set[int]:
    holds = StatedProof(proof.statement, proof.witness).leaves()
    return set(np.flatnonzero(~np.array(holds)).tolist())


@pytest.mark.parametrize("name", ["planar", "required", "moving"])
@pytest.mark.parametrize("clearance", [0.0, 0.05, 2.0])
def test_every_leaf_is_decided_as_by_the_checker(
    name: str, clearance: float, request: pytest.FixtureRequest, failing: Callable[[Proof], set[int]]
) -> None:
    proof: Proof = request.getfixturevalue(name)
    statement = copy.deepcopy(proof.statement)
    for pair in statement["pairs"]:
        pair[2] += clearance
    due = failing(Proof(statement, proof.witness))
    assert fast_failing(Proof(statement, proof.witness)) == due
    assert due or clearance < 2.0
    assert not due or clearance > 0.0


def fault(data: bytes) -> str:
    """Return the fault of the fast kernel, or the reason why it is not a proof."""
    try:
        return MotionProof(data).fast_fault
    except FileFormatError as error:
        return str(error)


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> list[Proof]:
    return proofs(tmp_path_factory.mktemp("sound"))


@pytest.mark.parametrize("kind", KINDS)
def test_it_accepts_no_mutation_that_the_checker_refuses(
    kind: str, sound: list[Proof], tmp_path: Path, checker: Checker
) -> None:
    for seed in range(1000, 1016):
        proof, other = sound[seed % 4], sound[(seed + 1) % 4]
        data = KINDS[kind](proof, other, np.random.default_rng(seed))
        path = tmp_path / "x.proof"
        path.write_bytes(data)
        try:
            due = checker.fault(path)
        except checker.malformed as error:
            due = str(error)
        assert bool(fault(data)) == bool(due), (seed, fault(data), due)


MALFORMED: dict[str, Callable[[Document], object]] = {
    "a name too many": lambda s: s.update(more=1),
    "a name too few": lambda s: s.pop("judged"),
    "no number": lambda s: s.update(excess=math.nan),
    "a number that is too large": lambda s: s["ends"].update(tolerance=10**400),
    "true for a number": lambda s: s.update(excess=True),
    "a parent behind its child": lambda s: s["joints"][0]["place"].update(joint=2),
    "a part that is not there": lambda s: s["pairs"][0].__setitem__(0, 999),
    "a hull without points": lambda s: s["parts"][0].update(
        shape={"kind": "hull", "vertices": [], "radius": 1}
    ),
    "an unknown kind": lambda s: s["requirements"][0].update(kind="magic"),
    "no direction": lambda s: s["joints"][0].update(axis=[0.0, 0.0, 1e-9]),
    "times that stand still": lambda s: s["motion"]["times"].__setitem__(1, 0.0),
    "a row too few": lambda s: s["motion"]["values"][0].pop(),
}


@pytest.mark.parametrize("name", MALFORMED)
def test_malformed_statements_are_refused(name: str, planar: Proof) -> None:
    statement = copy.deepcopy(planar.statement)
    MALFORMED[name](statement)
    found = MotionProof(Proof(statement, planar.witness).data)
    assert "read" in fault(found.data)
    with pytest.raises(FileFormatError):
        found.check(fast=True)
    with pytest.raises(ValueError, match=r"\w"):
        StatedProof(statement, planar.witness)


def test_a_wrong_hash_and_short_witnesses_are_refused(planar: Proof) -> None:
    assert "SHA-256" in fault(planar.data.replace(b"planar fold", b"planar full"))
    for length in range(0, len(planar.witness), 7):
        assert "the witness is shorter" in fault(Proof(planar.statement, planar.witness[:length]).data)


def test_joints_may_have_turned_thousands_of_times(tmp_path: Path, planar: Proof, checker: Checker) -> None:
    statement = copy.deepcopy(planar.statement)
    statement["requirements"] = []
    for joint in statement["joints"]:
        joint["offset"] += 6000.0 * math.tau
        joint["lower"] = joint["upper"] = None
    turned = Proof(statement, planar.witness)
    assert fault(turned.data) == "" == checker.fault(turned.write(tmp_path / "x.proof"))
    statement["joints"][0]["offset"] += 0.5
    assert "leaf" in fault(Proof(statement, planar.witness).data)


def test_the_command_takes_the_fast_kernel(tmp_path: Path, planar: Proof) -> None:
    done = trajopt("check", str(planar.write(tmp_path / "x.proof")), "--fast")
    assert done.returncode == 0
    assert "planar fold: PROVEN by the fast kernel" in done.stdout
    statement = copy.deepcopy(planar.statement)
    statement["pairs"][0][2] = 0.4
    done = trajopt("check", str(Proof(statement, planar.witness).write(tmp_path / "y.proof")), "--fast")
    assert done.returncode == 1
    assert re.search(r"NOT PROVEN: leaf \d+", done.stdout)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match=r"nothing.proof: cannot be read"):
        MotionProof.read(tmp_path / "nothing.proof")


def test_motions_of_an_arm_with_meshes_are_proven(tmp_path: Path) -> None:
    scene = to.Scene(to.load("panda")).add("pillar", to.Cylinder(0.05, 0.8), to.placement((0.4, 0.3, 0.4)))
    start = dict(zip(scene.robot.joint_names[:7], (0.0, -0.6, 0.0, -2.2, 0.0, 1.7, 0.8), strict=True))
    goal = to.frame_placement("panda_hand_tcp", to.placement((0.3, -0.4, 0.5), rpy=(3.1, 0.0, 0.4)))
    problem = to.Problem(scene=scene, group="panda_arm", start=start, goal=goal, name="panda")
    to.plan(problem).require().save_proof(tmp_path / "x.proof")
    assert MotionProof.read(tmp_path / "x.proof").fast_fault == ""


@pytest.mark.parametrize("name", BAD)
def test_bad_statements_are_not_confirmed(name: str, planar: Proof) -> None:
    """The checker refuses to read them."""
    try:
        assert MotionProof(changed(planar, BAD[name]).data).fast_fault
    except FileFormatError:
        pass
