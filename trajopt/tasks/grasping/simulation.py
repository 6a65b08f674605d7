"""Simulation of pick and place: whether the fingers hold the object, and its final placement."""

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from trajopt.simulation import Friction, Phase, PoseError, SequenceLog, SimulationOptions, simulate_phases
from trajopt.tasks.grasping.result import STAGES, PickPlaceResult, Segment, Stage
from trajopt.values.arrays import number
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
        slip: The slip; None without one.
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

    def as_dict(self) -> dict[str, Any]:
        """Return everything measured as numbers and text, ready for JSON."""
        named = ("shift", "disturbed", "settled", "final_error")
        errors: dict[str, PoseError | None] = {name: getattr(self, name) for name in named}
        return {
            "object": self.result.name,
            "hold": self.hold.name,
            "slip": self.slip and {"time": self.slip.time, "stage": self.slip.stage.name},
            **{
                name: error and {"position": error.position, "rotation": error.rotation}
                for name, error in errors.items()
            },
            "diverged": self.log.diverged,
            "contacts": [str(contact) for contact in self.log.contacts],
            "times": self.log.times.tolist(),
            "joint_names": list(self.result.scene.robot.joint_names),
            "positions": self.log.positions.tolist(),
            "object_placements": [
                [*where.translation.tolist(), *where.quaternion.tolist()] for where in self.log.placements
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

    One world for all stages: the object is a free body on its support, and nothing is attached. The result
    reports slips.

    Args:
        result: A verified sequence that begins with a pick.
        friction: Of the object; that of rubber pads if None.
        limits: Limits beyond which the object counts as slipped.
        options: Step, gains, settling time; a step of a millisecond if None.
    """
    segments = result.require()
    if result.grasp is None:
        raise ModelError(f"object {shown(result.name)} was in the hand from the beginning: there is no grasp")
    log = simulate_phases(
        result.scene,
        result.start,
        [_phase(result, segment) for segment in segments],
        loose=result.name,
        fingers=result.gripper.fingers,
        driven_together=result.gripper.driven_together(result.scene.robot, result.start),
        friction=friction or Friction(),
        options=options or SimulationOptions(dt=STEP),
    )
    return _judged(result, log, limits or HoldLimits())


def _phase(result: PickPlaceResult, segment: Segment) -> Phase:
    grasp = result.grasp
    assert grasp is not None
    presses = segment.stage is Stage.CLOSE or segment.stage.holds
    return Phase(
        name=segment.stage.name,
        reduced=segment.result.problem.reduced,
        trajectory=segment.trajectory,
        rest=segment.rest,
        presses=result.gripper.pressing(grasp.width, grasp.force) if presses else {},
    )


def _judged(result: PickPlaceResult, log: SequenceLog, limits: HoldLimits) -> PickPlaceRollout:
    scene, name = result.scene, result.name
    stages = [result.segments[int(place)].stage for place in log.phases]
    before = [k for k, stage in enumerate(stages) if STAGES.index(stage) < STAGES.index(Stage.CLOSE)]
    held = [k for k, stage in enumerate(stages) if stage.holds]
    tool = result.gripper.tool
    in_hand = [scene.placement_of(tool, log.positions[k]).inverse() * log.placements[k] for k in held]
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
    kept = bool(held) and set(result.gripper.fingers) <= log.touching[held[-1]]
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
        disturbed=PoseError.between(stood, log.placements[before[-1]] if before else stood),
        settled=PoseError.between(planned, in_hand[0] if in_hand else planned),
        final_error=_final_error(result, log),
    )


def _final_error(result: PickPlaceResult, log: SequenceLog) -> PoseError | None:
    place = result.place
    if place is None or log.diverged is not None:
        return None
    frame = result.scene.placement_of(place.frame, result.start)
    off = place.error(log.placements[-1], frame)
    return PoseError(float(np.linalg.norm(off[:3])), float(np.linalg.norm(off[3:])))


def _words(error: PoseError) -> str:
    return f"{error.position * 1e3:.2g} mm and {np.rad2deg(error.rotation):.2g} degrees"
