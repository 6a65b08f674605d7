"""How the pages are built: `make docs`."""

from importlib import metadata
from pathlib import Path

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

NOTEBOOKS = HERE / "notebooks"


def _bring_notebooks(app: Sphinx) -> None:
    """Lay the notebooks beside the pages while these are built: they live in a folder of their own."""
    del app
    NOTEBOOKS.mkdir(exist_ok=True)
    for old in NOTEBOOKS.glob("*.ipynb"):
        old.unlink()
    for notebook in sorted((HERE.parent / "notebooks").glob("*.ipynb")):
        # Among the pages the notebooks lie one folder deeper than beside them.
        (NOTEBOOKS / notebook.name).write_bytes(notebook.read_bytes().replace(b"](../docs/", b"](../"))


def setup(app: Sphinx) -> None:
    """Hang the notebooks in before anything is read."""
    app.connect("builder-inited", _bring_notebooks)
