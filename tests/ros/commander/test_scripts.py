"""The scripts that show the way from MoveIt run as printed: from a shell, without a display."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from trajopt.values.errors import MissingExtra

FOLDER = Path(__file__).parents[3] / "examples" / "from_moveit"
SCRIPTS = sorted(FOLDER.glob("*.py"))


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_script(path: Path) -> None:
    try:
        __import__("trajopt").load("panda")
    except MissingExtra:
        pytest.skip("the Panda's meshes are not installed")
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "MUJOCO_GL")}
    told = subprocess.run(
        [sys.executable, str(path)],
        capture_output=True,
        text=True,
        env={**environment, "OMP_NUM_THREADS": "1"},
        check=False,
    )
    assert told.returncode == 0, told.stdout + told.stderr
    assert told.stderr == ""
    assert "verified: all" in told.stdout
    assert "FAIL" not in told.stdout


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_scripts_use_public_names_only(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            module = node.module or ""
            assert not module.startswith("trajopt.") or module.startswith("trajopt.ros")
        if isinstance(node, ast.Attribute):
            assert not node.attr.startswith("_")
