"""A recorded run as a log, for the viewers of Foxglove, Rerun and others."""

from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np

from trajopt.driving.events import Event, EventKind
from trajopt.driving.recording import RecordedDecision, RecordedMotion, Recording
from trajopt.files.log.logs import (
    COMMITTED,
    DECISIONS,
    EVENTS,
    PLAN,
    Json,
    Log,
    McapLog,
    RerunLog,
    Topic,
    stamp,
)
from trajopt.files.log.robot_messages import RobotMessages, motion, write_joint_states
from trajopt.values.arrays import number
from trajopt.values.errors.arguments import checked

INFO, WARNING, ERROR = 2, 3, 4
"""Levels of Foxglove's log messages."""
LEVELS = {
    **dict.fromkeys((EventKind.OFF_TRACK, EventKind.FAULT, EventKind.UNPROVEN_STOP), ERROR),
    **dict.fromkeys(
        (
            EventKind.OUTSIDE_LIMITS,
            EventKind.SLOWING,
            EventKind.STOPPING,
            EventKind.NO_PLAN,
            EventKind.MISSED_DEADLINE,
            EventKind.REJECTED,
            EventKind.STALE,
        ),
        WARNING,
    ),
}
"""Levels of events; others are information."""


@checked
def write_mcap(path: Path | str, recording: Recording, *, origin: float = 0.0) -> None:
    """Write a recorded run as MCAP.

    Topics and messages: docs/execution.md#logs.

    Args:
        origin: Time of the log at time 0 of the executor's clock, such as its time since 1970 [s].

    Raises:
        MissingExtra: Without the package `mcap`.
        ProblemError: If a time of the log would be negative.
    """
    _write(McapLog(), path, recording, origin)


@checked
def write_rerun(path: Path | str, recording: Recording, *, origin: float = 0.0) -> None:
    """Write a recorded run for Rerun's viewer (.rrd): `rerun FILE` shows it.

    Entities: /world and the topics of `write_mcap`.

    Args:
        origin: As for `write_mcap`.

    Raises:
        MissingExtra: Without the package `rerun-sdk`.
        ProblemError: If a time of the log would be negative.
    """
    _write(RerunLog(), path, recording, origin)


def _write(log: Log, path: Path | str, recording: Recording, origin: float) -> None:
    zero = number("origin", origin)
    times = recording.times + zero
    write_joint_states(log, recording.joint_names, times, recording.positions[:, None])
    _write_worlds(log, recording, zero)
    _write_motions(log, PLAN, recording.intended, zero)
    _write_motions(log, COMMITTED, recording.committed, zero)
    for event in recording.events:
        log.add(EVENTS, event.time + zero, _event(event, zero))
    for each in recording.decisions:
        log.add(DECISIONS, each.time + zero, _decision(each, recording.joint_names, zero))
    log.save(path)


def _write_worlds(log: Log, recording: Recording, zero: float) -> None:
    times = recording.times
    changes = [int(np.searchsorted(times, each.since)) for each in recording.sightings[1:]]
    ends = [0, *changes, len(times)]
    for sighting, (begin, end) in zip(recording.sightings, pairwise(ends), strict=True):
        if begin < end:
            rows = slice(begin, end)
            messages = RobotMessages(recording.reduced(sighting))
            clock = np.maximum(times[rows] - sighting.world.stamp, 0.0)
            messages.write(log, times[rows] + zero, recording.positions[rows], clock)


def _write_motions(log: Log, topic: Topic, motions: Iterable[RecordedMotion], zero: float) -> None:
    for each in motions:
        if each.trajectory is not None:
            log.add(topic, each.since + zero, motion(each.begin + zero, each.trajectory))


def _event(event: Event, zero: float) -> Json:
    return {
        "timestamp": stamp(event.time + zero),
        "level": LEVELS.get(event.kind, INFO),
        "message": ": ".join(filter(None, (event.kind.value, event.message))),
        "name": "trajopt.driving",
        "file": "",
        "line": 0,
    }


def _decision(recorded: RecordedDecision, names: tuple[str, ...], zero: float) -> Json:
    decision = recorded.decision
    return {
        "timestamp": stamp(recorded.time + zero),
        "outcome": decision.outcome.name,
        "reason": decision.reason,
        "unchanged": decision.unchanged,
        "joint_names": list(names),
        "commanded": decision.commanded.tolist(),
    }
