"""What takes long to import is imported when it is used, not with trajopt."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import trajopt as to
from tests.model.test_robot import tetrahedron
from tests.robots_for_tests import ODD_ARM

SLOW = {
    *("casadi", "clarabel", "imageio", "matplotlib", "mujoco", "osqp", "piqp", "placo", "proxsuite"),
    *("qpsolvers", "rich", "scipy", "toppra", "typer", "viser", "yaml"),
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
    """`from trajopt.simulate import simulate, render` is cheap: calling them imports MuJoCo."""
    code = "from trajopt.simulate import CameraView, Layout, build_spec, render, simulate, simulate_phases"
    assert imported(code, tmp_path) == set()


def test_planning_imports_no_slow_package(tmp_path: Path) -> None:
    """Splines are the house's own, and meshes were loaded before; joint limits are YAML."""
    try:
        to.load("panda")
    except to.MissingExtra as missing:
        pytest.skip(str(missing))
    imported(PLAN, tmp_path)
    assert imported(PLAN, tmp_path) == {"yaml"}


def test_setting_up_a_problem_imports_no_slow_package(tmp_path: Path) -> None:
    """A robot with a mesh that was loaded before needs neither a hull nor a decomposition."""
    (tmp_path / "wedge.stl").write_text(tetrahedron())
    box, mesh = '<box size="0.1 0.1 0.1"/>', '<mesh filename="wedge.stl" scale="0.1 0.1 0.1"/>'
    (tmp_path / "odd.urdf").write_text(ODD_ARM.replace(box, mesh))
    code = f"import trajopt as to\nrobot = to.load({str(tmp_path / 'odd.urdf')!r}){PROBLEM}"
    assert imported(code, tmp_path) == {"scipy"}
    assert imported(code, tmp_path) == set()
