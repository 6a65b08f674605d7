"""The frame of a tool in the files that the command line reads."""

import json
from pathlib import Path

from tests.cli.test_commands import trajopt
from tests.robots_for_tests import ODD_ARM

SCENE = """
fixed_frame_transforms:
  - {header: {frame_id: tip}, child_frame_id: bit, transform: {translation: [0.1, 0, 0.05]}}
"""
REQUEST = """
group_name: all
start_state: {joint_state: {name: [pan, reach, elbow, wrist], position: [0.4, 0.1, 0.3, 0]}}
max_cartesian_speed: 0.2
cartesian_speed_limited_link: bit
goal_constraints:
  - position_constraints:
      - header: {frame_id: base}
        link_name: bit
        constraint_region:
          primitives: [{type: sphere, dimensions: [0.01]}]
          primitive_poses: [{position: [0.702, -0.248, 0.40], orientation: [0, 0, 0, 1]}]
"""


def test_a_tool_of_the_scene_file_is_planned_for_checked_and_exported(tmp_path: Path) -> None:
    (tmp_path / "odd.urdf").write_text(ODD_ARM)
    (tmp_path / "scene.yaml").write_text(SCENE)
    (tmp_path / "request.yaml").write_text(REQUEST)
    files = ["--robot", tmp_path / "odd.urdf", "--scene", tmp_path / "scene.yaml"]
    asked = ["--request", tmp_path / "request.yaml"]
    done = trajopt("plan", *files, *asked, "--out", tmp_path / "plan.json")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "bit on tip at" in done.stdout and "tool speed" in done.stdout
    assert trajopt("check", *files, *asked, tmp_path / "plan.json").returncode == 0
    exported = trajopt("export", tmp_path / "plan.json", "--to", "csv", "--out", tmp_path / "plan.csv")
    assert exported.returncode == 0, exported.stderr
    sampled = trajopt(
        "sample", *files, "--frame", "bit", "--count", "5", "--out", tmp_path / "t.npz", "--json"
    )
    assert sampled.returncode == 0, sampled.stderr
    assert json.loads(sampled.stdout)
