"""Runs as MCAP logs, read back by the official reader."""

import json
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.files.log.read_mcap import read, seconds
from trajopt.driving import (
    ActionOutcome,
    Decision,
    EventKind,
    Guard,
    IdealExecutor,
    Logbook,
    Recording,
    read_recording,
    write_mcap,
    write_recording,
)
from trajopt.values.errors import ProblemError

pytest.importorskip("mcap")
GROUP, CYCLE = "panda_arm", 0.02
WALL = to.Box(0.3, 0.02, 0.4), to.placement((0.31, -0.25, 0.6), rpy=(0.0, 0.0, -0.7))


@pytest.fixture(scope="module")
def guarded() -> Recording:
    """A policy that turns the first joint through a wall, which appears during the run."""
    robot = to.load("panda")
    scene, joints = to.Scene(robot), robot.group(GROUP).joints
    arm = IdealExecutor(joints, robot.positions("ready")[robot.index(joints)])
    guard, logbook = Guard(scene, GROUP, arm), Logbook()
    for seen in (scene, scene.add("wall", *WALL)):
        guard.see(seen)
        logbook.look(guard)
        actions = np.tile(arm.state().positions, (50, 1))
        actions[:, 0] -= 0.5 * np.arange(1, 51) / 50.0
        logbook.note(guard.act(actions, rate=50.0))
        for _ in range(20):
            guard.tick()
            arm.advance(CYCLE)
            logbook.look(guard)
    logbook.note(guard.act(np.full((3, 7), np.nan), rate=50.0))
    logbook.look(guard)
    return logbook.recording


def test_a_guarded_run_has_states_scenes_events_and_decisions(guarded: Recording, tmp_path: Path) -> None:
    write_mcap(tmp_path / "run.mcap", guarded)
    topics = read(tmp_path / "run.mcap")
    assert set(topics) == {"/joint_states", "/tf", "/scene", "/committed", "/events", "/decisions"}
    states = topics["/joint_states"]
    np.testing.assert_allclose([time for time, _ in states], guarded.times, atol=1e-9)
    rows = [[joint["position"] for joint in message["joints"]] for _, message in states]
    np.testing.assert_array_equal(rows, guarded.positions)
    assert [time for time, _ in topics["/tf"]] == [time for time, _ in states]
    seen = [{each["id"] for each in message["entities"]} for _, message in topics["/scene"]]
    assert ["wall" in each for each in seen] == [False, True]
    events = [(message["level"], message["message"]) for _, message in topics["/events"]]
    assert [words for _, words in events] == [
        f"{each.kind.value}: {each.words}" if each.words else each.kind.value for each in guarded.events
    ]
    assert {level for level, words in events if words.startswith(EventKind.STOPPING.value)} == {3}
    decisions = [message for _, message in topics["/decisions"]]
    assert [each["outcome"] for each in decisions] == [
        each.decision.outcome.name for each in guarded.decisions
    ]
    assert decisions[0]["unchanged"] > 0 and np.shape(decisions[0]["commanded"]) == (50, 7)
    assert decisions[-1]["outcome"] == ActionOutcome.STOPPED.name and "actions" in decisions[-1]["reason"]
    begun = [seconds(message["begin"]) for _, message in topics["/committed"]]
    np.testing.assert_allclose(begun, [each.begin for each in guarded.committed], atol=1e-9)


def test_times_are_those_of_the_clock_after_an_origin(guarded: Recording, tmp_path: Path) -> None:
    write_mcap(tmp_path / "run.mcap", guarded, origin=1.7e9)
    for messages in read(tmp_path / "run.mcap").values():
        assert all(1.7e9 <= time < 1.7e9 + 10.0 for time, _ in messages)
    with pytest.raises(ProblemError, match="not negative"):
        write_mcap(tmp_path / "late.mcap", guarded, origin=-100.0)
    assert not (tmp_path / "late.mcap").exists()


def test_decisions_survive_a_recording_on_disk(guarded: Recording, tmp_path: Path) -> None:
    write_recording(tmp_path / "run.json", guarded)
    again = read_recording(tmp_path / "run.json", guarded.robot)
    assert len(again.decisions) == 3
    for one, other in zip(guarded.decisions, again.decisions, strict=True):
        assert (one.time, one.decision.outcome, one.decision.reason) == (
            other.time, other.decision.outcome, other.decision.reason,
        )  # fmt: skip
        np.testing.assert_array_equal(one.decision.commanded, other.decision.commanded.reshape(-1, 7))


def test_a_recording_without_decisions_is_read(guarded: Recording, tmp_path: Path) -> None:
    """Files that were written before guards were recorded have none."""
    write_recording(path := tmp_path / "run.json", guarded)
    document = json.loads(path.read_text())
    del document["decisions"]
    path.write_text(json.dumps(document))
    assert read_recording(path, guarded.robot).decisions == ()


def test_a_decision_needs_a_clock() -> None:
    decision = Decision(ActionOutcome.STOPPED, "none came", 0, np.zeros((0, 7)))
    with pytest.raises(ProblemError, match="call look before note"):
        Logbook().note(decision)
