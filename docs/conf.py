"""How the pages are built: `make docs`."""

from importlib import metadata
from pathlib import Path
from shutil import copy, copytree, rmtree

from sphinx.application import Sphinx

HERE = Path(__file__).parent

project = "trajopt"
author = "the trajopt developers"
copyright = f"2026, {author}"
version = release = metadata.version("trajopt-planner")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["_build"]
default_role = "code"
html_theme = "furo"
html_title = "trajopt"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_timeout = 240
nb_execution_raise_on_error = True
nb_execution_cache_path = str(HERE.parent / "out" / "notebooks")

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_default_options = {"members": True, "imported-members": True, "show-inheritance": False}
autodoc_class_signature = "separated"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

ROOT = HERE.parent
NOTEBOOKS, PROJECT = HERE / "notebooks", HERE / "project"
PAGES = {
    "README.md": "README.md",
    "CONTRIBUTING.md": "CONTRIBUTING.md",
    "benchmarks/README.md": "benchmarks.md",
}
"""Pages that lie elsewhere in the project -> their names among those of `PROJECT`."""
LINKS = {
    "docs/": "../",
    "../docs/": "../",
    "notebooks/": "../notebooks/",
    "benchmarks/README.md": "benchmarks.md",
}
"""Where their links lead -> where what is meant lies when the pages are built."""


def _bring(app: Sphinx) -> None:
    """Lay notebooks, README and benchmarks beside the pages while these are built: they live elsewhere."""
    del app
    for folder in (NOTEBOOKS, PROJECT):
        rmtree(folder, ignore_errors=True)
    copytree(ROOT / "notebooks", NOTEBOOKS)  # with the modules and figures that they use
    for notebook in NOTEBOOKS.glob("*.ipynb"):
        # Among the pages the notebooks lie one folder deeper than beside them.
        notebook.write_bytes(notebook.read_bytes().replace(b"](../docs/", b"](../"))
    PROJECT.mkdir()
    copy(ROOT / "CITATION.cff", PROJECT)
    for page, name in PAGES.items():
        text = (ROOT / page).read_text()
        for here, there in LINKS.items():
            text = text.replace(f"]({here}", f"]({there}")
        (PROJECT / name).write_text(text)


def _link(app: Sphinx, name: str, source: list[str]) -> None:
    """Lead links to notebooks, README and benchmarks to where these were laid."""
    del app
    up = "../" * name.count("/")
    source[0] = source[0].replace(f"](../{up}notebooks/", f"]({up}notebooks/")
    for page, brought in PAGES.items():
        source[0] = source[0].replace(f"](../{up}{page}", f"]({up}project/{brought}")


def setup(app: Sphinx) -> None:
    """Hang in what lies elsewhere before anything is read."""
    app.connect("builder-inited", _bring)
    app.connect("source-read", _link)
