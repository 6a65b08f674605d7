"""What packs the wheel knows what is built."""

from pathlib import Path
from runpy import run_path

from trajopt.native import CORES

PACKAGING = Path(__file__).parents[2] / "packaging"


def test_a_wheel_must_hold_every_native_core() -> None:
    assert run_path(str(PACKAGING / "glibc_tag.py"))["stated"]() == set(CORES)
