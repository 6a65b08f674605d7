"""A test that hangs ends, also in compiled code that keeps the interpreter's lock."""

import subprocess
import sys
from pathlib import Path

HANGS = """
import ctypes, time

def test_in_python():
    time.sleep(100.0)

def test_in_compiled_code():
    native, lock = ctypes.PyDLL(None), ctypes.create_string_buffer(128)
    for _ in range(2):  # the second waits for the first, through all signals
        native.pthread_mutex_lock(lock)
"""


def test_a_hanging_test_is_ended_and_named(tmp_path: Path) -> None:
    (tmp_path / "test_hangs.py").write_text(HANGS)
    options = ["-p", "tests.watchdog", "-p", "no:cacheprovider", "-n", "0", "-v", "--rootdir", str(tmp_path)]
    options += ["-o", "timeout=1", "-o", "timeout_method=signal", "-o", "watchdog_grace=2"]
    command = [sys.executable, "-m", "pytest", *options, str(tmp_path / "test_hangs.py")]
    root = Path(__file__).parents[2]
    ended = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=90, check=False)
    assert ended.returncode == 1
    assert "test_in_python FAILED" in ended.stdout, "and the next is run"
    assert "test_in_compiled_code" in ended.stderr, "where it was, though its output is captured"
    assert "passed" not in ended.stdout and "failed" not in ended.stdout, "the process was ended"
