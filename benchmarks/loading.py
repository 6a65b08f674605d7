"""Loading times of the URDFs of example-robot-data, first and from the cache.

Each is loaded twice, in a process of its own: with an empty folder for the cache, then with what that left.

python -m benchmarks.loading [--only TEXT] [--json FILE] [--page FILE]
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import trajopt as to
from benchmarks.page import table, write_section


@dataclass(frozen=True)
class Loading:
    """One loading of one robot.

    Attributes:
        seconds: CPU time of the call, user and system [s].
        process: CPU time of the process, importing everything included [s].
        joints: Movable joints.
        meshes: Links whose collision mesh was covered.
        bodies: Collision bodies.
        farthest: The largest number of mm by which a note says that a cover stands out; 0 without a note.
        notes: Sentences on what was left out or taken differently.
        refused: Why it was not loaded; empty if it was.
    """

    seconds: float
    process: float
    joints: int = 0
    meshes: int = 0
    bodies: int = 0
    farthest: int = 0
    notes: tuple[str, ...] = ()
    refused: str = ""


def folder() -> Path:
    """Return the folder of the robots that example-robot-data brings."""
    import cmeel

    return Path(cmeel.__file__).parents[1] / "cmeel.prefix/share/example-robot-data/robots"


def load(urdf: Path) -> Loading:
    """Load a robot in this process."""
    begin = time.process_time()
    try:
        robot = to.load(urdf)
    except to.TrajoptError as error:
        return Loading(time.process_time() - begin, _spent(), refused=str(error).replace(f"{folder()}/", ""))
    seconds = time.process_time() - begin
    covers = [note.partition(": ") for note in robot.mesh_notes]
    words = [said.partition("up to ")[2].partition(" mm")[0] for _, _, said in covers]
    return Loading(
        seconds,
        _spent(),
        len(robot.joint_names),
        sum(len(links.split(", ")) for links, _, _ in covers),
        len(robot.bodies),
        max((int(word) for word in words if word), default=0),
        robot.notes,
    )


def load_apart(urdf: Path, cache: Path) -> Loading:
    """Load a robot in a process of its own, with a folder for the cache."""
    environment = {**os.environ, "TRAJOPT_CACHE_DIR": str(cache), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "benchmarks.loading", "--one", str(urdf)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return Loading(**json.loads(done.stdout.splitlines()[-1]))


def main() -> None:
    """Load every robot and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--one", type=Path, help="load this file here and print what came of it as JSON")
    parser.add_argument("--only", default="", help="robots whose path has this in it")
    parser.add_argument("--json", type=Path, default=Path("benchmarks/results/loading.json"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    if given.one is not None:
        print(json.dumps(asdict(load(given.one))))
        return
    found: dict[str, tuple[Loading, Loading]] = {}
    for urdf in sorted(folder().rglob("*.urdf")):
        name = str(urdf.relative_to(folder()))
        if given.only not in name:
            continue
        with tempfile.TemporaryDirectory() as cache:
            first, again = (load_apart(urdf, Path(cache)) for _ in range(2))
        found[name] = first, again
        print(f"{name}: {first.seconds:.2f} s, then {again.seconds:.2f} s {first.refused}", flush=True)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    plain = {name: {"first": asdict(first), "again": asdict(again)} for name, (first, again) in found.items()}
    given.json.write_text(json.dumps(plain, indent=1) + "\n")
    if given.page is not None:
        write_section(given.page, "loading", section(found))


def section(found: dict[str, tuple[Loading, Loading]]) -> str:
    """Return a summary, and a table of the robots with a note, a loose cover or a refusal."""
    rows = [
        [
            _short(name),
            f"{first.seconds:.1f}",
            f"{again.seconds:.2f}",
            f"{again.process:.2f}",
            str(first.joints),
            str(first.meshes),
            str(first.bodies),
            f"{first.farthest} mm" if first.farthest else "",
            first.refused or str(len(first.notes) or ""),
        ]
        for name, (first, again) in found.items()
        if first.refused or first.notes or first.farthest
    ]
    head = ["robot", "first s", "from the cache s", "with imports s", "joints", "meshes", "bodies"]
    head += ["cover stands out", "notes, or why not"]
    loaded = [(first, again) for first, again in found.values() if not first.refused]
    slowest = max(first.seconds for first, _ in found.values())
    cached = max(again.seconds for _, again in found.values())
    process = max(again.process for _, again in found.values())
    said = (
        f"{len(loaded)} of {len(found)} load: the first time in {slowest:.1f} s of CPU at most, "
        f"from the cache in {cached:.2f} s ({process:.2f} s with all imports). "
        f"The table has the robots with notes, loose covers or errors, `results/loading.json` all."
    )
    return f"{said}\n\n{table(head, rows)}"


def _short(name: str) -> str:
    """Return a robot's path without the folders that say nothing."""
    first, *_, last = Path(name).parts
    return f"{first.removesuffix('_description')}/{last.removesuffix('.urdf')}"


def _spent() -> float:
    """Return the CPU time of this process so far [s]."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
