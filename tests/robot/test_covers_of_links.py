"""What a user is told of the covers of links: those that stay coarse, and how far a long load is."""

from itertools import count
from pathlib import Path

import pytest

import trajopt as to
from tests.robot.test_robot import tetrahedron

LINK = '<link name="{0}"><collision><geometry><mesh filename="{1}"/></geometry></collision></link>'


@pytest.fixture
def arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Four links with one mesh: two corners of cubes far apart, which one hull covers badly."""
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path / "cache"))
    far = tetrahedron().replace("vertex 0 ", "vertex 9 ").replace("vertex 1 ", "vertex 10 ")
    (tmp_path / "two.stl").write_text(f"{tetrahedron()}\n{far}\n")
    links = [LINK.format(f"link{number}", tmp_path / "two.stl") for number in range(4)]
    joints = [
        f'<joint name="joint{number}" type="revolute"><parent link="link{number}"/>'
        f'<child link="link{number + 1}"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        for number in range(3)
    ]
    path = tmp_path / "arm.urdf"
    path.write_text(f'<robot name="arm">{"".join(links + joints)}</robot>')
    return path


def test_a_cover_that_stays_coarse_is_a_note_on_the_robot(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert to.load(arm).notes == ()
    monkeypatch.setattr("trajopt.robot.bodies._MOST_WORK", 0)
    arm.with_name("two.stl").write_text(
        arm.with_name("two.stl").read_text() + "\n"
    )  # another file to the cache
    for _ in range(2):  # made, and from the cache
        (note,) = to.load(arm).notes
        assert note.startswith("collision mesh of link0, link1, link2, link3: ")
        assert "protrude by up to" in note


def test_progress_is_reported_after_a_second(
    arm: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    to.load(arm)
    assert not caplog.records
    clock = count(0.0, 0.7)  # Seconds from one mesh to the next.
    monkeypatch.setattr("trajopt.robot.bodies.monotonic", lambda: next(clock))
    to.load(arm)
    (record,) = caplog.records
    assert record.name == "trajopt.robot"
    assert record.getMessage().endswith("2 of 4 done, last link1")
