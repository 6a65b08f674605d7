"""Simulation of tasks and of pick and place, with objects held by friction."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any

import numpy as np

from trajopt.simulation import (
    ContactInterval,
    Friction,
    Phase,
    PoseError,
    SequenceLog,
    SimulationOptions,
    simulate_phases,
)
from trajopt.tasks.grasping.result import STAGES, PickPlaceResult, Segment, Stage
from trajopt.tasks.result import TaskResult
from trajopt.values.arrays import Value, number, one_of, readonly
from trajopt.values.errors import ModelError, ShapeError, shown

STEP = 1e-3
"""Default time step [s]: twice the step doubles the creep of an object in a rotating hand."""


class Hold(Enum):
    """How well the object was held; each value describes itself."""

    HELD = "the fingers held the object"
    SLIPPED = "the object slipped in the fingers"
    LOST = "the fingers lost the object"


@dataclass(frozen=True)
class HoldLimits:
    """Limits beyond which an object counts as slipped.

    Attributes:
        position: Largest shift in the hand [m].
        rotation: Largest turn in the hand [rad].
    """

    position: float = 5e-3
    rotation: float = 0.05

    def __post_init__(self) -> None:
        for name in ("position", "rotation"):
            if number(name, getattr(self, name)) <= 0.0:
                raise ShapeError(name, f"must be positive, is {getattr(self, name):g}")


@dataclass(frozen=True)
class Slip:
    """Motion of the object in the hand, relative to the beginning of the lift.

    Attributes:
        time: First time beyond the limits [s].
        worst: The largest shift and the largest turn until the release.
    """

    time: float
    stage: Stage
    worst: PoseError


@dataclass(frozen=True, eq=False, kw_only=True)
class PickPlaceRollout:
    """A simulated pick and place.

    Attributes:
        shift: Largest motion of the object in the hand while held.
        disturbed: Motion of the object before the fingers closed.
        settled: Deviation of the object in the hand from the plan at the beginning of the lift.
        final_error: Final deviation from the chosen place; None without a place.
    """

    result: PickPlaceResult
    log: SequenceLog = field(repr=False)
    hold: Hold
    slip: Slip | None
    shift: PoseError
    disturbed: PoseError
    settled: PoseError
    final_error: PoseError | None

    @property
    def notes(self) -> tuple[str, ...]:
        """Differences of the MuJoCo model from robot and scene."""
        return self.log.notes

    @property
    def succeeded(self) -> bool:
        """Whether nothing else touched, and the fingers held the object."""
        return self.hold is Hold.HELD and not self.log.contacts and self.log.diverged is None

    def summary(self) -> str:
        """Summarise the outcome in a few words."""
        log = self.log
        if log.diverged is not None:
            return f"The simulation blew up after {log.diverged:.3f} s and was stopped."
        parts = [
            f"Simulated {log.times[-1]:.2f} s; {self.hold.value}: moved {_words(self.shift)} in the hand"
        ]
        if self.slip is not None:
            parts.append(f"slipped first at {self.slip.time:.2f} s, in {self.slip.stage.name}")
        if self.final_error is not None:
            parts.append(f"{shown(self.result.name)} ended {_words(self.final_error)} from its planned place")
        parts += [str(contact) for contact in log.contacts[:3]]
        return "; ".join(parts) + "."

    @property
    def errors(self) -> Mapping[str, object]:
        """The slip, and all deviations, as plain data."""
        named = ("shift", "disturbed", "settled", "final_error")
        errors: dict[str, PoseError | None] = {name: getattr(self, name) for name in named}
        return {
            "slip": self.slip and {"time": self.slip.time, "stage": self.slip.stage.name},
            **{
                name: error and {"position": error.position, "rotation": error.rotation}
                for name, error in errors.items()
            },
        }

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "object": self.result.name,
            "hold": self.hold.name,
            **self.errors,
            "diverged": self.log.diverged,
            "contacts": [str(contact) for contact in self.log.contacts],
            "times": self.log.times.tolist(),
            "joint_names": list(self.result.scene.robot.joint_names),
            "positions": self.log.positions.tolist(),
            "object_placements": [
                [*where.translation.tolist(), *where.quaternion.tolist()]
                for where in self.log.placements[self.result.name]
            ],
        }


def simulate_handling(
    result: PickPlaceResult,
    *,
    friction: Friction | None = None,
    limits: HoldLimits | None = None,
    options: SimulationOptions | None = None,
) -> PickPlaceRollout:
    """Execute a pick and place in MuJoCo, where only friction holds the object.

    One world for all stages: the object is a free body on its support, and nothing is attached.

    Args:
        result: A verified sequence that begins with a pick.
        friction: Of the object; rubber pads if None.
        options: Step, gains, settling time; a step of a millisecond if None.
    """
    segments = result.require()
    if result.grasp is None:
        raise ModelError(f"object {shown(result.name)} was in the hand from the beginning: there is no grasp")
    log = simulate_phases(
        result.scene,
        result.start,
        [_phase(result, segment) for segment in segments],
        loose=(result.name,),
        fingers=result.gripper.fingers,
        driven_together=result.gripper.driven_together(result.scene.robot, result.start),
        friction=friction or Friction(),
        options=options or SimulationOptions(dt=STEP),
    )
    return _judged(result, log, limits or HoldLimits())


def _phase(result: PickPlaceResult, segment: Segment) -> Phase:
    return Phase(
        name=segment.stage.name,
        reduced=segment.result.problem.reduced,
        trajectory=segment.trajectory,
        rest=segment.rest,
        presses=_presses(result, segment.stage),
    )


def _presses(result: PickPlaceResult, stage: Stage) -> Mapping[str, float]:
    """Return joint of the fingers -> effort in a stage [N | Nm]."""
    assert result.grasp is not None
    closed = stage is Stage.CLOSE or stage.holds
    return result.gripper.pressing(result.grasp.width, result.grasp.force) if closed else {}


@dataclass(frozen=True, eq=False, kw_only=True)
class TaskRollout(Value):
    """A simulated task.

    Attributes:
        handlings: Each pick of an object that friction holds, with its place, in the order of the task.
        notes: Differences of the simulation from the task.
    """

    result: TaskResult = field(repr=False)
    log: SequenceLog = field(repr=False)
    handlings: tuple[PickPlaceRollout, ...]
    notes: tuple[str, ...]

    @property
    def diverged(self) -> float | None:
        """Time at which the simulation diverged [s]; None if it did not."""
        return self.log.diverged

    @property
    def contacts(self) -> tuple[ContactInterval, ...]:
        """Contacts of the robot and of objects on tracks that the scene does not allow."""
        return self.log.contacts

    @property
    def succeeded(self) -> bool:
        """Whether nothing collided, and the fingers held every object."""
        held = all(each.succeeded for each in self.handlings)
        return held and not self.contacts and self.diverged is None

    def summary(self) -> str:
        """Summarise the outcome in a few words."""
        if self.diverged is not None:
            return f"The simulation blew up after {self.diverged:.3f} s and was stopped."
        parts = [f"Simulated {self.log.times[-1]:.2f} s of {shown(self.result.name)}"]
        for each in self.handlings:
            ended = "" if each.final_error is None else f", ended {_words(each.final_error)} from its place"
            parts.append(f"{each.result.name}: {each.hold.value}{ended}")
        parts += [str(contact) for contact in self.contacts[:3]] or ["no contact"]
        return "; ".join(parts) + "."

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "task": self.result.name,
            "succeeded": self.succeeded,
            "handlings": [
                {"object": each.result.name, "hold": each.hold.name, **each.errors} for each in self.handlings
            ],
            "diverged": self.diverged,
            "contacts": [str(contact) for contact in self.contacts],
            "times": self.log.times.tolist(),
            "joint_names": list(self.result.scene.robot.joint_names),
            "positions": self.log.positions.tolist(),
            "object_placements": {
                name: [[*where.translation.tolist(), *where.quaternion.tolist()] for where in places]
                for name, places in self.log.placements.items()
            },
            "notes": list(self.notes),
        }


def simulate_task(
    result: TaskResult,
    *,
    friction: Friction | None = None,
    limits: HoldLimits | None = None,
    options: SimulationOptions | None = None,
) -> TaskRollout:
    """Execute a task in MuJoCo, where only friction holds the objects that the gripper picks.

    One world for all stages, as in `simulate_handling`. Objects without mass, and those that are attached
    without a grasp, follow their planned tracks; notes name them.

    Args:
        friction: Of the objects; rubber pads if None.
        options: Step, gains, settling time; a step of a millisecond if None.

    Raises:
        PlanningFailed: If the result has no plan.
        ModelError: If the robot has no mass.
    """
    one_of("result", result, TaskResult)
    segments, handlings = result.require(), _held_by_friction(result)
    loose = tuple(dict.fromkeys(part.name for _, part in handlings))
    presses: list[Mapping[str, float]] = [{} for _ in segments]
    for indices, part in handlings:
        for index, segment in zip(indices, part.segments, strict=True):
            presses[index] = {**presses[index], **_presses(part, segment.stage)}
    phases = [
        Phase(
            name=segment.title,
            reduced=segment.result.problem.reduced,
            trajectory=segment.trajectory,
            rest=segment.rest,
            presses=pressed,
        )
        for segment, pressed in zip(segments, presses, strict=True)
    ]
    hands = [part.gripper for _, part in handlings]
    together = [hand.driven_together(result.scene.robot, result.start) for hand in hands]
    log = simulate_phases(
        result.scene_on_tracks(loose),
        result.start,
        phases,
        loose=loose,
        fingers=tuple(dict.fromkeys(link for hand in hands for link in hand.fingers)),
        driven_together=dict(item for each in together for item in each.items()),
        friction=friction or Friction(),
        options=options or SimulationOptions(dt=STEP),
    )
    judged = [
        _judged(part, _of_phases(log, indices), limits or HoldLimits())
        for indices, part in handlings
        if log.phases[-1] >= indices[0]
    ]
    notes = (
        f"object {shown(name)} follows its planned motion: it has no mass, or no grasp holds it"
        for name in result.handled
        if name not in loose
    )
    return TaskRollout(result=result, log=log, handlings=tuple(judged), notes=(*log.notes, *notes))


def _of_phases(log: SequenceLog, indices: range) -> SequenceLog:
    """Return the samples of some phases, which count from the first of them."""
    chosen = (log.phases >= indices[0]) & (log.phases <= indices[-1])
    rows: list[int] = np.flatnonzero(chosen).tolist()
    return replace(
        log,
        times=readonly(log.times[chosen]),
        phases=log.phases[chosen] - indices[0],
        positions=readonly(log.positions[chosen]),
        placements={name: tuple(each[row] for row in rows) for name, each in log.placements.items()},
        touching={name: tuple(each[row] for row in rows) for name, each in log.touching.items()},
    )


def _held_by_friction(result: TaskResult) -> list[tuple[range, PickPlaceResult]]:
    """Return the handlings, in order, of the objects with mass that are held in grasps only."""
    found: list[tuple[range, PickPlaceResult]] = []
    for name, handled in result.handled.items():
        if result.scene.object(name).mass <= 0.0 or any(item.grasp is None for item in handled):
            continue
        parts = [result.part(name, item) for item in handled]
        held = {index for index, segment in enumerate(result.segments) if segment.holds(name)}
        if held <= {index for indices, _ in parts for index in indices}:
            found += parts
    return sorted(found, key=lambda part: part[0][0])


def _judged(result: PickPlaceResult, log: SequenceLog, limits: HoldLimits) -> PickPlaceRollout:
    scene, name = result.scene, result.name
    stages = [result.segments[int(place)].stage for place in log.phases]
    before = [k for k, stage in enumerate(stages) if STAGES.index(stage) < STAGES.index(Stage.CLOSE)]
    held = [k for k, stage in enumerate(stages) if stage.holds]
    tool = result.gripper.tool
    in_hand = [scene.placement_of(tool, log.positions[k]).inverse() * log.placements[name][k] for k in held]
    moved = [PoseError.between(in_hand[0], where) for where in in_hand]
    shift = PoseError(
        max((error.position for error in moved), default=np.inf),
        max((error.rotation for error in moved), default=np.inf),
    )
    beyond = [
        k
        for k, error in zip(held, moved, strict=True)
        if error.position > limits.position or error.rotation > limits.rotation
    ]
    kept = bool(held) and set(result.gripper.fingers) <= log.touching[name][held[-1]]
    hold = Hold.LOST if not kept else Hold.SLIPPED if beyond else Hold.HELD
    stood = scene.placement_of(name, result.start)
    assert result.grasp is not None
    planned = result.grasp.placement.inverse()
    return PickPlaceRollout(
        result=result,
        log=log,
        hold=hold,
        slip=Slip(float(log.times[beyond[0]]), stages[beyond[0]], shift) if beyond else None,
        shift=shift,
        disturbed=PoseError.between(stood, log.placements[name][before[-1]] if before else stood),
        settled=PoseError.between(planned, in_hand[0] if in_hand else planned),
        final_error=_final_error(result, log),
    )


def _final_error(result: PickPlaceResult, log: SequenceLog) -> PoseError | None:
    place = result.place
    if place is None or log.diverged is not None:
        return None
    frame = result.scene.placement_of(place.frame, result.start)
    off = place.error(log.placements[result.name][-1], frame)
    return PoseError(float(np.linalg.norm(off[:3])), float(np.linalg.norm(off[3:])))


def _words(error: PoseError) -> str:
    return f"{error.position * 1e3:.2g} mm and {np.rad2deg(error.rotation):.2g} degrees"
