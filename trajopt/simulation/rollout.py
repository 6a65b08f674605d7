"""Options of a simulation and its outcome."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trajopt.robot.joints import joint_unit
from trajopt.scene.clearances import ContactAllowance
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import tool_frame
from trajopt.values.arrays import Floats, Ints, Value, number
from trajopt.values.errors import ShapeError
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import Placement
from trajopt.values.printed import in_degrees, in_length, in_unit
from trajopt.values.trajectory import Trajectory

SAME_CONTACT = 0.02
"""Contacts of a pair separated by less than this are reported as one [s]."""


@dataclass(frozen=True)
class ContactInterval:
    """A contact of two bodies during an interval.

    Attributes:
        depth: Largest penetration [m]; contacts of MuJoCo yield a little.
        allowance: Name of the allowance that covers the contact; None for a collision.
    """

    pair: tuple[str, str]
    start: float
    end: float
    depth: float
    allowance: str | None = None

    def __str__(self) -> str:
        first, second = self.pair
        allowed = "" if self.allowance is None else f" (allowed: {self.allowance})"
        return (
            f"{first} touches {second} from {self.start:.3f} s to {self.end:.3f} s, "
            f"{self.depth * 1e3:.2f} mm deep{allowed}"
        )


class ContactLog:
    """Merges contacts at single times into intervals."""

    def __init__(self, allowances: Iterable[ContactAllowance], duration: float) -> None:
        self._allowances = tuple(allowances)
        self._duration = duration
        self._open: dict[tuple[str, str], ContactInterval] = {}
        self._closed: list[ContactInterval] = []

    def record(self, time: float, depths: Mapping[tuple[str, str], float]) -> None:
        """Record the contacts at a time after the last one."""
        for pair, depth in depths.items():
            running = self._open.get(pair)
            if running is not None and time - running.end <= SAME_CONTACT:
                self._open[pair] = ContactInterval(pair, running.start, time, max(depth, running.depth))
                continue
            if running is not None:
                self._closed.append(running)
            self._open[pair] = ContactInterval(pair, time, time, depth)

    def contacts(self) -> tuple[ContactInterval, ...]:
        """Return all contacts, sorted by their begin."""
        found = (*self._closed, *self._open.values())
        return tuple(sorted(map(self._judged, found), key=lambda contact: (contact.start, contact.pair)))

    def _judged(self, contact: ContactInterval) -> ContactInterval:
        for allowance in self._allowances:
            early = contact.end <= allowance.first
            late = allowance.last > 0.0 and contact.start >= self._duration - allowance.last
            if frozenset(contact.pair) == allowance.pair and (early or late):
                if contact.depth <= allowance.depth:
                    return ContactInterval(
                        contact.pair, contact.start, contact.end, contact.depth, allowance.name
                    )
        return contact


MOST_CONTACTS = 3
"""Contacts that the summary describes."""


@dataclass(frozen=True, eq=False)
class TrackingError(Value):
    """Differences of planned and simulated positions during the motion."""

    maximum: Floats
    rms: Floats


@dataclass(frozen=True)
class PoseError:
    """Error of the pose of a frame: distance [m] and angle [rad]."""

    position: float
    rotation: float

    @staticmethod
    @checked
    def between(planned: Placement, actual: Placement) -> "PoseError":
        """Return the error of an actual placement."""
        from scipy.spatial.transform import Rotation

        difference = planned.inverse() * actual
        return PoseError(
            float(np.linalg.norm(difference.translation)),
            float(Rotation.from_matrix(difference.rotation).magnitude()),
        )


@dataclass(frozen=True, eq=False)
class Rollout(Value):
    """A simulated execution of a trajectory.

    Attributes:
        trajectory: The reference, joints in the order of the group.
        times: Of the stored samples, shape (k,) [s]; the last ones belong to the settling time.
        positions: Of the group, shape (k, n) [rad | m].
        torques: Of the motors, shape (k, n) [Nm | N].
        tracking_error: Over all steps of the motion, stored or not; without the settling time.
        saturated: Joint -> time for which its motor was at its limit [s]; only those above zero.
        diverged: Time at which the simulation diverged [s]; None if it did not.
        notes: Differences of the MuJoCo model from robot and scene.
        dynamic: Whether motors moved the robot; False if it was placed on its plan.
    """

    reduced: ReducedModel = field(repr=False)
    trajectory: Trajectory
    times: Floats = field(repr=False)
    positions: Floats = field(repr=False)
    velocities: Floats = field(repr=False)
    torques: Floats = field(repr=False)
    tracking_error: TrackingError = field(repr=False)
    contacts: tuple[ContactInterval, ...]
    saturated: Mapping[str, float]
    diverged: float | None = None
    notes: tuple[str, ...] = ()
    dynamic: bool = True

    @property
    def joint_names(self) -> tuple[str, ...]:
        return self.reduced.joint_names

    @property
    def duration(self) -> float:
        return float(self.times[-1])

    @property
    def succeeded(self) -> bool:
        """Whether there was no collision, and the simulation did not diverge."""
        return not self.collisions and self.diverged is None

    @property
    def collisions(self) -> tuple[ContactInterval, ...]:
        """Contacts without an allowance."""
        return tuple(contact for contact in self.contacts if contact.allowance is None)

    @checked
    def final_pose_error(self, frame: str | None = None) -> PoseError:
        """Return the error of a frame, by default the group's tool, at the end."""
        name = tool_frame(self.reduced) if frame is None else frame
        scene, place = self.reduced.scene, self.reduced.all_positions
        planned = scene.placement_of(name, place(self.trajectory(self.trajectory.duration)))
        actual = scene.placement_of(name, place(self.positions[-1]))
        return PoseError.between(planned, actual)

    def summary(self) -> str:
        """Summarise the execution in one sentence."""
        if self.diverged is not None:
            return f"The simulation diverged after {self.diverged:.3f} s and was stopped."
        worst = int(np.argmax(self.tracking_error.maximum))
        unit = joint_unit(self.reduced.model, self.joint_names[worst])
        end = self.final_pose_error()
        parts = [
            f"Simulated {self.trajectory.duration:.2f} s of motion and "
            f"{self.duration - self.trajectory.duration:.2f} s of rest",
            f"largest tracking error {in_unit(self.tracking_error.maximum[worst], unit)} "
            f"({self.joint_names[worst]})",
            f"{tool_frame(self.reduced)} ended {in_length(end.position)} and {in_degrees(end.rotation)} "
            "from the plan",
        ]
        if not self.dynamic:
            parts = [f"Played {self.duration:.2f} s without dynamics, as the robot has no masses"]
        elif self.saturated:
            motors = (f"{name} for {seconds:.3f} s" for name, seconds in self.saturated.items())
            parts.append("motors at their limit: " + ", ".join(motors))
        else:
            parts.append("no motor at its limit")
        parts.extend(map(self._in_words, self.contacts[:MOST_CONTACTS]))
        if len(self.contacts) > MOST_CONTACTS:
            parts.append(f"{len(self.contacts) - MOST_CONTACTS} more contacts")
        elif not self.contacts:
            parts.append("no contact")
        return "; ".join(parts) + "."

    def _in_words(self, contact: ContactInterval) -> str:
        after = contact.start > self.trajectory.duration
        return f"{contact}{', at rest after the motion' if after else ''}"

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        end = self.final_pose_error() if self.diverged is None else None
        return {
            "robot": self.reduced.scene.robot.name,
            "group": self.reduced.group,
            "joint_names": list(self.joint_names),
            "duration": self.duration,
            "times": self.times.tolist(),
            "positions": self.positions.tolist(),
            "velocities": self.velocities.tolist(),
            "torques": self.torques.tolist(),
            "tracking_error": {
                "maximum": self.tracking_error.maximum.tolist(),
                "rms": self.tracking_error.rms.tolist(),
            },
            "final_pose_error": end
            and {
                "frame": tool_frame(self.reduced),
                "position": end.position,
                "rotation": end.rotation,
            },
            "contacts": [{**vars(contact), "pair": list(contact.pair)} for contact in self.contacts],
            "saturated": dict(self.saturated),
            "diverged": self.diverged,
            "notes": list(self.notes),
            "dynamic": self.dynamic,
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class Phase:
    """One motion of a sequence.

    Attributes:
        rest: Time for which its end is held [s].
        presses: Joint of the fingers -> force or torque instead of position control [N | Nm]. If the phase
            moves the joint, it grows from zero during the rest.
    """

    name: str
    reduced: ReducedModel
    trajectory: Trajectory
    rest: float
    presses: Mapping[str, float]

    @property
    def duration(self) -> float:
        return self.trajectory.duration + self.rest


@dataclass(frozen=True, eq=False, kw_only=True)
class SequenceLog(Value):
    """The record of a simulated sequence.

    Attributes:
        reduced: The joints of all phases, in the initial scene.
        phases: Index of the phase at each sample, shape (k,).
        positions: Of all joints of the robot, shape (k, joints) [rad | m].
        placements: Loose object -> its placements in the world, one per sample.
        touching: Loose object -> the bodies in contact with it, one set per sample.
        deepest: Largest penetration of a loose object; contacts yield a little [m].
        contacts: Other contacts that the scene does not allow.
        saturated: As in `Rollout`, like `diverged` and `notes`.
    """

    reduced: ReducedModel
    loose: tuple[str, ...]
    times: Floats
    phases: Ints
    positions: Floats
    placements: Mapping[str, tuple[Placement, ...]]
    touching: Mapping[str, tuple[frozenset[str], ...]]
    deepest: float
    contacts: tuple[ContactInterval, ...]
    saturated: Mapping[str, float]
    diverged: float | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class SimulationOptions:
    """Options of `simulate`.

    Attributes:
        dt: Time step of the physics and of the controller [s].
        natural_frequency: Of the tracking error under the controller [rad/s]: an error decays in a few
            1 / natural_frequency. Stiff industrial arms reach 50 rad/s.
        damping_ratio: Of the tracking error; 1 is critical damping.
        settling_time: Time for which the last position is held after the motion [s].
        sample_period: Time between stored samples, rounded to steps [s].
    """

    dt: float = 0.002
    natural_frequency: float = 50.0
    damping_ratio: float = 1.0
    settling_time: float = 0.3
    sample_period: float = 0.01

    def __post_init__(self) -> None:
        for name in ("dt", "natural_frequency", "damping_ratio", "sample_period"):
            if number(name, getattr(self, name)) <= 0.0:
                raise ShapeError(name, f"must be positive, is {getattr(self, name):g}")
        if number("settling_time", self.settling_time) < 0.0:
            raise ShapeError("settling_time", f"must not be negative, is {self.settling_time:g} s")
        if self.dt * self.natural_frequency > 0.5:
            raise ShapeError(
                "natural_frequency",
                f"{self.natural_frequency:g} rad/s is too high for steps of {self.dt:g} s; "
                "their product must not exceed 0.5",
            )


@dataclass(frozen=True)
class Friction:
    """Friction of a loose object.

    Attributes:
        pads: Coefficient between object and fingers.
        torsional: Coefficient against turning about the normal, for all contacts: about the radius of the
            contact patch [m].
    """

    pads: float = 0.8
    others: float = 0.5
    torsional: float = 0.005

    def __post_init__(self) -> None:
        for name in ("pads", "others", "torsional"):
            if number(name, getattr(self, name)) < 0.0:
                raise ShapeError(name, f"must not be negative, is {getattr(self, name):g}")
