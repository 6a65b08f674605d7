"""Without its native cores trajopt does not import, and says how to get them."""

import subprocess
import sys

import pytest

from trajopt.native import CORES, native_cores

BLOCKED = """
import sys
from importlib.machinery import ModuleSpec

class Uncompiled:
    def find_spec(self, name, path=None, target=None):
        if name == "trajopt.native.{core}":
            return ModuleSpec(name, None)  # what the folder of its sources alone is

sys.meta_path.insert(0, Uncompiled())
try:
    import trajopt
except ImportError as error:
    print(type(error).__name__, error.cores, error)
"""


def test_all_are_there() -> None:
    assert native_cores() == CORES


@pytest.mark.parametrize("core", CORES)
def test_the_first_import_names_the_missing_core(core: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", BLOCKED.format(core=core)], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith(f"NativeCoresMissing ('{core}',)"), done.stderr
    assert "pip install" in done.stdout and "C++17 compiler" in done.stdout
