"""Programs for the controllers of Universal Robots."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from trajopt.files.export.exporter import Exported, ProgramSection
from trajopt.optimise.kinematics.forward import forward_kinematics
from trajopt.problem.requirements import FollowsCurve
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Floats, number
from trajopt.values.documents.document import write_text
from trajopt.values.errors import ShapeError, listed
from trajopt.values.errors.arguments import checked, checked_class
from trajopt.values.placement import Placement, as_rotation_vector
from trajopt.values.printed import in_number
from trajopt.values.trajectory import Trajectory

OTHERS = "csv, ros2, ros2-topic and moveit"
UR_JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
"""The joints of every arm of Universal Robots in URScript order; names may have a prefix."""
CONTROL_RATE = 125.0
"""Command rate that both controller generations accept: the only rate of the CB3, a quarter of the
e-Series' 500 [1/s].
"""
AT_START = 0.01
"""Largest joint distance from the motion's start when the program begins [rad], above the error at rest."""
FASTEST_RATE = 500.0
"""Cycles per second of the e-Series [1/s]."""
STOPPING = 2.0
"""Deceleration of the final `stopj`, when the arm is already at rest [rad/s^2]."""
DEFAULT_ACCELERATION = 1.4
"""Default acceleration of `movej` in Universal Robots' manual, for motions without accelerations
[rad/s^2].
"""
_STANDING = 1e-6
"""A joint that turns less than this on a line is at rest [rad]."""
_RESTING = 1e-3
"""A joint below this share of its peak rate is at rest: rounding decides its rate."""
_CREEPING = 0.01
"""Smallest commanded acceleration; harmless for any arm [rad/s^2]."""
_STILL = 1e-5
"""A joint that moved less than this is still at rest [rad]."""
_SHORTEST_REST = 0.02
"""Shorter rests are not written as waits; a smooth start looks the same [s]."""
ALIGNING = 0.1
"""Speed to the start of a stream, which calibration errors displace after a curve [rad/s]."""
OUTPUTS = 8
TURN_ARM = 0.1
"""Length that makes a turn a distance, for the accuracy of rotations along a curve [m]."""
NEAR = 0.4
"""Largest blend radius, as a share of the shorter line at the corner: below a half they do not overlap."""
_SLOWEST = 1e-3
"""Smallest commanded speed of the tool [m/s]."""
_SAMPLES = 2000
"""Number of samples for finding the corners of `movej`: one every 5 ms in ten seconds."""


@checked_class
@dataclass(frozen=True)
class Servoj:
    """The motion as a stream of positions, one for each cycle of the controller.

    Attributes:
        lookahead_time: Smoothing horizon of the controller, 0.03 to 0.2 [s].
        gain: Stiffness of the tracking, 100 to 2000.
    """

    lookahead_time: float = 0.1
    gain: float = 300.0

    def __post_init__(self) -> None:
        _within("lookahead_time", self.lookahead_time, 0.03, 0.2)
        _within("gain", self.gain, 100.0, 2000.0)

    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        rate = _rate(hz)
        samples = in_ur_order(trajectory).sampled(rate)
        lines = self.lines(samples, rate)
        notes = (
            f"{rate:g} commands per second, positions in rad in the order of URScript",
            f"the last position is held for {self.lookahead_time:g} s until the arm reaches it",
            "loses: velocities and accelerations; the controller follows about "
            f"{self.lookahead_time:g} s behind and rounds the corners of the motion by an unverified "
            "amount: try it at reduced speed and with extra clearance",
            *_STARTING,
        )
        _write(path, [*lines, f"stopj({STOPPING:g})"], samples.positions[0], notes)
        return Exported(path, len(samples.times), len(lines) / rate, notes)

    def lines(self, samples: Trajectory, rate: float) -> list[str]:
        """Return the commands of a sampled motion, held at its end until the arm reaches it."""
        options = f"t={1.0 / rate:.9g}, lookahead_time={self.lookahead_time:g}, gain={self.gain:g}"
        holding = math.ceil(self.lookahead_time * rate)
        # The arm starts at the first sample; each cycle commands the position at its end.
        streamed = [*samples.positions[1:], *[samples.positions[-1]] * holding]
        return [f"servoj({_vector(row)}, {options})" for row in streamed]


def _rate(hz: float | None) -> float:
    rate = CONTROL_RATE if hz is None else number("hz", hz)
    if rate > FASTEST_RATE:
        raise ShapeError("hz", f"controllers take at most {FASTEST_RATE:g} commands per second")
    return rate


@dataclass(frozen=True)
class Movej:
    """A few straight lines in joint space near the motion, each a `movej`, with rounded corners.

    Attributes:
        tolerance: Largest deviation of each joint from the motion [rad].
        blend: Blend radius of the corners at the tool; 0 stops at each corner [m].
    """

    tolerance: float = 0.01
    blend: float = 0.005

    def __post_init__(self) -> None:
        _within("tolerance", self.tolerance, 1e-6, 1.0)
        _within("blend", self.blend, 0.0, 1.0)

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        """Write a motion; a sample rate does not apply."""
        if hz is not None:
            raise ShapeError("hz", "movej has no rate: the controller times each line itself")
        motion = in_ur_order(trajectory)
        times = np.union1d(np.linspace(0.0, motion.duration, _SAMPLES), motion.times)
        positions = motion(times)
        positions[-1] = motion.positions[-1]
        corners = _corners(positions, self.tolerance)
        moved = np.flatnonzero(np.abs(positions - positions[0]).max(axis=1) > _STILL)
        rests = float(times[max(int(moved[0]) - 1, 0)]) if len(moved) else 0.0
        wait = rests if rests > _SHORTEST_REST else 0.0
        lines = [f"sleep({wait:.6f})"] * (wait > 0.0)
        lasting = wait
        peaks = np.abs(motion(times, 2)).max(axis=0)
        for place, (begin, end) in enumerate(pairwise(corners)):
            seconds = times[end] - max(times[begin], wait)
            speed, acceleration = _leg(positions[end] - positions[begin], seconds, peaks)
            radius = self.blend if place < len(corners) - 2 else 0.0
            lines.append(
                f"movej({_vector(positions[end])}, a={acceleration:.6f}, v={speed:.6f}, r={radius:g})"
            )
            lasting += seconds + speed / acceleration
        notes = (
            f"{in_number(corners[1:], 'straight line')} in joint space, "
            f"at most {math.degrees(self.tolerance):.2g} deg from the motion in each joint; "
            f"corners rounded by {self.blend * 1000:g} mm of the tool",
            "each line at the motion's mean speed on it: no joint goes faster than in the motion",
            *((f"waits {wait:.3f} s first, as the motion does",) * (wait > 0.0)),
            "loses: the timing (it takes longer, so do not use it with moving obstacles) and the "
            "verification: lines and rounded corners differ from the motion, so keep extra clearance; "
            "if the tool moves less than two radii between two corners, as when only the wrist turns, "
            "the controller skips a corner",
            *_STARTING,
        )
        _write(path, lines, positions[0], notes)
        return Exported(path, len(corners), float(lasting), notes)


@checked_class
@dataclass(frozen=True)
class UrProgram:
    """A task as one program.

    A curve is a section of `movel` and `movep` at the speed of the motion; other motions are streams of
    `servoj`. While an object is attached, `grip` is on; on a curve, `process` is on.

    Attributes:
        grip: Standard digital output of the gripper, 0 to 7; the program pauses with a message if None.
        process: Standard digital output of the process, 0 to 7; None for none.
        tolerance: Largest distance of the straight lines from a curve along each axis [m].
        blend: Largest blend radius of their corners [m].
    """

    grip: int | None = None
    process: int | None = None
    tolerance: float = 1e-4
    blend: float = 0.001
    stream: Servoj = field(default_factory=Servoj)

    def __post_init__(self) -> None:
        for name, output in (("grip", self.grip), ("process", self.process)):
            if output is not None:
                _within(name, output, 0, OUTPUTS - 1)
        _within("tolerance", self.tolerance, 1e-6, 1.0)
        _within("blend", self.blend, 0.0, 1.0)

    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        return self.stream.write(trajectory, path, hz)

    def write_program(self, sections: Sequence[ProgramSection], path: Path, hz: float | None) -> Exported:
        rate, lines, points, duration = _rate(hz), list[str](), 0, 0.0
        first = next((section for section in sections if _moves_arm(section)), sections[0])
        start = in_ur_order(first.trajectory).positions[0]
        for section in sections:
            of_section, seconds = self._section(section, rate)
            points += len(of_section)
            duration += seconds
            lines += [f"# {_plain(section.title)}", *of_section]
        notes = (
            f"{in_number(sections, 'section')}: curves as movel and movep, each line at the motion's largest "
            "speed there, or slower so that no joint goes faster than in the motion; the others as "
            f"{rate:g} commands servoj per second",
            f"curves in the controller's frame `base`, within {self.tolerance * 1000:g} mm; corners rounded "
            f"by at most {self.blend * 1000:g} mm",
            *self._outputs(),
            "loses: the verification; the controller rounds corners, and follows a stream about "
            f"{self.stream.lookahead_time:g} s behind: try it at reduced speed and with extra clearance",
            *_STARTING,
        )
        _write(path, lines, start, notes)
        return Exported(path, points, duration, notes)

    def _outputs(self) -> Iterator[str]:
        if self.grip is None:
            yield "the program pauses to grip and to release: UrProgram(grip=...) names an output for it"
        else:
            yield f"standard digital output {self.grip} is on while an object is held; fingers only hold"
        if self.process is not None:
            yield f"standard digital output {self.process} is on along curves"

    def _section(self, section: ProgramSection, rate: float) -> tuple[list[str], float]:
        """Return the lines of a section, and how long they take [s]."""
        hand = self._hand(section)
        if not _moves_arm(section):
            lasting = section.trajectory.duration + section.rest
            return [*hand, _sleep(lasting)], lasting
        motion = in_ur_order(section.trajectory)
        if section.curve is None:
            stream = self.stream.lines(motion.sampled(rate), rate)
            lines, lasting = [_approach(motion), *stream, f"stopj({STOPPING:g})"], len(stream) / rate
        else:
            lines, lasting = self._along(section.curve, section.reduced, section.trajectory)
        rest = [_sleep(section.rest)] if section.rest > _SHORTEST_REST else []
        return [*lines, *hand, *rest], lasting + section.rest

    def _hand(self, section: ProgramSection) -> list[str]:
        if not section.gripped and not section.released:
            return []
        if self.grip is not None:
            return [_output(self.grip, bool(section.gripped))]
        words = (
            f"Grip {listed(section.gripped)}" if section.gripped else f"Release {listed(section.released)}"
        )
        return [f'popup("{_plain(words)}, then continue.", title="trajopt", blocking=True)']

    def _along(
        self, curve: FollowsCurve, reduced: ReducedModel, motion: Trajectory
    ) -> tuple[list[str], float]:
        """Return the lines near a curve, from rest to rest, and how long they take [s]."""
        prefix = _prefix(motion.joint_names)
        times = np.linspace(0.0, motion.duration, _SAMPLES)
        rows = motion.ordered(reduced.joint_names)(times)
        tip = Placement(translation=curve.offset)
        tool = forward_kinematics(reduced, curve.frame, rows[0], reference=f"{prefix}tool0")[0] * tip
        seen = forward_kinematics(reduced, curve.frame, rows, reference=f"{prefix}base", offset=curve.offset)
        speeds = np.linalg.norm(np.diff(seen.translation, axis=0), axis=1) / np.diff(times)
        bounds = _bounds(speeds, rows, times)
        fastest = max(float(speeds.max()), _SLOWEST)
        rates = np.abs(np.diff(speeds)) / np.diff(times)[1:]
        acceleration = max(float(rates.max()), _CREEPING)
        shape = np.column_stack((seen.translation, TURN_ARM * seen.rotation.reshape(-1, 9)))
        corners = _corners(shape, self.tolerance)
        poses = [_pose(seen[row]) for row in corners]
        legs = [
            float(np.linalg.norm(seen.translation[b] - seen.translation[a])) for a, b in pairwise(corners)
        ]
        # A line on which the tool only turns has no speed of its own.
        at = [
            max(min(float(speeds[a:b].max()), float(bounds[a:b].min())), _SLOWEST)
            if leg > self.tolerance
            else fastest
            for leg, (a, b) in zip(legs, pairwise(corners), strict=True)
        ]
        options = [f"a={acceleration:.6f}, v={speed:.6f}" for speed in at]
        move = "movep" if len(legs) > 1 else "movel"
        radii = [min(self.blend, NEAR * min(legs)) for legs in pairwise(legs)] + [0.0]
        lines = [
            f"set_tcp({_pose(tool)})",
            f"movel({poses[0]}, {options[0]}, r=0)",
            *([] if self.process is None else [_output(self.process, True)]),
            *(
                f"{move}({pose}, {each}, r={radius:.6f})"
                for pose, each, radius in zip(poses[1:], options, radii, strict=True)
            ),
            *([] if self.process is None else [_output(self.process, False)]),
        ]
        ramps = (at[0] + at[-1]) / 2 / acceleration
        return lines, ramps + sum(leg / speed for leg, speed in zip(legs, at, strict=True))


def _bounds(speeds: Floats, rows: Floats, times: Floats) -> Floats:
    """Return the tool's speeds between samples at which a joint has its largest rate in the motion, (k,)."""
    rates = np.abs(np.diff(rows, axis=0)) / np.diff(times)[:, None]
    shares = (rates / np.maximum(rates.max(axis=0), _STANDING)).max(axis=1)
    return np.divide(speeds, shares, out=np.full(len(shares), np.inf), where=shares > _RESTING)


def _moves_arm(section: ProgramSection) -> bool:
    return any(name.endswith(UR_JOINTS) for name in section.trajectory.joint_names)


def _plain(text: str) -> str:
    """Return a text that ends neither a comment nor a string of URScript."""
    return "".join(each if each.isprintable() and each not in '"\\' else " " for each in text)


def _sleep(seconds: float) -> str:
    return f"sleep({seconds:.6f})"


def _output(number: int, on: bool) -> str:
    return f"set_standard_digital_out({number}, {on})"


def _approach(motion: Trajectory) -> str:
    return f"movej({_vector(motion.positions[0])}, a={DEFAULT_ACCELERATION:g}, v={ALIGNING:g})"


def _pose(at: Placement) -> str:
    return f"p{_vector((*at.translation, *as_rotation_vector(at.rotation)))}"


_STARTING = (
    f"the program ends with a message if a joint is more than {AT_START:g} rad from the motion's start",
    "sent to port 30001 or 30002 it runs; in a Script node of the pendant, call trajopt_motion() after it",
)


def in_ur_order(trajectory: Trajectory) -> Trajectory:
    """Return the motion with its joints in URScript order."""
    names = trajectory.joint_names
    prefix = _prefix(names)
    wanted = tuple(prefix + name for name in UR_JOINTS)
    if set(names) != set(wanted):
        missing, others = [x for x in wanted if x not in names], [x for x in names if x not in wanted]
        what = [f"this motion has no {listed(missing)}"] if missing else []
        what += [f"URScript cannot move {listed(others)}"] if others else []
        if len(missing) == len(wanted):
            what = [f"this motion has {listed(others)}: for other arms there are {OTHERS}"]
        raise ShapeError(
            "trajectory", f"URScript moves the six joints of one UR arm ({listed(wanted)}); {'; '.join(what)}"
        )
    return trajectory.ordered(wanted)


def _prefix(names: Sequence[str]) -> str:
    return next((name.removesuffix(UR_JOINTS[0]) for name in names if name.endswith(UR_JOINTS[0])), "")


def _within(name: str, value: float, lower: float, upper: float) -> None:
    if not lower <= number(name, value) <= upper:
        raise ShapeError(name, f"must be from {lower:g} to {upper:g}, is {value:g}")


def _vector(row: Iterable[float]) -> str:
    return "[" + ", ".join(f"{float(value):.9f}" for value in row) + "]"


def _leg(difference: Floats, seconds: float, peaks: Floats) -> tuple[float, float]:
    """Return speed and acceleration of the leading joint of a straight line, as `movej` takes them.

    The mean speed of the motion on the line, and an acceleration within each joint's peak in the motion.
    """
    moved = np.abs(difference)
    lead = float(moved.max())
    turning = moved > _STANDING
    if not turning.any() or not peaks.any():
        return max(lead / seconds, _STANDING), DEFAULT_ACCELERATION
    allowed = float((peaks[turning] * lead / moved[turning]).min())
    return lead / seconds, max(allowed, _CREEPING)


def _corners(positions: Floats, tolerance: float) -> list[int]:
    """Return the rows between which straight lines stay within a tolerance of all rows (Douglas-Peucker)."""
    ends = (0, len(positions) - 1)
    kept, todo = set(ends), [ends]
    while todo:
        begin, end = todo.pop()
        if end - begin < 2:
            continue
        worst = _farthest(positions[begin : end + 1], tolerance)
        if worst is not None:
            kept.add(begin + worst)
            todo += [(begin, begin + worst), (begin + worst, end)]
    return sorted(kept)


def _farthest(rows: Floats, tolerance: float) -> int | None:
    line = rows[-1] - rows[0]
    square = float(line @ line)
    along = np.clip((rows - rows[0]) @ line / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(rows))
    off = np.abs(rows - rows[0] - along[:, None] * line).max(axis=1)
    worst = int(off.argmax())
    return worst if off[worst] > tolerance else None


def _write(path: Path, moves: Sequence[str], start: Floats, notes: Sequence[str]) -> None:
    lines = [
        *(f"# {note}" for note in notes),
        f"start = {_vector(start)}",
        "now = get_actual_joint_positions()",
        "joint = 0",
        "while joint < 6:",
        f"  if norm(now[joint] - start[joint]) > {AT_START:g}:",
        '    popup("The arm is not at the start of the motion.", title="trajopt", error=True, blocking=True)',
        "    halt",
        "  end",
        "  joint = joint + 1",
        "end",
        *moves,
    ]
    # Comments go inside the program: over a socket, every line outside is a separate program.
    text = "\n".join(["def trajopt_motion():", *(f"  {line}" for line in lines), "end", ""])
    write_text(path, text)
