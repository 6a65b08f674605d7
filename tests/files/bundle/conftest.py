"""A small problem that is solved, and the bundle that keeps it."""

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest

import trajopt as to
from trajopt.files.bundle.containers import digest
from trajopt.planning import Result


@pytest.fixture(scope="session")
def solved() -> Result:
    """Two joints in the plane, past a ball."""
    scene = to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    problem = to.Problem(
        scene=scene, start=[0.0, 0.4], goal={"joint1": 1.4, "joint2": 0.4}, name="past a ball"
    )
    return to.plan(problem)


@pytest.fixture
def kept(solved: Result, tmp_path: Path) -> Path:
    """The bundle of it."""
    solved.save(tmp_path / "kept.trajopt")
    return tmp_path / "kept.trajopt"


def members_of(path: Path) -> dict[str, bytes]:
    """Return the members of a bundle."""
    with zipfile.ZipFile(path) as file:
        return {name: file.read(name) for name in file.namelist()}


def write_members(path: Path, members: Mapping[str, bytes]) -> Path:
    """Write members as they are, with digests that fit them."""
    about = json.loads(members["bundle.json"])
    about["members"] = {name: digest(data) for name, data in members.items() if name != "bundle.json"}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in {**members, "bundle.json": json.dumps(about).encode()}.items():
            file.writestr(name, data)
    return path
