"""Plan the requested problems, one a line, with the trajopt of this interpreter.

python planning_worker.py DATA, with "robot/set/number" on standard input; answers in JSON on standard output.
It is a script and imports only what every version has, so that versions can be compared.
"""

import json
import sys
import time
from functools import cache
from pathlib import Path

import trajopt as to

try:
    from trajopt.files.moveit import read_request, read_scene
except ImportError:  # versions before 0.2
    from trajopt.moveit import read_request, read_scene  # pyright: ignore

DATA = Path(sys.argv[1])


@cache
def robot(name: str) -> to.Robot:
    """Return the robot of a folder."""
    if name == "panda":
        return to.load("panda")
    folder = DATA / name / "robot"
    return to.Robot.from_urdf(folder / f"{name}.urdf", srdf=folder / f"{name}.srdf")


def answer(key: str) -> dict[str, object]:
    """Plan a problem; the CPU time is that of `plan()` alone."""
    name, family, number = key.split("/")
    files = [DATA / name / family / f"{kind}{int(number):04d}.yaml" for kind in ("scene", "request")]
    problem = read_request(files[1], read_scene(files[0], robot(name))).problem()
    begin = time.process_time()
    result = to.plan(problem)
    used = time.process_time() - begin
    return {
        "key": key,
        "status": result.status.name,
        "ms": 1e3 * used,
        "stages": {stage: 1e3 * seconds for stage, seconds in result.cpu_seconds.items()},
        "counts": dict(result.counts),
        "duration": result.trajectory.duration if result.verified and result.trajectory is not None else None,
    }


def main() -> None:
    """Answer each line until the input ends."""
    for line in sys.stdin:
        print(json.dumps(answer(line.strip())), flush=True)


if __name__ == "__main__":
    main()
