"""Cost of planning as a problem grows: knots, boxes, triangles of a mesh, attached objects, joints.

python -m benchmarks.scaling [--json FILE] [--page FILE]
"""

import argparse
import json
import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import trajopt as to
from benchmarks.measuring import COUNTS, STAGES, Measurement, exponent, measure
from benchmarks.page import table, write_section
from benchmarks.problems import arms, carrying, close_by, over_waves, past_pillar

SIZES = {
    "knots": [10, 20, 50, 100, 200],
    "boxes": [10, 30, 100, 300, 1000],
    "nearby boxes": [10, 30, 100, 300, 1000],
    "attached objects": [1, 3, 10, 30, 100],
    "mesh faces": [200, 1_000, 10_000, 100_000, 1_000_000],
    "joints": [2, 4, 7, 10, 14],
}


def families(folder: Path) -> dict[str, Callable[[int], to.Problem]]:
    """Return a factory of problems by size, for each direction of growth."""
    panda = to.load("panda")
    return {
        "knots": lambda size: past_pillar(panda, knots=size),
        "boxes": lambda size: past_pillar(panda, boxes=size),
        "nearby boxes": lambda size: close_by(panda, size),
        "attached objects": lambda size: carrying(panda, size),
        "mesh faces": lambda size: over_waves(panda, size),
        "joints": lambda size: arms(folder, size),
    }


def main() -> None:
    """Measure every family and write the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", type=Path, default=Path("benchmarks/results/scaling.json"))
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    found: dict[str, dict[int, Measurement]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, make in families(Path(folder)).items():
            found[name] = {size: measure(make(size)) for size in SIZES[name]}
            print(section({name: found[name]}), flush=True)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    plain = {name: {size: asdict(m) for size, m in sizes.items()} for name, sizes in found.items()}
    given.json.write_text(json.dumps(plain, indent=1) + "\n")
    if given.page is not None:
        write_section(given.page, "scaling", section(found))


def section(found: dict[str, dict[int, Measurement]]) -> str:
    """Return tables in Markdown, one for each direction of growth."""
    stages, parts = (*STAGES, "plan"), []
    for name, sizes in found.items():
        rows = [
            [f"{size:,}", *(f"{m.milliseconds[stage]:.1f}" for stage in stages),
             *(f"{m.counts[count]:,}" for count in COUNTS), m.status]
            for size, m in sizes.items()
        ]  # fmt: skip
        fits = [exponent(list(sizes), [m.milliseconds[stage] for m in sizes.values()]) for stage in stages]
        rows.append(["exponent", *(f"{fit:.2f}" for fit in fits), *[""] * (len(COUNTS) + 1)])
        head = [name, *(f"{stage} ms" for stage in stages), *(c.replace("_", " ") for c in COUNTS), "outcome"]
        parts.append(table(head, rows))
    return "\n\n".join(parts)


if __name__ == "__main__":
    main()
