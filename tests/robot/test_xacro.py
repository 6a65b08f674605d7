"""Expanding a xacro file of a stranger computes, reads the file's packages, and does nothing else."""

import json
from pathlib import Path

import pytest

pytest.importorskip("xacrodoc")

from trajopt.robot.loading.xacro_child import readable
from trajopt.robot.loading.xacro_file import expanded
from trajopt.values.errors import FileFormatError

HEAD = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
CLASSES = "[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == 'catch_warnings']"
BUILTINS = f"{CLASSES}[0]()._module.__builtins__"


def described(folder: Path, body: str, **arguments: str) -> str:
    folder.mkdir(exist_ok=True)
    file = folder / "arm.urdf.xacro"
    file.write_text(f"{HEAD}{body}</robot>")
    return expanded(file, arguments, ()).decode()


def test_expressions_compute(tmp_path: Path) -> None:
    body = '<xacro:arg name="n" default="2"/><link name="l${len([i for i in range(6)]) + $(arg n)}"/>'
    assert '"l9"' in described(tmp_path, body, n="3")
    assert "0.5" in described(tmp_path, '<mass value="${(lambda x: x / 2)(1.0)}"/>')


@pytest.mark.parametrize(
    "expression",
    [
        "(lambda: ().__class__)()",
        f"(lambda: {BUILTINS}['__import__']('os').system('touch MARK'))()",
        "[x.__class__ for x in (1,)]",
        "(lambda f: f.gi_frame)(x for x in ())._x",
        "open('/etc/passwd').read()",
        "__import__('os')",
    ],
)
def test_expressions_reach_nothing_else(expression: str, tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    body = f'<link name="${{{expression.replace("MARK", str(mark))}}}"/>'.replace("<l", "<l").replace(
        "'", "&apos;"
    )
    with pytest.raises(FileFormatError, match="cannot be expanded"):
        described(tmp_path / "own", body)
    assert not mark.exists()


def test_units_of_yaml_reach_nothing_else(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    own = tmp_path / "own"
    own.mkdir()
    body = "<xacro:property name='a' value=\"${xacro.load_yaml('angles.yaml')}\"/><link name=\"l${a['x']}\"/>"
    (own / "angles.yaml").write_text("x: !degrees 180")
    assert "l3.14" in described(own, body)
    command = json.dumps(f"(lambda: {BUILTINS}['__import__']('os').system('touch {mark}'))()")
    (own / "angles.yaml").write_text(f"x: !degrees {command}")
    with pytest.raises(FileFormatError, match="cannot be expanded"):
        described(own, body)
    assert not mark.exists()


@pytest.mark.parametrize("where", ["/etc/hostname", "../secret.yaml", "link.yaml"])
def test_files_outside_of_the_packages_are_not_read(where: str, tmp_path: Path) -> None:
    own = tmp_path / "own"
    own.mkdir()
    (tmp_path / "secret.yaml").write_text("password")
    (own / "link.yaml").symlink_to(tmp_path / "secret.yaml")
    body = f"<link name=\"l${{xacro.load_yaml('{where}')}}\"/>"
    with pytest.raises(FileFormatError, match="may not open") as refused:
        described(own, body)
    assert "password" not in str(refused.value)
    with pytest.raises(FileFormatError, match="cannot be expanded"):
        described(own, f'<xacro:include filename="{where}"/>')


def test_memory_is_bounded(tmp_path: Path) -> None:
    with pytest.raises(FileFormatError, match="too much memory"):
        described(tmp_path, '<link name="${len([0] * 10**10)}"/>')


def test_a_package_is_readable_only_where_it_has_a_manifest(tmp_path: Path) -> None:
    package = tmp_path / "beside" / "macros"
    package.mkdir(parents=True)
    file = package / "limb.xacro"
    file.touch()
    assert not readable(file, (), (str(tmp_path / "beside"),))
    (package / "package.xml").touch()
    assert readable(file, (), (str(tmp_path / "beside"),))
    assert not readable(file, (), (str(tmp_path / "other"),))
    assert not readable(3, (str(tmp_path),), ())
