"""Proof files: how many verified motions are proven by the checker alone, their sizes, and its time.

python -m benchmarks.proofs [DATA] [--robots panda,ur5] [--limit K] [--clouds K] [--out FOLDER] [--page FILE]

Each problem of the suite, and of MotionBenchMaker if DATA is given, is planned; the proof of each verified
motion is written and checked by `python -I trajopt/verify/checker`. CPU of the checker is that of its whole
process, from the start of Python on. The fast kernel checks it too, in this process: least CPU of five calls,
without and with reading the file. Rows are kept in --out; a problem that has one is not planned again.
"""

import argparse
import resource
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from importlib.metadata import entry_points
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

import trajopt as to
from benchmarks.clouds.sampling import clouds_of, with_cloud
from benchmarks.motion_bench_maker import ROBOTS, problems
from benchmarks.page import table, write_section
from benchmarks.rows import Rows
from benchmarks.sections import TITLES
from trajopt.files.proof import MotionProof, ProofSize, check_proof, save_proof
from trajopt.native.checker import StatedProof
from trajopt.problem.problem import named_problem
from trajopt.values.errors import ProblemError

HEAD = (
    "motions of", "verified", "proven", "torque too", "nothing only judged", "leaves", "witness kB",
    "statement kB", "write ms", "check s", "proven fast", "fast check ms", "with reading ms",
)  # fmt: skip


@dataclass(frozen=True)
class Checked:
    """A verified motion and its proof.

    Attributes:
        family: The set of its problem.
        name: The problem.
        fault: The reason if it is not proven; empty if it is.
        sampled: Whether torque is sampled, and not part of the proof.
        whole: Whether nothing is only judged.
        size: The size of the proof, if there is one.
        write: CPU time of writing, the judge's verdict included [s].
        check: CPU time of the checker's process [s].
        proven_fast: Whether the fast kernel proves it too.
        fast: CPU time of the fast kernel [s].
        fast_read: Likewise, with reading the file [s].
    """

    family: str
    name: str
    fault: str
    sampled: bool = False
    whole: bool = False
    size: ProofSize | None = None
    write: float = 0.0
    check: float = 0.0
    proven_fast: bool = False
    fast: float = 0.0
    fast_read: float = 0.0


def main() -> None:
    """Prove all motions, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path, nargs="?", help="MotionBenchMaker's problems")
    parser.add_argument("--robots", default=",".join(ROBOTS), help="names, separated by commas")
    parser.add_argument("--limit", type=int, help="problems of each set at most")
    parser.add_argument("--clouds", type=int, default=10, help="problems of each set, as clouds, at most")
    parser.add_argument("--out", type=Path, default=Path("out/proofs"), help="folder of the rows")
    parser.add_argument("--page", type=Path, help="Markdown file with the section's markers")
    given = parser.parse_args()
    rows = Rows(given.out / "rows.jsonl")
    asked = suite(), of_robots(given.data, given.robots, given.limit), as_clouds(given.data, given.clouds)
    keys = list[str]()
    for family, name, problem in chain.from_iterable(asked):
        keys.append(f"{family}: {name}")
        if keys[-1] not in rows.done:
            rows.append({"key": keys[-1], "checked": planned(family, name, problem)})
            print(rows.done[keys[-1]], flush=True)
    found = [checked_of(row) for row in (rows.done[key]["checked"] for key in keys) if row is not None]
    families = list(dict.fromkeys(each.family for each in found))
    text = table(
        HEAD, [row(family, [each for each in found if each.family == family]) for family in families]
    )
    print(text)
    if given.page is not None:
        write_section(given.page, "proofs", text)


def planned(family: str, name: str, problem: to.Problem) -> dict[str, Any] | None:
    """Plan a problem and prove its motion; return None if there is no verified one."""
    result = to.plan(problem, seconds=20.0)
    if not result.verified:
        return None
    with tempfile.TemporaryDirectory() as folder:
        return asdict(proven(family, name, result, Path(folder) / "x.proof"))


def checked_of(row: Any) -> Checked:
    """Return a motion from its row."""
    size = row["size"]
    return replace(Checked(**row), size=None if size is None else ProofSize(**size))


def suite() -> Iterator[tuple[str, str, to.Problem]]:
    """Yield the installed problems."""
    for name in sorted(each.name for each in entry_points(group="trajopt.problems")):
        yield "suite", name, named_problem(name)


def of_robots(data: Path | None, robots: str, limit: int | None) -> Iterator[tuple[str, str, to.Problem]]:
    """Yield MotionBenchMaker's problems; none without data."""
    if data is None:
        return
    for robot in robots.split(","):
        found = problems(data, robot)
        if isinstance(found, to.TrajoptError):
            raise found
        for name, instance in found.items():
            if limit is None or int(name.split("/")[1]) <= limit:
                yield TITLES[robot], name, instance.make()


def as_clouds(data: Path | None, limit: int | None) -> Iterator[tuple[str, str, to.Problem]]:
    """Yield the Panda's problems with 10,000 points on the surface of each object in its place."""
    for _, name, problem in of_robots(data, "panda", limit):
        yield "Panda, clouds", name, with_cloud(problem, clouds_of(problem.scene).raw)


def proven(family: str, name: str, result: to.Result, path: Path) -> Checked:
    """Write and check the proof of a motion."""
    begin = time.process_time()
    try:
        size = save_proof(result.problem, result.require().trajectory, path)
    except ProblemError as error:
        return Checked(family, name, str(error))
    written, before = time.process_time(), resource.getrusage(resource.RUSAGE_CHILDREN)
    answer = check_proof(path)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    fault = "" if answer.proven else answer.words.splitlines()[-1]
    proof = MotionProof.read(path)
    proven_fast = not proof.fast_fault
    kernel = StatedProof(proof.statement, proof.witness) if proven_fast else None
    return Checked(
        family,
        name,
        fault,
        "torque: sampled" in answer.words,
        not proof.statement["judged"],
        size,
        written - begin,
        used,
        proven_fast,
        0.0 if kernel is None else least_time(kernel.fault),
        0.0 if kernel is None else least_time(lambda: MotionProof.read(path).fast_fault),
    )


def least_time(call: Callable[[], str]) -> float:
    """Return the least CPU time of five calls [s]."""
    found: list[float] = []
    for _ in range(5):
        begin = time.process_time()
        call()
        found.append(time.process_time() - begin)
    return min(found)


def row(family: str, found: list[Checked]) -> tuple[str, ...]:
    """Return a row of the table: medians and largest."""
    good = [each for each in found if not each.fault]
    sizes = [each.size for each in good if each.size is not None]
    columns = (
        ([each.leaves for each in sizes], "{:.0f}"),
        ([each.witness / 1000.0 for each in sizes], "{:.1f}"),
        ([each.statement / 1000.0 for each in sizes], "{:.0f}"),
        ([1000.0 * each.write for each in good], "{:.0f}"),
        ([each.check for each in good], "{:.2f}"),
        ([1000.0 * each.fast for each in good if each.proven_fast], "{:.2f}"),
        ([1000.0 * each.fast_read for each in good if each.proven_fast], "{:.1f}"),
    )
    numbers = [
        f"{form.format(float(np.median(values)))} / {form.format(max(values))}" if values else "-"
        for values, form in columns
    ]
    with_torque, whole = sum(not each.sampled for each in good), sum(each.whole for each in good)
    fast = str(sum(each.proven_fast for each in good))
    return (
        family,
        str(len(found)),
        str(len(good)),
        str(with_torque),
        str(whole),
        *numbers[:-2],
        fast,
        *numbers[-2:],
    )


if __name__ == "__main__":
    main()
