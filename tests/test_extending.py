"""The code of docs/extending.md does what the page says."""

import re
from pathlib import Path

import pytest

from trajopt.optimise.methods import method_named, method_names

PAGE = Path(__file__).parents[1] / "docs" / "extending.md"


def blocks(kind: str) -> list[str]:
    """Blocks of the page but for those that are a file of a package."""
    return [text for text in all_blocks(kind) if not re.match(r"# \w+/\w+\.py\n", text)]


def all_blocks(kind: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", PAGE.read_text(), flags=re.DOTALL | re.MULTILINE)


def files() -> dict[str, str]:
    """Files of the package that adds a requirement, by their names."""
    found = (re.match(r"# (\w+/\w+\.py)\n", text) for text in all_blocks("python"))
    return {match[1]: match.string for match in found if match is not None}


def test_the_pages_code_runs() -> None:
    code = blocks("python")
    assert len(code) == 4
    spoken: dict[str, object] = {"__name__": "extending"}
    for number, block in enumerate(code):
        exec(compile(block, f"{PAGE.name}, block {number + 1}", "exec"), spoken)


def test_the_documented_entry_point_adds_a_method(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (table,) = (text for text in blocks("toml") if "trajopt.methods" in text)
    group = re.search(r'entry-points."([^"]+)"', table)
    name, target = re.findall(r'^(\w+) = "(.*)"', table, flags=re.MULTILINE)[0]
    module = target.split(":")[0]
    assert group is not None
    (tmp_path / "my_package-1.0.dist-info").mkdir()
    (tmp_path / "my_package-1.0.dist-info" / "METADATA").write_text("Name: my_package\nVersion: 1.0\n")
    (tmp_path / "my_package-1.0.dist-info" / "entry_points.txt").write_text(
        f"[{group[1]}]\n{name} = {target}\n"
    )
    file = tmp_path / Path(*module.split(".")).with_suffix(".py")
    file.parent.mkdir()
    (file.parent / "__init__.py").touch()
    solver = "\n".join(blocks("python")[:2])
    file.write_text(
        f"{solver}\nfrom trajopt.optimise.methods import Knots\n\n\n"
        "def method():\n    return Knots(Descent())\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    assert name in method_names()
    assert method_named(name).name == name
