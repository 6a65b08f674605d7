"""Result of planning: a verified plan, or why there is none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from math import inf, isfinite
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from trajopt.native import native_cores
from trajopt.optimise.methods import Method
from trajopt.optimise.solvers import SolveResult, SolverStatus
from trajopt.planning.budget import Budget, BudgetTracker, Stop
from trajopt.planning.infeasibility.reasons import Obstruction
from trajopt.planning.judgement import Judged
from trajopt.planning.seeds import SeedKind
from trajopt.planning.status import Certainty, Status
from trajopt.problem.problem import Problem
from trajopt.timing import Retimed
from trajopt.values.arrays import Floats, Value
from trajopt.values.documents.document import write_json
from trajopt.values.errors import PlanningFailed, ProblemError, shown, unknown_attribute
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.printed import in_number
from trajopt.values.trajectory import Path, Trajectory
from trajopt.verify import Certificate

if TYPE_CHECKING:
    from trajopt.why import Explanation


@dataclass(frozen=True, eq=False)
class Recalled(Value):
    """Remembered motions of similar problems.

    Attributes:
        version: Of the memory: the number of its changes by then.
        seeds: The knots of their paths, shape (k, n) each [rad | m].
    """

    version: int
    memories: tuple[int, ...] = ()
    seeds: tuple[Floats, ...] = ()

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data, without the paths."""
        return {"version": self.version, "memories": list(self.memories)}


@dataclass(frozen=True, eq=False)
class PlanArguments(Value):
    """Arguments of planning.

    Attributes:
        seeds: Knots of the given or remembered paths, shape (k, n) each [rad | m].
        recalled: The remembered motions and the version of the memory; None without experience. Its paths are
            the last of `seeds`.
    """

    method: Method | str | None = None
    improve: bool = False
    every_goal: bool = False
    budget: Budget = field(default_factory=Budget)
    random: Mapping[str, Any] | None = None
    seeds: tuple[Floats, ...] = ()
    recalled: Recalled | None = None

    @staticmethod
    def of(
        method: Method | str | None,
        improve: bool,
        every_goal: bool,
        budget: Budget,
        rng: np.random.Generator | None,
        seeds: tuple[Floats, ...],
        recalled: Recalled | None = None,
    ) -> PlanArguments:
        """Keep the arguments of a call that has not yet drawn from its generator."""
        state = None if rng is None else rng.bit_generator.state
        return PlanArguments(method, improve, every_goal, budget, state, seeds, recalled)

    @property
    def generator(self) -> np.random.Generator | None:
        """A generator in the state of the given one; None without."""
        if self.random is None:
            return None
        name = self.random.get("bit_generator")
        kind = {each.__name__: each for each in _GENERATORS}.get(str(name))
        if kind is None:
            raise ProblemError(f"no kind of random generator is called {shown(name)}")
        bits: Any = kind()
        try:
            bits.state = dict(self.random)
        except (TypeError, ValueError, KeyError) as error:
            raise ProblemError(f"the state of the random generator is invalid: {error}") from error
        return np.random.Generator(bits)

    @property
    def repeatable(self) -> bool:
        """Whether planning again must end the same: no clock had a part in it."""
        return self.budget.seconds is None


_GENERATORS = (np.random.PCG64, np.random.PCG64DXSM, np.random.MT19937, np.random.Philox, np.random.SFC64)


@dataclass(frozen=True)
class Attempt:
    """Record of one seed: optimised, timed and judged as far as it got.

    Attributes:
        number: In the order of attempts, from 1.
        solver: Status of the solver, if it got that far.
        message: Which constraint was violated, where and by how much.
        block: The main obstruction; None if there was none, or none with a location.
        goal_name: Of a goal set: its goal.
    """

    number: int
    kind: SeedKind
    status: Status
    solver: SolverStatus | None
    message: str
    iterations: int
    block: Obstruction | None = None
    goal_name: str = ""

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        return {
            "number": self.number,
            "kind": self.kind.name,
            "status": self.status.name,
            "solver": None if self.solver is None else self.solver.name,
            "message": self.message,
            "iterations": self.iterations,
            "block": None if self.block is None else self.block.as_dict(),
            "goal_name": self.goal_name,
        }

    def __repr__(self) -> str:
        steps = f"{self.iterations} step{'s' * (self.iterations != 1)}"
        return f"Attempt({self.number}, {self.kind.name}: {self.status.name} after {steps})"

    def __str__(self) -> str:
        goal = f" of {shown(self.goal_name)}" if self.goal_name else ""
        message = f": {self.message}" if self.message else ""
        return f"attempt {self.number}, {self.kind.value}{goal}: {self.status.name}{message}"


HEAD = ("goal", "duration [s]", "path length", "clearance [mm]", "status")


@dataclass(frozen=True)
class ComparedGoal:
    """Result of one goal of a set.

    Attributes:
        duration: Of the verified motion to it [s]; None without.
        path_length: Of its path in joint space [rad | m].
        clearance: Proven distance to everything that must keep apart [m]; may be infinite.
    """

    name: str
    status: Status
    duration: float | None = None
    path_length: float | None = None
    clearance: float | None = None

    def as_dict(self) -> dict[str, object]:
        known = self.clearance if self.clearance is not None and isfinite(self.clearance) else None
        return {**asdict(self), "status": self.status.name, "clearance": known}

    @property
    def cells(self) -> tuple[str, ...]:
        millimetres = None if self.clearance is None else 1000.0 * self.clearance
        numbers = ((self.duration, ".3f"), (self.path_length, ".3f"), (millimetres, ".1f"))
        told = ("-" if value is None or not isfinite(value) else f"{value:{form}}" for value, form in numbers)
        return self.name, *told, self.status.name


def table(goals: Sequence[ComparedGoal]) -> list[str]:
    """Return the lines of a table, with its head; numbers are aligned right."""
    rows = (HEAD, *(goal.cells for goal in goals))
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
    lines = (
        "  ".join(
            cell.rjust(width) if 0 < column < len(HEAD) - 1 else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )
    return [line.rstrip() for line in lines]


SHOWN_ATTEMPTS = 5
"""Attempts that a printed result lists."""


def improvement(along_path: float, duration: float) -> str:
    """Return a sentence on the durations [s] along the path and with shape and time optimised together."""
    if duration >= along_path:
        return f"nothing shorter than {along_path:.3f} s along the path was found"
    return f"from {along_path:.3f} s along the path, by {1.0 - duration / along_path:.1%}"


@checked_class
@dataclass(frozen=True, eq=False)
class Plan:
    """A verified motion.

    Attributes:
        along_path: If shape and time were optimised together: duration of the fastest motion along the
            initial path (of a start in motion: after it has stopped) [s].
    """

    problem: Problem
    path: Path
    trajectory: Trajectory
    judged: Judged
    along_path: float | None = None

    @property
    def final_state(self) -> Mapping[str, float]:
        reduced = self.problem.reduced
        at = self.trajectory.positions[-1][
            [self.trajectory.joint_names.index(j) for j in reduced.joint_names]
        ]
        joints = self.problem.scene.robot.joint_names
        return dict(zip(joints, map(float, reduced.all_positions(at)), strict=True))

    @property
    def final_velocity(self) -> Mapping[str, float]:
        """Joint of the group -> velocity at the end, for `start_velocity` [rad/s | m/s]."""
        return self._final(1)

    @property
    def final_acceleration(self) -> Mapping[str, float]:
        """Joint of the group -> acceleration at the end, for `start_acceleration` [rad/s^2 | m/s^2]."""
        return self._final(2)

    def _final(self, order: int) -> Mapping[str, float]:
        motion = self.trajectory
        return dict(zip(motion.joint_names, map(float, motion(motion.duration, order)), strict=True))

    @property
    def certificate(self) -> Certificate:
        """The judge's checks, with their margins and proofs."""
        return self.judged.certificate

    def __repr__(self) -> str:
        return (
            f"Plan({shown(self.problem.name)}, {self.trajectory.duration:.3f} s, {self.certificate.closest})"
        )

    def __str__(self) -> str:
        lines = [f"{self.problem}", f"  motion       {self.trajectory}"]
        if self.along_path is not None:
            lines.append(f"  improved     {improvement(self.along_path, self.trajectory.duration)}")
        return "\n".join([*lines, f"  judged       {self.certificate.verdict}"])

    def require(self) -> Plan:
        return self

    def write(self, path: FilePath | str) -> None:
        """Write the motion and its certificate as JSON, which `trajopt view`, `check` and `export` take.

        Raises:
            FileFormatError: If the file cannot be written.
        """
        status = {"status": Status.SOLVED.name, "verified": True, "name": self.problem.name}
        certificate = {"certificate": self.certificate.as_dict()}
        write_json(path, {**status, **self.trajectory.as_dict(), **certificate})

    def save(self, path: FilePath | str, *, proof: bool = False) -> None:
        """Write a bundle, as `Result.save`, without the report of planning."""
        from trajopt.files.bundle import save

        save(self, path, proof=proof)

    def save_proof(self, path: FilePath | str) -> None:
        """Write a proof file, which a small checker proves without trajopt (docs/proofs.md).

        Raises:
            ProblemError: If no witness is found.
            FileFormatError: If the file cannot be written.
        """
        from trajopt.files.proof import save_proof

        save_proof(self.problem, self.trajectory, path)


OTHER_NAMES = {
    **dict.fromkeys(
        ("success", "succeeded", "successful", "ok", "is_success", "solved", "found"), "result.verified"
    ),
    **dict.fromkeys(("plan", "solution", "get_plan"), "result.require(), which raises if there is no plan"),
    **dict.fromkeys(("error", "error_message", "why"), "result.reason, or result.explain()"),
    **dict.fromkeys(("joint_trajectory", "motion"), "result.trajectory"),
    **dict.fromkeys(("error_code", "val"), "result.status"),
}
"""Names of attributes in other libraries, and their names here."""


@checked_class
class SavedResult(Value):
    """A result of one or several motions, which a file can contain."""

    if TYPE_CHECKING:
        stopped: Stop | None
    else:

        def __getattr__(self, name: str) -> object:
            raise unknown_attribute(self, name, OTHER_NAMES)

    @property
    def stopped_by_clock(self) -> bool:
        """Whether time ran out: then, and only then, planning again may end differently."""
        return self.stopped is Stop.CLOCK

    @property
    def missing(self) -> str:
        """A stage that a plan must have and does not, such as one cut off a file; empty for none."""
        return ""

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data."""
        raise NotImplementedError

    def write(self, path: FilePath | str) -> None:
        """Write `as_dict` as JSON; `trajopt view`, `check` and `export` take the file of a single motion.

        Raises:
            FileFormatError: If the file cannot be written.
        """
        write_json(path, self.as_dict())

    def save(self, path: FilePath | str) -> None:
        """Write all motions, their problems and the rejected ways into one file; `read_result` reads it.

        Raises:
            ModelError: If a problem contains code of the caller, which a file cannot hold.
            FileFormatError: If the file cannot be written.
        """
        from trajopt.files.bundle import save

        save(self, path)


@dataclass(frozen=True, eq=False)
class Result(SavedResult):
    """Result of planning.

    Attributes:
        message: The particulars.
        trajectory: The motion, verified or not, if it got that far.
        timed: Report of retiming; None if the method determined time itself.
        counts: Exact counts of the work done.
        cpu_seconds: Process time of each stage [s].
        goal_name: Of a goal set: the goal that was reached; `problem` has that goal alone.
        alternatives: Of a goal set that failed: the result of each goal, nearest first.
        won: Of a motion: its attempt.
        stopped: Reason for ending planning early; None if it was completed.
        certainty: Of the status; of a goal set that failed, proven only if the failure of every goal is.
        because: Reason why planning chose that method; empty if requested, or the default.
        along_path: As in a plan; None if no faster motion than along the path was looked for.
        of_each_goal: Of a goal set, if every goal was requested: the result of each, the fastest motion
            first.
        remarks: Sentences on parts of the problem that were changed, or may be intended otherwise.
        blocks: Of a failure among changing objects: the obstructions, with their times.
        arguments: Arguments of planning other than the problem; None if it was not made by `plan`.
    """

    problem: Problem
    status: Status
    message: str
    path: Path | None
    solve: SolveResult | None
    trajectory: Trajectory | None
    timed: Retimed | None
    judged: Judged | None
    counts: Mapping[str, int]
    cpu_seconds: Mapping[str, float]
    goal_name: str = ""
    alternatives: Mapping[str, Result] = field(default_factory=dict[str, "Result"])
    attempts: tuple[Attempt, ...] = ()
    won: Attempt | None = None
    stopped: Stop | None = None
    certainty: Certainty = Certainty.EVIDENCE
    method: str = ""
    because: str = ""
    along_path: float | None = None
    of_each_goal: Mapping[str, Result] = field(default_factory=dict[str, "Result"])
    remarks: tuple[str, ...] = ()
    blocks: tuple[Obstruction, ...] = ()
    arguments: PlanArguments | None = None

    def __repr__(self) -> str:
        parts = [shown(self.problem.name), self.status.name]
        if self.trajectory is not None and self.certificate is not None:
            parts += [f"{self.trajectory.duration:.3f} s", self.certificate.closest]
        return f"Result({', '.join([*parts, in_number(self.attempts, 'attempt')])})"

    def __str__(self) -> str:
        lines = [self.reason, *(f"  note     {remark}" for remark in self.remarks)]
        if self.trajectory is not None and self.certificate is not None:
            lines.append(f"  motion   {self.trajectory}")
            if self.along_path is not None:
                lines.append(f"  improved {improvement(self.along_path, self.trajectory.duration)}")
            lines.append(f"  judged   {self.certificate.verdict}")
        if self.because:
            lines.append(f"  method   {self.method}: {self.because}")
        lines += [f"  {each}" for each in self.attempts[:SHOWN_ATTEMPTS]]
        if len(self.attempts) > SHOWN_ATTEMPTS:
            lines.append(f"  and {len(self.attempts) - SHOWN_ATTEMPTS} more attempts")
        if self.of_each_goal:
            lines += [f"  {line}" for line in table(self.compared)]
        return "\n".join(lines)

    @property
    def certificate(self) -> Certificate | None:
        """The judge's checks, with their margins and proofs, if planning got that far.

        Margins are measured on first use, which takes a few milliseconds.
        """
        return None if self.judged is None else self.judged.certificate

    @property
    def compared(self) -> tuple[ComparedGoal, ...]:
        """Results of each goal, if every goal was requested, the fastest motion first."""
        return tuple(
            ComparedGoal(name, found.status)
            if found.trajectory is None
            or found.path is None
            or found.certificate is None
            or not found.verified
            else ComparedGoal(
                name,
                found.status,
                found.trajectory.duration,
                found.path.length,
                found.certificate.clearance,
            )
            for name, found in self.of_each_goal.items()
        )

    @property
    def verified(self) -> bool:
        """Whether there is a plan and the judge verified it."""
        return self.status is Status.SOLVED

    @property
    def cost(self) -> float:
        """The duration, by which motions of one problem are compared [s]; infinite without a plan."""
        return self.trajectory.duration if self.verified and self.trajectory is not None else inf

    @property
    def final_state(self) -> Mapping[str, float]:
        """Joint -> position of all joints at the end of the plan [rad | m].

        Raises:
            PlanningFailed: Without a plan; carries this result.
        """
        return self.require().final_state

    @checked
    def counted(self, tracker: BudgetTracker) -> Result:
        """Return this result with the counts and CPU times of a tracker."""
        return replace(self, counts=dict(tracker.counts), cpu_seconds=dict(tracker.seconds))

    @checked
    def planned_as(self, other: Result) -> Result:
        """Return this result with the attempts, method and goal of the one that it was derived from."""
        return replace(
            self,
            attempts=other.attempts,
            won=other.won,
            method=other.method,
            because=other.because,
            along_path=other.along_path,
            goal_name=other.goal_name,
        )

    def require(self) -> Plan:
        """Return the plan.

        Raises:
            PlanningFailed: If there is none; carries this result.
        """
        if self.path is None or self.trajectory is None or self.judged is None or not self.verified:
            raise PlanningFailed(self.reason, self)
        return Plan(self.problem, self.path, self.trajectory, self.judged, self.along_path)

    def as_dict(self) -> dict[str, object]:
        """Return plain JSON data; the points are the motion's, if any."""
        trajectory = self.trajectory
        recalled = None if self.arguments is None else self.arguments.recalled
        motion: dict[str, object] = {"joint_names": list(self.problem.reduced.joint_names), "points": []}
        if trajectory is not None:
            motion = trajectory.as_dict()
        return {
            "status": self.status.name,
            "verified": self.verified,
            "message": self.reason,
            "remarks": list(self.remarks),
            "certainty": self.certainty.name,
            "blocks": [block.as_dict() for block in self.blocks],
            "name": self.problem.name,
            "goal_name": self.goal_name,
            **motion,
            "certificate": None if self.certificate is None else self.certificate.as_dict(),
            "tries": [item.as_dict() for item in self.attempts],
            "won_by": None if self.won is None else self.won.kind.name,
            "stopped": None if self.stopped is None else self.stopped.name,
            "stopped_by_clock": self.stopped_by_clock,
            "counts": dict(self.counts),
            "native_cores": list(native_cores()),
            "qp_backends": [] if self.solve is None else list(self.solve.qp_backends),
            "cpu_seconds": {**self.cpu_seconds, "total": sum(self.cpu_seconds.values())},
            "path_length": None if self.path is None else self.path.length,
            "duration": None if trajectory is None else trajectory.duration,
            "along_path": self.along_path,
            "method": {"name": self.method, "because": self.because},
            "experience": None if recalled is None else recalled.as_dict(),
            "goals": [goal.as_dict() for goal in self.compared],
        }

    @checked
    def save(self, path: FilePath | str, *, proof: bool = False) -> None:
        """Write a bundle: one file with robot, scene, problem, motion and verdict, or with the failure.

        Needs no files of the robot; `trajopt.files.bundle.read_bundle` reads it.

        Args:
            proof: Whether to include a proof of the motion (docs/proofs.md).

        Raises:
            ModelError: If the problem holds the caller's code, which no file can hold.
            ProblemError: If a proof is requested, but there is no verified motion, or no witness is found.
            FileFormatError: If the file cannot be written.
        """
        # Bundles are a higher layer, which reads and plans anew; a result only knows where to find it.
        from trajopt.files.bundle import save

        save(self, path, proof=proof)

    @property
    def reason(self) -> str:
        """How planning ended, with the particulars, in a sentence or two; costs nothing."""
        text = f"{self.status.name}: {self.status.value}"
        if self.goal_name:
            text += f", at the goal {shown(self.goal_name)}"
        return f"{text} ({self.message})" if self.message else text

    def explain(self, *, plan_again: bool = False) -> Explanation:
        """Explain a failure: obstructions, certainty, and changes that would help.

        Takes milliseconds to a second or two, without planning again.

        Args:
            plan_again: Whether to plan changed problems too, which takes as long as planning some dozens of
                times: for a failure to find the smallest changes that make it solvable, for a success to find
                the cost of each limit and constraint in seconds.
        """
        from trajopt.why import explain

        return explain(self, plan_again=plan_again)
