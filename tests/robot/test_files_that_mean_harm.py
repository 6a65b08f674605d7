"""Descriptions and meshes that crash what reads them, or take for ever: refused with a reason in seconds."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.robot.loading.urdf import MOST_LINKS
from trajopt.values.cached import cache_folder
from trajopt.values.errors import FileFormatError, MeshFileError

SELF_REFERENCE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/></asset>
<library_nodes><node id="n"><instance_node url="#n"/></node></library_nodes>
<library_visual_scenes><visual_scene id="s"><node id="r"><instance_node url="#n"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
HINGE = '<body name="arm"><joint type="hinge"/><geom size=".1"/></body>'
HUGE_FIELD = f"""<mujoco><asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>
<worldbody><geom type="hfield" hfield="h"/>{HINGE}</worldbody></mujoco>"""
HUGE_USER = f'<mujoco><size nuser_body="2000000000"/><worldbody>{HINGE}</worldbody></mujoco>'


def arm(link: str, more: str = "") -> str:
    """A robot of one joint, whose link holds something."""
    return (
        f'<robot name="arm"><link name="base"/><link name="arm">{link}</link>'
        '<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
        f'<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>{more}</robot>'
    )


def test_a_mesh_that_crashes_its_reader_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "self.dae").write_text(SELF_REFERENCE)
    with pytest.raises(MeshFileError, match=r"self\.dae.*SIGSEGV"):
        to.load_mesh(tmp_path / "self.dae")
    (tmp_path / "arm.urdf").write_text(
        arm('<collision><geometry><mesh filename="self.dae"/></geometry></collision>')
    )
    with pytest.raises(MeshFileError, match="SIGSEGV"):
        to.load(tmp_path / "arm.urdf")


def test_a_mesh_with_impossible_coordinates_is_an_error(tmp_path: Path) -> None:
    triangle = np.zeros(1, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    triangle["corners"] = [[0, 0, 0], [1e38, 0, 0], [0, 1e38, 0]]
    (tmp_path / "huge.stl").write_bytes(b" " * 80 + np.uint32(1).tobytes() + triangle.tobytes())
    with pytest.raises(MeshFileError, match=r"1e\+38 m"):
        to.load_mesh(tmp_path / "huge.stl")


def never(*_: object) -> bytes:
    pytest.fail("read again")


def test_a_mesh_is_read_once_and_again_when_it_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TRAJOPT_CACHE_DIR", str(tmp_path / "cache"))
    file = tmp_path / "a.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert np.ptp(to.load_mesh(file).vertices, axis=0).tolist() == [1.0, 1.0, 0.0]
    kept = list(cache_folder().iterdir())
    assert len(kept) == 1
    with monkeypatch.context() as patch:
        patch.setattr("trajopt.values.shapes.mesh.answer_of", never)
        assert np.ptp(to.load_mesh(file).vertices, axis=0).tolist() == [1.0, 1.0, 0.0]
    file.write_text("v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n")
    assert np.ptp(to.load_mesh(file).vertices, axis=0).tolist() == [2.0, 1.0, 0.0]


@pytest.mark.parametrize("text", [HUGE_FIELD, HUGE_USER], ids=["hfield", "nuser_body"])
def test_a_model_that_takes_all_memory_is_an_error(text: str, tmp_path: Path) -> None:
    (tmp_path / "huge.xml").write_text(text)
    with pytest.raises(FileFormatError, match="more than 4 GB"):
        to.load(tmp_path / "huge.xml")


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (b'<body name="a\xe9">%b</body>', "a name that is not UTF-8"),
        (b'<body name="&#xd800;">%b</body>', "a name that is not UTF-8"),
        (b'<body name="far" pos="nan 0 0">%b</body>', r"body 'far' has a number that is not finite"),
        (
            b'<body><joint name="j" type="hinge" limited="true" range="nan 1"/><geom size=".1"/>%b</body>',
            r"joint 'j' has a number that is not finite \(jnt_range\)",
        ),
    ],
)
def test_names_and_numbers_of_a_model_are_checked(body: bytes, reason: str, tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_bytes(b"<mujoco><worldbody>%b</worldbody></mujoco>" % (body % HINGE.encode()))
    with pytest.raises(FileFormatError, match=reason):
        to.load(tmp_path / "a.xml")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.off", "OFF\n2000000000 2000000000 0\n0 0 0\n"),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 2000000000\nproperty float x\nend_header\n0\n"),
    ],
)
def test_a_mesh_that_states_impossible_counts_is_an_error(name: str, text: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(MeshFileError, match="more than 4 GB of memory"):
        to.load_mesh(tmp_path / name)


def test_more_links_than_a_robot_may_have_are_an_error(tmp_path: Path) -> None:
    links = [
        f'<link name="l{k}"/><joint name="f{k}" type="fixed"><parent link="arm"/><child link="l{k}"/></joint>'
        for k in range(MOST_LINKS)
    ]
    (tmp_path / "some.urdf").write_text(arm("", "".join(links[:-2])))
    assert to.load(tmp_path / "some.urdf").name == "arm"
    (tmp_path / "many.urdf").write_text(arm("", "".join(links)))
    with pytest.raises(FileFormatError, match=rf"1002 links, more than the {MOST_LINKS}.*Scene\.add"):
        to.load(tmp_path / "many.urdf")


@pytest.mark.parametrize(
    "thing", ['<body pos="{} 0 0"><geom size=".01"/></body>', '<geom size=".1" pos="{} 0 0"/>']
)
def test_more_bodies_than_a_robot_may_have_are_an_error(thing: str, tmp_path: Path) -> None:
    many = "".join(thing.format(k) for k in range(MOST_LINKS + 1))
    (tmp_path / "many.xml").write_text(f"<mujoco><worldbody>{HINGE}{many}</worldbody></mujoco>")
    with pytest.raises(FileFormatError, match=f"more than the {MOST_LINKS}"):
        to.load(tmp_path / "many.xml")
