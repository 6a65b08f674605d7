"""Write and check proof files."""

import hashlib
import json
import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NoReturn, cast

import numpy as np

import trajopt.verify
from trajopt.files.proof.leaves import SHORTEST, LeafSearch, Leaves, separated
from trajopt.files.proof.pairs import (
    Document,
    Pairs,
    cloud_centres,
    convex_part,
    convex_parts,
    proven_pairs,
)
from trajopt.files.proof.requirements import RequirementRecord, Shown
from trajopt.files.proof.statement import (
    Asked,
    asked,
    followed_goals,
    printable,
    statement,
)
from trajopt.files.proof.torque import stated_torque
from trajopt.native import checker
from trajopt.planning.judgement import judge
from trajopt.problem.problem import Problem
from trajopt.robot.joints import JointLimits
from trajopt.values.arrays import Bools, Floats
from trajopt.values.documents.files import written_whole
from trajopt.values.errors import FileFormatError, ProblemError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Interpolation, Trajectory
from trajopt.verify import VerifyOptions
from trajopt.verify.kernel.kinematics import Kinematics
from trajopt.verify.kernel.motion import JudgedMotion, TimedMotion

LEAF = np.dtype([("begin", "<u2"), ("direction", "<i2", (3,))])
SUFFIX = ".proof"
MOST_JOINTS = 1_000
"""Most joints of a proof, and the world."""
MOST_TIMES = 60_000
LARGEST = 64 * 2**20
"""Most bytes of a proof."""


@dataclass(frozen=True)
class ProofSize:
    """Bytes of statement and witness of a proof, and number of times in the grid."""

    statement: int
    witness: int
    leaves: int
    times: int

    def __str__(self) -> str:
        return (
            f"{self.leaves} leaves at {self.times} times, {self.witness / 1000:.1f} kB of witness and "
            f"{self.statement / 1000:.1f} kB of statement"
        )


@dataclass(frozen=True, eq=False)
class MotionProof:
    """A motion with the witness by which a small checker, without trajopt, proves it (docs/proofs.md)."""

    data: bytes

    @staticmethod
    def read(path: Path | str) -> "MotionProof":
        """Read a proof file; its content is not yet checked.

        Raises:
            FileFormatError: If the file cannot be read.
        """
        try:
            return MotionProof(Path(path).read_bytes())
        except OSError as error:
            raise FileFormatError(str(path), f"cannot be read: {error.strerror}") from error

    @cached_property
    def statement(self) -> Mapping[str, object]:
        """The statement as plain data.

        Raises:
            FileFormatError: If it cannot be read.
        """
        stated = self._parts[0]
        try:
            found = json.loads(stated, parse_constant=_refused, object_pairs_hook=_unique)
        except (ValueError, RecursionError):
            found = None
        if not isinstance(found, dict):
            raise FileFormatError("proof", "has no statement that can be read")
        return cast("dict[str, object]", found)

    @property
    def witness(self) -> bytes:
        """The bytes of the witness.

        Raises:
            FileFormatError: If the file does not begin as a proof does.
        """
        return self._parts[1]

    @property
    def size(self) -> ProofSize:
        """The size.

        Raises:
            FileFormatError: If the statement cannot be read.
        """
        (stated, witness), document = self._parts, cast("Any", self.statement)
        inner = int.from_bytes(witness[:4], "little")
        try:
            motion, duration = document["motion"], document["motion"]["times"][-1]
            knots = {time for each in (motion, *document["drives"]) for time in each["times"]}
            times = inner + sum(time <= duration for time in knots)
            leaves = (len(witness) - 4 - 8 * inner - 4 * len(document["pairs"])) // LEAF.itemsize
        except (LookupError, TypeError) as error:
            raise FileFormatError("proof", "has no motion, drives or pairs that can be read") from error
        return ProofSize(len(stated), len(witness), leaves, times)

    @cached_property
    def _parts(self) -> tuple[bytes, bytes]:
        head = re.match(rb"proof/1 ([0-9]{1,9})\n", self.data)
        if head is None:
            raise FileFormatError("proof", "does not begin with the line 'proof/1 <bytes of the statement>'")
        end = head.end() + int(head[1])
        return self.data[head.end() : end], self.data[end + hashlib.sha256().digest_size :]

    def save(self, path: Path | str) -> None:
        """Write a proof file.

        Raises:
            FileFormatError: If the file cannot be written.
        """
        with written_whole(path) as draft:
            draft.write_bytes(self.data)

    @cached_property
    def fast_fault(self) -> str:
        """The first part that the fast kernel cannot read or show; empty if it proves the statement.

        Raises:
            FileFormatError: If hash, length or JSON are not of a proof.
        """
        stated, witness = self._parts
        end = len(self.data) - len(witness)
        if len(self.data) > LARGEST or self.data[end - 32 : end] != hashlib.sha256(stated).digest():
            raise FileFormatError("proof", "is too long, or its SHA-256 differs")
        document = self.statement
        try:
            return checker.StatedProof(document, witness).fault()
        except ValueError as error:
            return f"the fast kernel cannot read it: {error}"

    def check(self, *, fast: bool = False) -> "CheckedProof":
        """Run the checker.

        Args:
            fast: Whether the fast kernel is enough if it proves the statement; else the checker decides.

        Raises:
            FileFormatError: If it is not a proof of the format.
        """
        if fast and not self.fast_fault:
            return CheckedProof(True, f"{self.statement['title']}: PROVEN by the fast kernel")
        with TemporaryDirectory() as folder:
            path = Path(folder) / f"motion{SUFFIX}"
            path.write_bytes(self.data)
            return check_proof(path)

    def differs_from(self, problem: Problem, trajectory: Trajectory) -> str:
        """Return the first field of the statement that is not of a problem and its motion; empty if none."""
        motion = judged_motion(problem, trajectory)
        bodies, pairs = motion.among.reduced.bodies, proven_pairs(motion)
        parts = [part.document() for part in convex_parts(motion.among.reduced)]
        clouds = [(body.owner, cloud_centres(body).tolist()) for body in bodies if convex_part(body) is None]
        whole = statement(problem, motion, pairs)
        due: Mapping[str, object] = {
            **{name: whole[name] for name in ("title", "motion", "drives", "joints", "ends", "excess")},
            "parts": parts,
            "clouds": sorted((owner, sorted(centres)) for owner, centres in clouds),
            "changes": whole["changes"],
        }
        stated = cast("Any", self.statement)
        try:  # parts around points of clouds are behind the others
            found = {**stated, "parts": stated["parts"][: len(parts)], "clouds": _stated_clouds(stated)}
            weaker = {
                "pairs": _weaker_pairs(stated, whole, pairs),
                "requirements": _weaker_requirements(stated, problem, motion),
            }
        except (LookupError, TypeError, ValueError) as error:
            raise FileFormatError("proof", "has no parts or requirements that can be read") from error
        different = (name for name, value in due.items() if found.get(name) != value)
        return next(chain(different, (name for name, wrong in weaker.items() if wrong)), "")


def _weaker_pairs(stated: Any, due: Mapping[str, Any], pairs: Pairs) -> bool:
    """Return whether pairs are nearer than due, or excused without need."""
    kept = {(one, other): level for one, other, level in stated["pairs"]}
    excused = {(one, other) for one, other, _ in stated["excused"]}
    rows = filter(pairs.excusable, range(len(pairs.pairs)))
    excusable = {tuple(sorted(pairs.owners(row))) for row in rows}
    if excused - {(one, other) for one, other, _ in due["excused"]} - excusable:
        return True
    if any(each not in due["contacts"] for each in stated["contacts"]):
        return True
    return any(
        kept.get((one, other)) != level and tuple(sorted(pairs.owners(row))) not in excused
        for row, (one, other, level) in enumerate(due["pairs"])
    )


def _weaker_requirements(stated: Any, problem: Problem, motion: JudgedMotion) -> bool:
    torque = stated_torque(motion, problem.limits)
    records = (*asked(problem, motion).records, *(() if torque is None else (torque,)))
    return any(
        json.loads(json.dumps(record.document)) not in stated["requirements"]
        and (record.shown is None or printable(record.words) not in stated["judged"])
        for record in records
    )


def _stated_clouds(statement: Any) -> list[tuple[str, list[list[float]]]]:
    clouds = [each for each in statement["requirements"] if each["kind"] == "cloud"]
    return sorted(
        (each["owner"], sorted(centre for _, centres in each["inside"] for centre in centres))
        for each in clouds
    )


def _refused(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number")


def _unique(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name is given twice")
    return found


@checked
def prove(problem: Problem, trajectory: Trajectory) -> MotionProof:
    """Return a proof that a motion meets the requirements of a problem, for a checker that needs no trajopt.

    Requirements without a rule in the format are listed in it as judged, not part of the proof.

    Args:
        trajectory: Of the group's joints, with velocities.

    Raises:
        ProblemError: If the judge refuses the motion, no witness is found, or a name cannot be printed.
    """
    motion = verified_motion(problem, trajectory)
    pairs, leaves = _separated(motion)
    requirements = asked(problem, motion)
    knots = np.union1d(motion.trajectory.times, pairs.knots)
    times = np.union1d(np.union1d(knots, leaves.begin), requirements.times)
    grid = _grid(motion, times, problem.moving_limits)
    documents, judged, grid = _shown(requirements, stated_torque(motion, problem.limits), grid)
    stated = statement(problem, motion, pairs, (*documents, *pairs.clouds), (*requirements.judged, *judged))
    said = json.dumps(stated, allow_nan=False).encode()
    for name in map(json.loads, set(re.findall(rb'"(?:[^"\\]|\\.)*"', said))):
        if name != printable(name):
            raise ProblemError(f"a proof holds printable names of at most 1000 characters, not {shown(name)}")
    witness = _witness(np.setdiff1d(grid, knots), leaves, grid, len(pairs.pairs))
    data = b"proof/1 %d\n" % len(said) + said + hashlib.sha256(said).digest() + witness
    if len(data) > LARGEST:
        raise ProblemError(
            f"a proof has at most {LARGEST} bytes, and this one needs {len(data)}: thin the clouds"
        )
    return MotionProof(data)


@checked
def save_proof(problem: Problem, trajectory: Trajectory, path: Path | str) -> ProofSize:
    """Write a proof file; see `prove`.

    Raises:
        ProblemError: If the judge does not verify the motion, or no witness is found.
        FileFormatError: If the file cannot be written.
    """
    proof = prove(problem, trajectory)
    proof.save(path)
    return proof.size


def verified_motion(problem: Problem, trajectory: Trajectory) -> JudgedMotion:
    """Return a motion that the judge verifies and that a proof can state.

    Raises:
        ProblemError: If it does not, or its points have no velocities, or tracks have too many joints.
    """
    if trajectory.interpolation is Interpolation.LINEAR:
        raise ProblemError("a proof needs the velocities of the motion: without, it jumps at its points")
    timed = problem.reduced.timed
    if timed is not None and timed.reduced.model.njoints > MOST_JOINTS:
        raise ProblemError(
            f"a proof has fewer than {MOST_JOINTS} joints, and the tracks of the scene need "
            f"{timed.reduced.model.njoints - 1}: one for each axis about which an object turns"
        )
    certificate = judge(problem, trajectory)
    if not certificate.verified:
        raise ProblemError(f"there is no proof of a motion that the judge refuses: {certificate.verdict}")
    return judged_motion(problem, trajectory)


def judged_motion(problem: Problem, trajectory: Trajectory) -> JudgedMotion:
    """Return a motion as the judge takes it, among objects that move, and with the rest after its end."""
    reduced, timed = problem.reduced, problem.reduced.timed
    rests = not followed_goals(problem)
    kinematics, options = Kinematics(reduced), VerifyOptions()
    staying = problem.dwell if rests else 0.0
    if staying > 0.0:
        trajectory = _with_rest(trajectory, staying, options.rest_speed)
    motion = JudgedMotion(reduced, trajectory, kinematics=kinematics, options=options, rests_after=rests)
    motion.staying = staying
    if timed is not None:
        motion.among = TimedMotion(timed, trajectory, kinematics=Kinematics(timed.reduced), options=options)
    return motion


def _with_rest(trajectory: Trajectory, staying: float, speed: float) -> Trajectory:
    """Return a motion followed by a rest; accelerations of its end fall to zero within a speed of rest.

    A quintic that returns to its start with an acceleration a within h has the coefficients 0, a h / 4,
    -a h / 4, 0, 0 of its velocity.
    """
    times, orders = [trajectory.duration + staying], (trajectory.velocities, trajectory.accelerations)
    left = 0.0 if trajectory.accelerations is None else float(np.abs(trajectory.accelerations[-1]).max())
    if left > 0.0:
        times.insert(0, trajectory.duration + min(2.0 * speed / left, staying / 2.0))
    ends = [np.repeat(trajectory.positions[-1:], len(times), axis=0)]
    ends += [np.zeros_like(ends[0]) for each in orders if each is not None]
    rows = (each for each in (trajectory.positions, *orders) if each is not None)
    values = (np.vstack(both) for both in zip(rows, ends, strict=True))
    return Trajectory(trajectory.joint_names, np.append(trajectory.times, times), *values)


def _separated(motion: JudgedMotion) -> tuple[Pairs, Leaves]:
    pairs = proven_pairs(motion)
    pairs, leaves, lost = separated(motion.among, pairs)
    if not len(lost.pair):
        return pairs, leaves
    for place, pair in enumerate(lost.pair.tolist()):
        if not pairs.excusable(pair):
            names = " and ".join(pairs.parts[int(part)].body.owner for part in pairs.pairs[pair])
            raise ProblemError(f"no direction separates {names} around {lost.begin[place]:.6g} s")
    pairs = pairs.excusing(set(lost.pair.tolist()))
    return pairs, LeafSearch(motion.among, pairs).search()[0]


def _grid(motion: JudgedMotion, times: Floats, limits: JointLimits) -> Floats:
    grid, lost = _refined(times, _limits_hold(motion, limits), SHORTEST)
    if lost is not None:
        raise ProblemError(f"limits are too tight for a proof around {lost:.6g} s")
    return grid


def _shown(
    requirements: Asked, torque: RequirementRecord | None, grid: Floats
) -> tuple[list[Document], list[str], Floats]:
    """Return requirements that can be shown, names of the others, and the grid that shows them."""
    documents, judged = list[Document](), list[str]()
    for record in (*requirements.records, *(each for each in (torque,) if each is not None)):
        finer, lost = grid, None
        if record.shown is not None:
            finer, lost = _refined(grid, record.shown, record.shortest)
        if lost is None:
            documents.append(record.document)
            grid = finer
        else:
            judged.append(record.words)
    return documents, judged, grid


def _refined(grid: Floats, shown: Shown, shortest: float) -> tuple[Floats, float | None]:
    begin, end = grid[:-1], grid[1:]
    while len(begin):
        open_cells = ~shown(begin, end)
        begin, end = begin[open_cells], end[open_cells]
        if (end - begin < shortest).any() or len(grid) > MOST_TIMES:
            return grid, float(begin[0])
        middle = (begin + end) / 2.0
        grid = np.union1d(grid, middle)
        begin, end = np.concatenate((begin, middle)), np.concatenate((middle, end))
    return grid, None


def _limits_hold(motion: JudgedMotion, limits: JointLimits) -> Shown:
    excess = 0.9 * motion.options.excess
    rates = (limits.velocity, limits.acceleration, limits.jerk)
    lower = [limits.lower - excess * np.maximum(1.0, np.abs(limits.lower))]
    upper = [limits.upper + excess * np.maximum(1.0, np.abs(limits.upper))]
    lower += [-rate * (1.0 + excess) for rate in rates]
    upper += [rate * (1.0 + excess) for rate in rates]

    def shown(begin: Floats, end: Floats) -> Bools:
        holds = np.ones(len(begin), dtype=np.bool_)
        for order in range(4):
            low, high = motion.moving(order).range(begin, end)
            holds &= ((low >= lower[order]) & (high <= upper[order])).all(axis=1)
        return holds

    return shown


def _witness(times: Floats, leaves: Leaves, grid: Floats, pairs: int) -> bytes:
    rows = np.empty(len(leaves.pair), dtype=LEAF)
    rows["begin"], rows["direction"] = np.searchsorted(grid, leaves.begin), leaves.direction
    columns: Sequence[tuple[str, object]] = (
        ("<u4", [len(times)]),
        ("<f8", times),
        ("<u4", np.bincount(leaves.pair, minlength=pairs)),
    )
    return b"".join(np.asarray(column).astype(kind).tobytes() for kind, column in columns) + rows.tobytes()


CHECKER = Path(trajopt.verify.__file__).parent / "checker"
PROVEN, REFUSED = 0, 1


@dataclass(frozen=True)
class CheckedProof:
    """The answer of the checker."""

    proven: bool
    words: str

    def __str__(self) -> str:
        return self.words


def check_proof(path: Path | str, *, fast: bool = False) -> CheckedProof:
    """Check a proof file; see `MotionProof.check`."""
    if fast:
        try:
            return MotionProof.read(path).check(fast=True)
        except FileFormatError as error:
            raise FileFormatError(str(path), error.reason) from error
    command = [sys.executable, "-I", str(CHECKER), str(path)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode not in (PROVEN, REFUSED):
        reason = run.stderr.strip().splitlines()[-1] if run.stderr.strip() else "is no proof"
        raise FileFormatError(str(path), reason.removeprefix(f"{path} "))
    return CheckedProof(run.returncode == PROVEN, run.stdout.rstrip("\n"))
