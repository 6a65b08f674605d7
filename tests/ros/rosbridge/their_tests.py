"""compas_fab's own integration tests and example scripts, unmodified, against `trajopt serve`.

    python -m tests.ros.rosbridge.their_tests FOLDER

FOLDER has compas_fab's `tests/backends/ros`, its `docs/backends/ros/files`, and `robot/` with ur5.urdf,
ur5.srdf and the package ur_description. The tests ask for the ports 9091 and 9190; the scripts for 9090 and
9190, and for the robot that compas_fab itself brings.
"""

import os
import subprocess
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

TALKER, LISTENER = "10_ros_hello_world_talker.py", "10_ros_hello_world_listener.py"
"""Scripts that go on for ever."""
WITHOUT_BYTECODE = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
"""Nothing is written into the folder."""


@contextmanager
def served(urdf: Path, srdf: Path, packages: Path, port: int) -> Generator[None]:
    """Let the server run."""
    options = ("--port", "0", "--rosbridge-port", str(port), "--mesh-port", "9190")
    files = ("--robot", str(urdf), "--srdf", str(srdf), "--package-dir", str(packages))
    words = (sys.executable, "-m", "trajopt", "serve", *files, *options)
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        try:
            assert server.stdout is not None
            if not any("rosbridge" in line for line in server.stdout):
                raise SystemExit(f"{' '.join(words)}: does not come up")
            yield
        finally:
            server.terminate()


def tests_pass(folder: Path) -> bool:
    """Run the tests."""
    words = (sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "tests/backends/ros")
    asked = {**WITHOUT_BYTECODE, "COMPAS_FAB_RUN_ROS_INTEGRATION_TESTS": "1"}
    return subprocess.run(words, cwd=folder, env=asked, check=False).returncode == 0


def script_runs(path: Path) -> bool:
    """Run a script to its end, Enter being pressed whenever it asks."""
    done = subprocess.run(
        (sys.executable, path),
        input=20 * "\n",
        text=True,
        env=WITHOUT_BYTECODE,
        capture_output=True,
        check=False,
    )
    print("passed" if done.returncode == 0 else "FAILED", path.name, flush=True)
    if done.returncode:
        print(done.stdout, done.stderr)
    return done.returncode == 0


def hello_is_heard(folder: Path) -> bool:
    """Run the two scripts that talk to each other, until one hears the other."""
    words = (sys.executable, "-u")
    with (
        subprocess.Popen((*words, folder / LISTENER), stdout=subprocess.PIPE, text=True) as listener,
        subprocess.Popen((*words, folder / TALKER), stdout=subprocess.DEVNULL) as talker,
    ):
        assert listener.stdout is not None
        heard = "Hello World!" in listener.stdout.readline()
        for each in (listener, talker):
            each.kill()
    print("passed" if heard else "FAILED", TALKER, LISTENER, flush=True)
    return heard


def main() -> None:
    """Run all; the exit status says whether all passed."""
    import compas_fab  # pyright: ignore[reportMissingTypeStubs]

    folder = Path(sys.argv[1]).resolve()
    robot, scripts = folder / "robot", folder / "docs" / "backends" / "ros" / "files"
    with served(robot / "ur5.urdf", robot / "ur5.srdf", robot, 9091):
        passed = [tests_pass(folder)]
    library = Path(str(compas_fab.__file__)).parent / "data" / "robot_library" / "ur5_robot"
    urdf, srdf = library / "urdf" / "robot_description.urdf", library / "robot_description_semantic.srdf"
    with served(urdf, srdf, library, 9090):
        names = [path for path in sorted(scripts.glob("*.py")) if path.name not in (TALKER, LISTENER)]
        passed += [script_runs(path) for path in names]
        passed.append(hello_is_heard(scripts))
    print(f"{sum(passed)} of {len(passed)}")
    sys.exit(not all(passed))


if __name__ == "__main__":
    main()
