"""A small campaign, and problems that end, hang or raise when they are made."""

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import trajopt as to
from tests.lab.campaign.rooms import FAULTY, PROBLEMS
from trajopt.lab.campaign import Campaign, CampaignFolder, Local, random_motions, run_campaign


@pytest.fixture(scope="session")
def scene() -> to.Scene:
    """Two joints in the plane, beside a ball."""
    return to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))


@pytest.fixture(scope="session")
def task(scene: to.Scene) -> to.Problem:
    """From one side of the ball to the other."""
    goal = {"joint1": 1.4, "joint2": 0.4}
    return to.Problem(scene=scene, start=[0.0, 0.4], goal=goal, name="past a ball")


@pytest.fixture(scope="session")
def small(scene: to.Scene) -> Campaign:
    """Twelve random motions."""
    return Campaign("small", [random_motions(scene, 12, seed=3)])


@pytest.fixture(scope="session")
def planned(small: Campaign, tmp_path_factory: pytest.TempPathFactory) -> CampaignFolder:
    """The same, planned by one process."""
    return run_campaign(small, tmp_path_factory.mktemp("campaign") / "small", Local(1))


@pytest.fixture
def faulty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Installs problems that do harm when they are made; workers find them as this process does."""
    folder = tmp_path / "installed"
    about = folder / "faulty-1.0.dist-info"
    about.mkdir(parents=True)
    (folder / "faulty_problems.py").write_text(FAULTY)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: faulty\nVersion: 1.0\n")
    entries = "".join(f"{name} = faulty_problems:{name}\n" for name in PROBLEMS)
    (about / "entry_points.txt").write_text(f"[trajopt.problems]\n{entries}")
    monkeypatch.setattr(sys, "path", [str(folder), *sys.path])
    monkeypatch.setenv("FAULTY", str(folder))
    importlib.invalidate_caches()
    yield folder
