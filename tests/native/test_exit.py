"""A script that plans ends in silence: nothing of the native cores outlives the interpreter."""

import subprocess
import sys

import pytest

import trajopt as to

SCRIPT = """
import trajopt as to
assert to.plan(to.named_problem("cup_past_pillar")).verified
"""


def test_a_script_that_plans_ends_in_silence() -> None:
    try:
        to.named_problem("cup_past_pillar")
    except to.MissingExtra as missing:
        pytest.skip(str(missing))
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")
