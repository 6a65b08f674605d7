"""A kind of requirement that a package adds as the page says: planned, judged, explained and read."""

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import trajopt as to
from tests.test_extending import blocks, files
from trajopt.files.moveit import read_request
from trajopt.files.moveit.constraints import READERS
from trajopt.optimise.methods import method_named
from trajopt.optimise.terms import constrain
from trajopt.planning.infeasibility import box_breaks, exclusion
from trajopt.planning.status import Status
from trajopt.problem.requirements import Requirement
from trajopt.problem.residual import WHOLE
from trajopt.values.errors import ProblemError
from trajopt.verify import Evidence

START = {"joint1": -1.0, "joint2": 0.3}
GOAL = {"joint1": 1.0, "joint2": 0.3}
WALL = 0.8
"""Beyond the start and the goal of the tool, and nearer than its straight way between them [m]."""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """The page's package; only its data is imported, the rest is found by its entry point."""
    folder = tmp_path_factory.mktemp("site")
    for name, text in files().items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    (folder / "behind" / "__init__.py").touch()
    modules = [Path(name).stem for name in files() if not name.endswith("data.py")]
    (folder / "behind-1.0.dist-info").mkdir()
    (folder / "behind-1.0.dist-info" / "METADATA").write_text("Name: behind\nVersion: 1.0\n")
    entries = "\n".join(f"{module} = behind.{module}" for module in modules)
    (folder / "behind-1.0.dist-info" / "entry_points.txt").write_text(f"[trajopt.requirements]\n{entries}\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        yield importlib.import_module("behind.data")
    READERS.pop("plane_constraints", None)
    for name in [name for name in sys.modules if name.split(".")[0] == "behind"]:
        del sys.modules[name]


@pytest.fixture
def behind(package: ModuleType) -> Any:
    return package.stays_behind("tool", (2.0, 0.0, 0.0), WALL)


def problem(*required: Requirement, **changes: Any) -> to.Problem:
    scene, goal = to.Scene(to.load("planar2")), to.joint_positions(GOAL)
    return to.Problem(**{"scene": scene, "start": START, "goal": goal, "constraints": required, **changes})


def test_the_page_has_the_three_files_and_a_reader() -> None:
    assert set(files()) == {f"behind/{name}.py" for name in ("data", "term", "check", "reading")}
    assert 'entry-points."trajopt.requirements"' in "".join(blocks("toml"))


def test_it_is_planned_and_proven(behind: Any) -> None:
    result = to.plan(problem(behind))
    certificate = result.require().certificate
    (check,) = (item for item in certificate.checks if item.name == "path: behind")
    assert check.holds and check.evidence is Evidence.PROVEN
    assert check.value is not None and WALL - 0.01 < check.value <= WALL + 1e-6, "it is active"
    free = to.plan(problem()).require()
    farthest = max(
        problem().scene.placement_of("tool", q).translation[0]
        for q in map(problem().reduced.all_positions, free.path.knots)
    )
    assert farthest > WALL + 0.01


def test_it_can_be_a_waypoint(package: ModuleType) -> None:
    near = package.stays_behind("tool", (1.0, 0.0, 0.0), 0.3)
    certificate = to.plan(problem(waypoints={"near": near})).require().certificate
    (check,) = (item for item in certificate.checks if item.name.startswith("waypoint near"))
    assert check.holds and check.value is not None and check.value <= 0.3 + 1e-6


def test_it_is_relaxed_where_it_is_in_the_way(behind: Any) -> None:
    result = to.plan(problem(behind, goal=to.joint_positions({"joint1": 0.0, "joint2": 0.3})))
    assert result.status is Status.GOAL_BREAKS_CONSTRAINT
    remedies = result.explain(plan_again=True).remedies
    (remedy,) = (item for item in remedies or () if item.what == "plane before tool")
    assert 0.05 < remedy.amount < 0.11 and remedy.result.verified


def test_proofs_of_infeasibility_know_nothing_of_it(behind: Any) -> None:
    reduced = problem().reduced
    assert exclusion(behind, to.axis_alignment("tool", tolerance=0.1), reduced) == ""
    assert not box_breaks(behind, reduced, reduced.limits.lower, reduced.limits.upper)


def test_methods_of_casadi_object_by_name(behind: Any) -> None:
    result = to.plan(problem(behind), method=method_named("ipopt"))
    assert result.status is Status.METHOD_CANNOT
    assert "'coordinate of tool' has no CasADi expression" in result.reason


def test_it_is_read_from_a_request(package: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "request.yaml").write_text(
        "{group_name: arm, goal_constraints: [{joint_constraints: ["
        "{joint_name: joint1, position: 1.0}, {joint_name: joint2, position: 0.3}]}],"
        "path_constraints: {plane_constraints: ["
        f"{{link_name: tool, direction: [1, 0, 0], most: {WALL}}}]}}}}"
    )
    request = read_request(tmp_path / "request.yaml", problem().scene)
    (required,) = request.constraints
    assert isinstance(required, package.StaysBehind) and required.most == WALL


def test_error_for_an_unregistered_requirement_names_the_entry_point() -> None:
    class Unknown(Requirement):
        pass

    with pytest.raises(ProblemError, match=r"no term is registered for Unknown.*trajopt\.requirements"):
        constrain(Unknown(), problem().reduced, WHOLE)
