"""Expanding a xacro file of a stranger computes, reads the file's packages, and does nothing else."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("xacrodoc")

from trajopt.robot.loading import xacro_child
from trajopt.robot.loading.xacro_child import readable
from trajopt.robot.loading.xml_file import expanded
from trajopt.values.errors import FileFormatError

HEAD = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
CLASSES = "[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == 'catch_warnings']"
BUILTINS = f"{CLASSES}[0]()._module.__builtins__"
FRAMES = ".".join(("g[0].gi_frame", *["f_back"] * 4))
OUTER = f"(lambda g: (g.append(({FRAMES} for x in [1])), [f for f in g[0]][0])[1])([])"
IMPORT = f"{OUTER}.f_builtins['_' + '_import_' + '_']"
CLASS_OF_TYPES = "python.vars(python.type)['_' + '_subclasses_' + '_'](python.type(().count).mro()[-1])"


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
        "(lambda f: f.gi_frame)(x for x in ())",
        f"{IMPORT}('os').mknod('MARK')",
        CLASS_OF_TYPES,
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


@pytest.mark.parametrize(
    "call", ["os.mknod(sys.argv[1])", "os.getppid()", "import signal", "open('/etc/hosts')"]
)
def test_the_process_can_do_nothing_else(call: str, tmp_path: Path) -> None:
    begin = (
        f"import os, runpy, sys; guard = runpy.run_path({xacro_child.__file__!r})['guard']; guard((), ()); "
    )
    mark = tmp_path / "mark"
    done = subprocess.run(
        [sys.executable, "-c", begin + call, str(mark)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "Error: " in done.stderr
    assert not mark.exists()


def test_names_that_lead_nowhere_are_variables(tmp_path: Path) -> None:
    body = '<xacro:property name="_gi_size" value="2"/><xacro:property name="tb_type" value="3"/>'
    assert '"l5"' in described(tmp_path, f'{body}<link name="l${{_gi_size + tb_type}}"/>')


def test_a_pattern_includes_files(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    for name in "ab":
        (tmp_path / "parts" / f"{name}.xacro").write_text(f'<robot><link name="{name}"/></robot>')
    expanded_text = described(tmp_path, '<xacro:include filename="parts/*.xacro"/>')
    assert '"a"' in expanded_text
    assert '"b"' in expanded_text


def test_links_to_the_sources_of_a_workspace_are_followed(tmp_path: Path) -> None:
    source, installed = tmp_path / "src" / "arm", tmp_path / "install" / "share" / "arm"
    files = {
        "package.xml": "<package><name>arm</name></package>",
        "urdf/arm.urdf.xacro": f'{HEAD}<xacro:include filename="$(find arm)/parts/a.xacro"/></robot>',
        "parts/a.xacro": '<robot><link name="a"/></robot>',
    }
    for name, text in files.items():
        for folder in (source, installed):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(text)
        (installed / name).symlink_to(source / name)
    assert '"a"' in expanded(installed / "urdf" / "arm.urdf.xacro", {}, ()).decode()


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
