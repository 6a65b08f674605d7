"""What takes long to import is imported when it is used, not with trajopt."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import trajopt as to
from tests.robot.test_robot import tetrahedron
from tests.robots_for_tests import ODD_ARM

SLOW = {
    *("av", "casadi", "clarabel", "matplotlib", "mujoco", "osqp", "piqp", "placo", "proxsuite"),
    *("pygame", "qpsolvers", "rich", "scipy", "toppra", "typer", "viser", "yaml"),
}

PROBLEM = """
to.Problem(
    scene=to.Scene(robot).add("post", to.Box(0.1, 0.1, 1.0), to.placement((1, 1, 0), rpy=(0, 0, 0.3))),
    start={}, goal=to.joint_positions({"pan": 1.0}),
).reduced
"""

PLAN = """
import trajopt as to
scene = to.Scene(to.load("panda")).add("post", to.Box(0.1, 0.1, 0.6), to.placement((0.5, 0.25, 0.3)))
posture = to.joint_positions({"panda_joint1": 1.0})
place = to.frame_placement("panda_hand", to.placement((0.3, -0.4, 0.5), rpy=(3.1, 0, 0)))
for goal in (posture, place):
    assert to.plan(to.Problem(scene=scene, group="panda_arm", start="ready", goal=goal)).verified
"""


def imported(code: str, folder: Path) -> set[str]:
    """Return which of the slow packages a fresh interpreter has imported after some code."""
    told = subprocess.run(
        [
            sys.executable,
            "-c",
            f"{code}\nimport sys\nprint(*(name for name in sys.modules if '.' not in name))",
        ],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "TRAJOPT_CACHE_DIR": str(folder)},
    )
    return SLOW & set(told.stdout.split())


def test_importing_trajopt_imports_no_slow_package(tmp_path: Path) -> None:
    assert imported("import trajopt", tmp_path) == set()


def test_importing_simulate_imports_no_slow_package(tmp_path: Path) -> None:
    """`from trajopt.simulation import simulate, render` is cheap: calling them imports MuJoCo."""
    code = "from trajopt.simulation import CameraView, Layout, build_spec, render, simulate, simulate_phases"
    assert imported(code, tmp_path) == set()


def test_planning_imports_no_slow_package(tmp_path: Path) -> None:
    """Splines are the house's own, and meshes were loaded before; joint limits are YAML."""
    try:
        to.load("panda")
    except to.MissingExtra as missing:
        pytest.skip(str(missing))
    imported(PLAN, tmp_path)
    assert imported(PLAN, tmp_path) == {"yaml"}


def test_a_plan_and_its_certificate_import_no_masked_arrays() -> None:
    """Numpy's own median and unique import them, which takes as long as the whole of a short plan."""
    code = PLANAR.replace("assert ", "print(").replace(".verified", ".certificate)")
    told = f"{code}\nimport sys\nprint('numpy.ma' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True)
    assert "clearance" in run.stdout
    assert run.stdout.splitlines()[-1] == "False"


def test_setting_up_a_problem_imports_no_slow_package(tmp_path: Path) -> None:
    """A robot with a mesh that was loaded before needs neither a hull nor a decomposition."""
    (tmp_path / "wedge.stl").write_text(tetrahedron())
    box, mesh = '<box size="0.1 0.1 0.1"/>', '<mesh filename="wedge.stl" scale="0.1 0.1 0.1"/>'
    (tmp_path / "odd.urdf").write_text(ODD_ARM.replace(box, mesh))
    code = f"import trajopt as to\nrobot = to.load({str(tmp_path / 'odd.urdf')!r}){PROBLEM}"
    assert imported(code, tmp_path) == {"scipy"}
    assert imported(code, tmp_path) == set()


OTHER_ROOMS = {"cli", "driving", "files", "lab", "ros", "server", "simulation", "tasks", "viewer", "why"}
"""What planning does not need."""
PLANAR = """
import trajopt as to
scene = to.Scene(to.load("planar2")).add("post", to.Sphere(0.1), to.placement((1.5, 0.8, 0.0)))
goal = to.joint_positions({"joint1": 0.3, "joint2": 0.3})
assert to.plan(to.Problem(scene=scene, start={"joint1": 0.0, "joint2": 0.0}, goal=goal)).verified
"""


def rooms(code: str) -> set[str]:
    """Return which rooms a fresh interpreter has imported after some code."""
    told = "import sys; print(*(name for name in sys.modules if name.startswith('trajopt.')))"
    run = subprocess.run(
        [sys.executable, "-c", f"{code}\n{told}"], capture_output=True, text=True, check=True
    )
    return {name.split(".")[1] for name in run.stdout.splitlines()[-1].split()}


def test_planning_imports_no_other_room() -> None:
    assert rooms(PLANAR) & OTHER_ROOMS == set()


def test_a_command_imports_no_other_command() -> None:
    code = "from trajopt.cli import app_for\napp_for(['plan'])"
    assert rooms(code) & (OTHER_ROOMS - {"cli", "files", "server"}) == set()


def test_driving_loads_neither_files_nor_simulation() -> None:
    assert rooms("from trajopt.driving import Servo, Supervisor") & OTHER_ROOMS == {"driving"}


def test_the_judge_loads_without_the_planner() -> None:
    assert rooms("import trajopt.verify") <= {"native", "problem", "robot", "scene", "values", "verify"}


@pytest.mark.parametrize(
    "first", ["", "import trajopt.simulation, trajopt.viewer\n", "import trajopt.lab.suite\n"]
)
def test_public_names_are_functions(first: str) -> None:
    code = (
        f"import trajopt\n{first}from trajopt import *\n"
        "from trajopt.simulation.rollout import Rollout\n"
        "for name in ('simulate', 'view', 'explain', 'follow', 'compare'):\n"
        "    assert callable(getattr(trajopt, name)), name\n"
        "    assert name in dir(trajopt)\n"
        "assert trajopt.planning.plan.plan is trajopt.plan\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_missing_name_is_reported() -> None:
    with pytest.raises(AttributeError, match="no attribute 'simulat'"):
        _ = to.simulat  # pyright: ignore[reportAttributeAccessIssue]
