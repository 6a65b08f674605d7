"""Files with flipped bits, zeroed sectors and cut ends: refused, read unchanged, or read as other content.

python -m benchmarks.damaged_files [--each 300] [--seed 0] [--page FILE]

A bundle, a warehouse with a robot, scene, problem and plan, and the Parquet file of a campaign are damaged at
random places, one damage at a time, and read again. Content is compared by its fingerprint.
"""

import argparse
import json
import tempfile
import traceback
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

import trajopt as to
from benchmarks.page import table, write_section
from trajopt.files.bundle import Bundle, read_bundle
from trajopt.files.bundle.codec import fingerprint
from trajopt.lab.campaign.columns import encoded, read_rows
from trajopt.server.warehouse import Warehouse
from trajopt.values.errors import TrajoptError

SECTOR = 512
Reader = Callable[[Path], object]
REFUSED, UNCHANGED, OTHER, FAULT = "refused", "read unchanged", "read as other content", "untyped error"


def bit(data: bytearray, drawn: np.random.Generator) -> None:
    """Flip one bit."""
    data[drawn.integers(len(data))] ^= 1 << int(drawn.integers(8))


def sector(data: bytearray, drawn: np.random.Generator) -> None:
    """Overwrite one sector with zeros."""
    begin = SECTOR * int(drawn.integers(len(data) // SECTOR))
    data[begin : begin + SECTOR] = bytes(SECTOR)


def cut(data: bytearray, drawn: np.random.Generator) -> None:
    """Remove the end."""
    del data[drawn.integers(len(data)) :]


DAMAGES = {"a flipped bit": bit, "a zeroed sector": sector, "a cut end": cut}


def content(value: object) -> object:
    """Return the contents of a value for comparison."""
    if isinstance(value, Bundle):
        document = json.dumps([value.answer, value.explanation], sort_keys=True, default=str)
        motion = b"" if value.trajectory is None else value.trajectory.positions.tobytes()
        return fingerprint(value.problem), motion, document
    return fingerprint(value)


def bundle_content(path: Path) -> object:
    """Return the content of a bundle."""
    return content(read_bundle(path))


def warehouse_content(path: Path) -> object:
    """Return every entry's description and its content."""
    with Warehouse(path, create=False) as kept:
        return [(entry.as_dict(), content(kept.load(entry))) for entry in kept.find()]


def rows_content(path: Path) -> object:
    """Return the rows of a campaign."""
    return [sorted(row.items()) for row in read_rows(path)]


def write_files(folder: Path) -> Mapping[str, tuple[Path, Reader]]:
    """Write one file of each kind."""
    scene = to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    problem = to.Problem(
        scene=scene, start=[0.0, 0.4], goal={"joint1": 1.4, "joint2": 0.4}, name="past a ball"
    )
    plan = to.plan(problem).require()
    plan.save(folder / "kept.trajopt")
    with Warehouse(folder / "kept.warehouse") as kept:
        for name, value in {"arm": scene.robot, "cell": scene, "problem": problem, "plan": plan}.items():
            kept.add(name, value, note=f"the {name}", tags=("one", "two"))
    drawn = np.random.default_rng(0)
    rows = [{"id": f"{i:04x}", "times": drawn.random(20), "positions": drawn.random(140)} for i in range(40)]
    (folder / "rows.parquet").write_bytes(encoded(rows))
    return {
        "bundle": (folder / "kept.trajopt", bundle_content),
        "warehouse": (folder / "kept.warehouse", warehouse_content),
        "rows of a campaign": (folder / "rows.parquet", rows_content),
    }


def outcome(path: Path, read: Reader, sound: object) -> str:
    """Return the outcome of reading a damaged file."""
    try:
        return UNCHANGED if read(path) == sound else OTHER
    except TrajoptError:
        return REFUSED
    except Exception:
        traceback.print_exc()
        return FAULT


def main() -> None:
    """Measure, print, and write a section of a page."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--each", type=int, default=300)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--page", type=Path)
    given = options.parse_args()
    drawn, rows = np.random.default_rng(given.seed), list[tuple[str, ...]]()
    with tempfile.TemporaryDirectory() as place:
        for kind, (path, read) in write_files(Path(place)).items():
            data, sound = path.read_bytes(), read(path)
            for damage, change in DAMAGES.items():
                found = Counter[str]()
                for _ in range(given.each):
                    damaged = bytearray(data)
                    change(damaged, drawn)
                    copy = path.with_name(f"damaged{path.suffix}")
                    copy.write_bytes(damaged)
                    found[outcome(copy, read, sound)] += 1
                    copy.unlink()
                counts = (str(found[name]) for name in (REFUSED, UNCHANGED, OTHER, FAULT))
                rows.append((kind, f"{len(data):,}", damage, *counts))
    text = table(("file", "bytes", "damage", REFUSED, UNCHANGED, OTHER, FAULT), rows)
    print(text)
    if given.page is not None:
        write_section(given.page, "damaged-files", text)


if __name__ == "__main__":
    main()
