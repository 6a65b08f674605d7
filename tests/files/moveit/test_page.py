"""docs/from-moveit.md: its scene and request are planned, checked and exported as it says."""

import json
import os
import sys
from pathlib import Path

import pytest

import trajopt as to
from tests.pages import Page
from trajopt.files.moveit import read_request, read_scene, read_trajectory


def test_its_files_are_planned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    try:
        panda = to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin" / "trajopt").write_text(f'#!/bin/sh\nexec {sys.executable} -m trajopt "$@"\n')
    (tmp_path / "bin" / "trajopt").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}")
    Page("from-moveit.md", tmp_path).run("Scene and request files")
    document = json.loads((tmp_path / "plan.json").read_text())
    assert document["verified"] and not document["notes"][len(panda.notes) + 1 :]
    asked = read_request(tmp_path / "request.yaml", read_scene(tmp_path / "scene.yaml", panda))
    assert set(asked.scene.objects) == {"table", "pillar"} and asked.velocity_scaling == 0.5
    motion = read_trajectory(tmp_path / "goal.yaml")
    ends = dict(zip(motion.joint_names, motion.positions[-1].tolist(), strict=True))
    hand = asked.scene.placement_of("panda_hand_tcp", panda.positions(ends))
    assert hand.translation == pytest.approx((0.4, 0.3, 0.3), abs=2e-3)
