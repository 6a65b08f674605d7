"""Proofs of three arms, and the checker loaded into this process."""

import hashlib
import json
import runpy
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import trajopt as to
from trajopt.files.proof.proof import CHECKER

Document = dict[str, Any]


@dataclass(frozen=True)
class Proof:
    """The parts of a proof file."""

    statement: Document
    witness: bytes

    @staticmethod
    def read(path: Path) -> "Proof":
        head, _, rest = path.read_bytes().partition(b"\n")
        length = int(head.split()[1])
        return Proof(json.loads(rest[:length]), rest[length + 32 :])

    @property
    def data(self) -> bytes:
        said = json.dumps(self.statement).encode()
        return b"proof/1 %d\n" % len(said) + said + hashlib.sha256(said).digest() + self.witness

    def write(self, path: Path) -> Path:
        path.write_bytes(self.data)
        return path


@dataclass(frozen=True)
class Checker:
    """The checker's modules and its answer: the first fault, empty if the file is proven."""

    modules: dict[str, ModuleType]
    malformed: type[Exception]
    examined: Callable[[Path], tuple[str, str]]

    def fault(self, path: Path) -> str:
        return self.examined(path)[1]


@contextmanager
def loaded_checker() -> Iterator[Checker]:
    """Load the checker as `python -I checker` does; its modules have short names, which are taken back."""
    names = {path.stem for path in CHECKER.glob("*.py")} - {"__main__"}
    before = set(sys.modules)
    main = runpy.run_path(str(CHECKER), run_name="checker")
    loaded = {name: sys.modules.pop(name) for name in names & (set(sys.modules) - before)}
    assert set(loaded) == names
    yield Checker(loaded, main["Malformed"], main["examined"])


@pytest.fixture(scope="session")
def checker() -> Iterator[Checker]:
    with loaded_checker() as found:
        yield found


def planned(problem: to.Problem, path: Path) -> Proof:
    to.plan(problem).require().save_proof(path)
    return Proof.read(path)


@pytest.fixture(scope="session")
def planar_plan() -> to.Plan:
    return to.plan(planar_problem()).require()


@pytest.fixture(scope="session")
def planar(planar_plan: to.Plan, tmp_path_factory: pytest.TempPathFactory) -> Proof:
    path = tmp_path_factory.mktemp("planar") / "planar.proof"
    planar_plan.save_proof(path)
    return Proof.read(path)


@pytest.fixture(scope="session")
def required(tmp_path_factory: pytest.TempPathFactory) -> Proof:
    """A proof with every kind of requirement."""
    return planned(requirements_problem(), tmp_path_factory.mktemp("required") / "required.proof")


@pytest.fixture(scope="session")
def moving(tmp_path_factory: pytest.TempPathFactory) -> Proof:
    """A proof among objects that move, appear and expire."""
    return planned(moving_problem(), tmp_path_factory.mktemp("moving") / "moving.proof")


def moving_problem() -> to.Problem:
    """A bar that turns and crosses with an error, a ball that leaves, and a ball that comes."""
    scene = to.Scene(to.load("planar2"))
    places = [
        to.placement((0.75, -0.9, 0.14)),
        to.placement((0.75, -0.3, 0.14), rpy=(0.0, 0.0, 1.5)),
        to.placement((1.2, 0.6, 0.14), rpy=(0.0, 0.3, 2.0)),
    ]
    track = to.Track.through([0.0, 0.7, 1.9], places)
    scene = scene.add("bar", to.Box(0.3, 0.03, 0.03), motion=to.Prediction(track, (0.002, 0.003, 0.001)))
    scene = scene.add("leaving", to.Sphere(0.05), to.placement((0.5, 0.5, 0.1)), expires=0.3)
    scene = scene.add("coming", to.Sphere(0.05), to.placement((0.85, 0.0, 0.2)), appears=1.2)
    start, goal = {"joint1": -1.1, "joint2": 0.3}, {"joint1": 0.9, "joint2": 0.4}
    return to.Problem(scene=scene, start=start, goal=to.joint_positions(goal), name="moving")


def planar_problem() -> to.Problem:
    scene = to.Scene(to.load("planar2")).add("post", to.Cylinder(0.04, 0.4), to.placement((0.65, 0.0, 0.1)))
    start, goal = {"joint1": -1.1, "joint2": 0.3}, {"joint1": 0.9, "joint2": 0.4}
    return to.Problem(scene=scene, start=start, goal=to.joint_positions(goal), name="planar fold")


def requirements_problem() -> to.Problem:
    room = to.position_in_region("tool", to.Box(4.0, 4.0, 0.5), to.placement((0.0, 0.0, 0.0)))
    ball = to.position_in_region("tool", to.Sphere(3.0))
    return to.Problem(
        scene=to.Scene(to.load("planar2")),
        start={"joint1": 0.0, "joint2": 0.3},
        goal=(
            to.joint_positions({"joint1": 0.9, "joint2": 0.4}),
            to.axis_alignment("tool", tolerance=0.2),
            to.position_in_region("tool", to.Plane(), to.placement((0.0, 0.0, 1.0))),
        ),
        constraints=(room, ball, to.axis_alignment("tool", tolerance=0.1)),
        tool_speed=to.tool_speed("tool", linear=0.6),
        name="requirements",
    )
