"""What the pages name exists: files, modules, commands of make, versions."""

import importlib
import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
LAID = {"notebooks", "project"}
"""Folders of `docs/` that hold copies after `make docs`, and are not there before."""
PAGES = sorted(
    [
        *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "benchmarks/README.md")),
        *(page for page in ROOT.glob("docs/**/*.md") if page.parent.name not in LAID),
    ]
)
WORKFLOW = ROOT / ".github" / "workflows" / "ci.yml"
HOOKS = ROOT / ".pre-commit-config.yaml"

SPAN = re.compile(r"`([^`\n]+)`")
FILE = re.compile(r"(?:trajopt|tests|benchmarks|robots|problems|examples|notebooks|docs)(?:/[\w.-]+)+/?")
MODULE = re.compile(r"trajopt(?:\.\w+)+")
LINK = re.compile(r"\]\((?!https?:|#)([^)#\s]+)")
ANCHOR = re.compile(r"\]\((?!https?:)([^)#\s]*)#([\w-]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
CODE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
MAKE = re.compile(r"\bmake ([a-z][a-z-]*)")
NOT_PYTHON = {"trajopt.robots", "trajopt.methods", "trajopt.problems"}
"""Entry-point groups; the second is a module, too."""


def ids(path: Path) -> str:
    return str(path.relative_to(ROOT))


def exists(name: str) -> bool:
    """Whether a dotted name can be imported, or is an attribute of what can."""
    parts = name.split(".")
    for split in range(len(parts), 0, -1):
        try:
            value: object = importlib.import_module(".".join(parts[:split]))
        except ImportError:
            continue
        for attribute in parts[split:]:
            if not hasattr(value, attribute):
                return False
            value = getattr(value, attribute)
        return True
    return False


def missing_files(page: Path) -> list[str]:
    """Return the files that a page names and that do not exist."""
    spans = SPAN.findall(page.read_text())
    files = {name.rstrip("/") for span in spans if FILE.fullmatch(name := span.split("::")[0])}
    return [name for name in sorted(files) if not (ROOT / name).exists()]


def missing_names(page: Path) -> list[str]:
    """Return the modules and attributes that a page names and that cannot be imported."""
    text = page.read_text()
    names = {name for span in SPAN.findall(text) for name in MODULE.findall(span)} - NOT_PYTHON
    names |= set(re.findall(r"^\.\. auto\w+:: (\S+)$", text, re.MULTILINE))
    return [name for name in sorted(names) if not exists(name)]


def dead_links(page: Path) -> list[str]:
    """Return the links of a page that lead nowhere, or to a copy that only a build makes."""
    folders = [ROOT / "docs" / name for name in LAID]
    targets = {target: (page.parent / target).resolve() for target in LINK.findall(page.read_text())}
    laid = {target for target, there in targets.items() if any(map(there.is_relative_to, folders))}
    return sorted(laid | {target for target, there in targets.items() if not there.exists()})


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub and MyST name them."""
    titles = HEADING.findall(CODE.sub("", page.read_text()))
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def dead_anchors(page: Path) -> list[str]:
    """Return the links of a page to headings that do not exist."""
    links = (
        (page.parent / name if name else page, anchor) for name, anchor in ANCHOR.findall(page.read_text())
    )
    return [
        f"{there.name}#{anchor}"
        for there, anchor in links
        if there.suffix == ".md" and there.exists() and anchor not in anchors(there)
    ]


def missing_commands(page: Path) -> list[str]:
    """Return the targets of make that a page names and that the Makefile does not have."""
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert len(targets) > 5
    text = page.read_text()
    named = (
        set(re.findall(r"run: make ([a-z-]+)", text))
        if page == WORKFLOW
        else {name for span in SPAN.findall(text) for name in MAKE.findall(span)}
        | set(re.findall(r"^    make ([a-z-]+)", text, re.MULTILINE))
    )
    return sorted(named - targets)


@pytest.mark.parametrize(
    "missing", [missing_files, missing_names, dead_links, dead_anchors, missing_commands]
)
def test_pages_name_existing_files(missing: Callable[[Path], list[str]]) -> None:
    pages = [*PAGES, WORKFLOW] if missing is missing_commands else PAGES
    found = {ids(page): names for page in pages if (names := missing(page))}
    assert found == {}


def test_a_name_that_is_gone_is_seen() -> None:
    assert exists("trajopt.optimise.solvers.Sqp") and exists("trajopt.timing")
    assert not exists("trajopt.optimise.solvers.Newton") and not exists("trajopt.room")


def test_a_link_to_a_missing_heading_is_reported(tmp_path: Path) -> None:
    (tmp_path / "other.md").write_text("# A `name`, and more\n")
    page = tmp_path / "page.md"
    page.write_text("## Here\n[a](#here) [b](#there) [c](other.md#a-name-and-more) [d](other.md#gone)\n")
    assert dead_anchors(page) == ["page.md#there", "other.md#gone"]


def test_the_workflow_runs_every_supported_python() -> None:
    jobs = yaml.safe_load(WORKFLOW.read_text())["jobs"]
    assert {"check", "test", "docs", "wheel"} <= set(jobs)
    with (ROOT / "pyproject.toml").open("rb") as file:
        classifiers = tomllib.load(file)["project"]["classifiers"]
    supported = {item.rsplit(" ", 1)[1] for item in classifiers if re.search(r":: 3\.\d+$", item)}
    assert set(jobs["test"]["strategy"]["matrix"]["python"]) == supported
    assert set(jobs["wheel"]["strategy"]["matrix"]["python"]) == supported


def test_the_hooks_before_a_commit_can_be_run() -> None:
    hooks = [hook for repo in yaml.safe_load(HOOKS.read_text())["repos"] for hook in repo["hooks"]]
    assert {"ruff-check", "ruff-format", "pyright"} <= {hook["id"] for hook in hooks}
    for hook in hooks:
        for word in hook["entry"].split():
            if word.startswith("tests/"):
                assert (ROOT / word).exists(), word


def test_versions_agree() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]


@pytest.mark.parametrize("form", sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml")), ids=ids)
def test_forms_are_complete(form: Path) -> None:
    content = yaml.safe_load(form.read_text())
    if form.name == "config.yml":
        assert content == {"blank_issues_enabled": True}
        return
    assert {"name", "description", "body"} <= set(content)
    names = [part["id"] for part in content["body"] if part["type"] != "markdown"]
    assert names and len(names) == len(set(names))
