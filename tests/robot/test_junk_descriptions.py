"""URDF and SRDF that once crashed or were taken as they came: a typed error that names the file."""

import re
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robot.test_robot import tetrahedron
from tests.robots_for_tests import ODD_ARM, odd_arm
from trajopt.values.errors import FileFormatError, MeshFileError, ShapeError

pytestmark = pytest.mark.timeout(60)

BOX = '<box size="0.1 0.1 0.1"/>'
LIMIT = '<limit lower="-2.5" upper="2.5" effort="60" velocity="2.5"/>'
BAD: dict[str, tuple[str, str, str]] = {
    "axis without a length": ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', "'pan'.*axis has no length"),
    "axis of two numbers": ('<axis xyz="0 0 1"/>', '<axis xyz="0 1"/>', "needs 3 numbers"),
    "axis that is not finite": ('<axis xyz="0 0 1"/>', '<axis xyz="nan 0 1"/>', "not finite"),
    "negative mass": ('<mass value="2"/>', '<mass value="-2"/>', "'turret'.*negative"),
    "mass that is not finite": ('<mass value="2"/>', '<mass value="nan"/>', "not finite"),
    "infinite inertia": ('ixx="0.02"', 'ixx="inf"', "not finite"),
    "limits the wrong way round": (LIMIT, LIMIT.replace("-2.5", "3"), "'elbow'.*above"),
    "velocity in words": (LIMIT, LIMIT.replace('"60"', '"fast"'), "is not a list of numbers"),
    "limit that is not finite": (LIMIT, LIMIT.replace('upper="2.5"', 'upper="nan"'), "not finite"),
    "origin in words": ('<origin xyz="0 0 0.2" rpy', '<origin xyz="a b c" rpy', "is not a list of numbers"),
    "origin that is not finite": ('<origin xyz="0 0 0.2" rpy', '<origin xyz="0 0 inf" rpy', "not finite"),
    "box of no size": (BOX, '<box size="0 0 0"/>', "positive"),
    "box of two sizes": (BOX, '<box size="1 1"/>', "needs 3 numbers"),
    "negative radius": (BOX, '<sphere radius="-1"/>', "positive"),
    "two radii": (BOX, '<sphere radius="1 2"/>', "needs 1 number"),
    "mimics in words": ('multiplier="-0.5"', 'multiplier="half"', "is not a list of numbers"),
    "mimics nothing": ('multiplier="-0.5"', 'multiplier=""', "needs 1 number"),
}


@pytest.mark.parametrize("name", BAD)
def test_numbers_that_a_robot_cannot_have(name: str, tmp_path: Path) -> None:
    old, new, reason = BAD[name]
    assert old in ODD_ARM
    (tmp_path / "odd.urdf").write_text(ODD_ARM.replace(old, new))
    with pytest.raises(FileFormatError, match=rf"odd\.urdf.*{reason}"):
        to.load(tmp_path / "odd.urdf")


FILES: dict[str, bytes] = {
    "empty": b"",
    "binary": bytes(range(256)) * 16,
    "no utf-8": ODD_ARM.replace("odd", "\u00e9").encode("latin-1"),
    "deep": b'<robot name="a">' + b"<a>" * 100_000 + b"</a>" * 100_000 + b"</robot>",
    "another root": b"<html/>",
    "entities": b'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">'
    + b"".join(b'<!ENTITY %c "%s">' % (c + 1, b"&%c;" % c * 10) for c in range(97, 110))
    + b']><robot name="&n;"/>',
    "unknown encoding": b'<?xml version="1.0" encoding="klingon"?><robot name="a"/>',
    "cut off": ODD_ARM.encode()[:900],
}


@pytest.mark.parametrize("name", FILES)
def test_files_that_are_not_descriptions_are_refused(name: str, tmp_path: Path) -> None:
    odd_arm(tmp_path)
    bad = tmp_path / "bad.xml"
    bad.write_bytes(FILES[name])
    with pytest.raises(FileFormatError, match=r"bad\.xml"):
        to.load(bad)
    with pytest.raises(FileFormatError, match=r"bad\.xml"):
        to.load(tmp_path / "odd.urdf", srdf=bad)


def test_a_folder_is_not_a_description(tmp_path: Path) -> None:
    odd_arm(tmp_path)
    with pytest.raises(FileFormatError):
        to.Robot.from_urdf(tmp_path)
    with pytest.raises(FileFormatError):
        to.load(tmp_path / "odd.urdf", srdf=tmp_path)


@pytest.mark.parametrize("value", ["nan", "inf", "a", "", "1 nan"])
def test_a_named_state_of_no_number(value: str, tmp_path: Path) -> None:
    odd_arm(tmp_path)
    srdf = tmp_path / "odd.srdf"
    srdf.write_text(
        '<robot name="odd"><group name="g"><joint name="pan"/></group><group_state name="s" group="g">'
        f'<joint name="pan" value="{value}"/></group_state></robot>'
    )
    with pytest.raises(FileFormatError, match=r"odd\.srdf"):
        to.load(tmp_path / "odd.urdf", srdf=srdf)


def with_mesh(folder: Path, filename: str) -> Path:
    """Write the odd arm with a mesh in folder/ws/arm/urdf; meshes are beside that, and outside of ws."""
    for place in ("ws/arm/meshes", "ws/arm/urdf", "outside"):
        (folder / place).mkdir(parents=True, exist_ok=True)
    for place in ("ws/arm/meshes/a.stl", "outside/a.stl"):
        (folder / place).write_text(tetrahedron())
    urdf = folder / "ws" / "arm" / "urdf" / "arm.urdf"
    urdf.write_text(re.sub(re.escape(BOX), f'<mesh filename="{filename}" scale="0.1 0.1 0.1"/>', ODD_ARM))
    return urdf


INSIDE = ("../meshes/a.stl", "package://arm/meshes/a.stl", "package://arm/urdf/../meshes/a.stl",
          "{}/ws/arm/meshes/a.stl",
          "file://{}/ws/arm/meshes/a.stl")  # fmt: skip
OUTSIDE = ("../../../outside/a.stl", "package://arm/../../outside/a.stl", "{}/outside/a.stl",
           "file://{}/outside/a.stl", "package://arm/../../../../../../../../../../etc/passwd",
           "file:///etc/passwd", "package://etc/passwd")  # fmt: skip


@pytest.mark.parametrize("name", INSIDE)
def test_meshes_beside_the_description_are_found(name: str, tmp_path: Path) -> None:
    assert to.load(with_mesh(tmp_path, name.format(tmp_path))).mesh_notes


@pytest.mark.parametrize("name", OUTSIDE)
def test_meshes_outside_the_robots_packages_are_refused(name: str, tmp_path: Path) -> None:
    urdf = with_mesh(tmp_path, name.format(tmp_path))
    with pytest.raises(MeshFileError, match="outside"):
        to.load(urdf)
    if "outside" in name:
        assert to.load(urdf, package_dirs=[tmp_path, tmp_path / "outside"]).mesh_notes


@pytest.mark.parametrize(
    "name", ["a" * 5000, "package://arm/" + "a" * 300 + ".stl", "", "package://", "../.."]
)
def test_names_that_no_mesh_has(name: str, tmp_path: Path) -> None:
    with pytest.raises(MeshFileError):
        to.load(with_mesh(tmp_path, name))


def test_invalid_placements_in_a_scene_are_refused(planar_arm: to.Robot) -> None:
    scene = to.Scene(planar_arm).add("held", to.Sphere(0.01))
    box = to.Box(0.1, 0.1, 0.1)
    mirror, nothing = np.diag((1.0, 1.0, -1.0)), np.full((3, 3), np.nan)
    for bad in (
        *(to.Placement(rotation=rotation) for rotation in (0.01 * np.eye(3), mirror, nothing, np.eye(2))),
        *(to.Placement(translation=translation) for translation in (np.full(3, np.inf), np.zeros(2))),
    ):
        for edit in (
            lambda bad=bad: scene.add("a", box, bad),
            lambda bad=bad: scene.add("a", [(box, bad)]),
            lambda bad=bad: scene.move("held", bad),
            lambda bad=bad: scene.attach("held", "hand", placement=bad),
        ):
            with pytest.raises(ShapeError, match="placement"):
                edit()
