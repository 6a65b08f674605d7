"""Logbook and recordings: sampled after each cycle, written and read."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.driving.test_servo import PERIOD, asked, led
from trajopt.driving import (
    EventKind,
    Logbook,
    RecordedMoment,
    RecordedMotion,
    Recording,
    Supervisor,
    Surprise,
    Surprises,
    Twist,
    read_recording,
    run,
    write_recording,
)
from trajopt.robot.bodies import MeshPolicy
from trajopt.scene.track import Timing
from trajopt.values.errors import FileFormatError, ProblemError, ShapeError
from trajopt.values.shapes.mesh import Mesh

CRATE = Surprise(
    name="crate", at=0.1, placement=to.placement((0.44, 0.15, 0.25)), shape=to.Box(0.1, 0.1, 0.1)
)


def named() -> to.Problem:
    try:
        return to.named_problem("cup_past_pillar")
    except to.MissingExtra as error:
        pytest.skip(str(error))


@pytest.fixture(scope="module")
def watched() -> tuple[Recording, list[tuple[RecordedMoment, np.ndarray, list[str]]]]:
    """A run in which a crate appears, and what was true in each cycle: where to, and what had happened."""
    logbook, seen = Logbook(), list[tuple[RecordedMoment, np.ndarray, list[str]]]()

    def watch(supervisor: Supervisor) -> None:
        logbook.look(supervisor)
        ahead = supervisor.committed(supervisor.executor.now() + 0.05)[0]
        columns = [
            supervisor.executor.joint_names.index(name) for name in supervisor.problem.reduced.joint_names
        ]
        seen.append((logbook.moment, ahead[columns], [str(event) for event in supervisor.events]))

    done = run(named(), surprises=Surprises(objects=(CRATE,)), watch=watch)
    assert done.reached and done.count(EventKind.REPLANNED) == 1
    return logbook.recording, seen


def alike(one: to.Trajectory | None, other: to.Trajectory | None) -> bool:
    if one is None or other is None:
        return one is other
    return one.joint_names == other.joint_names and all(
        np.allclose(first, second, atol=1e-12)
        for first, second in ((one.times, other.times), (one.positions, other.positions))
    )


def same(one: RecordedMoment, other: RecordedMoment) -> None:
    assert one.time == other.time and one.events == other.events
    assert np.array_equal(one.positions, other.positions)
    assert alike(one.stop, other.stop) and alike(one.plan, other.plan)
    assert list(one.sighting.world.scene.objects) == list(other.sighting.world.scene.objects)


def test_recorded_states_equal_the_original_ones(
    watched: tuple[Recording, list[tuple[RecordedMoment, np.ndarray, list[str]]]],
) -> None:
    recording, seen = watched
    assert len(recording.times) == len(seen) > 40
    for moment, ahead, events in seen:
        then = recording.at(moment.time)
        same(then, moment)
        assert [str(event) for event in then.events] == events
        if then.stop is not None and moment.time + 0.05 <= moment.time + then.stop.duration:
            np.testing.assert_allclose(then.stop(0.05), ahead, atol=1e-9)
            assert np.abs(then.stop(then.stop.duration, 1)).max() < 1e-6, "it ends at rest"
        known = {"crate"} if moment.time >= 0.1 else set()
        assert {"crate"} & set(then.sighting.world.scene.objects) == known
    first, last = recording.at(-1.0), recording.at(99.0)
    assert first.time == 0.0 and last.time == recording.times[-1]
    assert first.plan is not None and first.stop is not None and first.stop.duration < first.plan.duration
    assert last.plan is None and last.stop is None and last.events[-1].kind is EventKind.REACHED


def test_recorded_plan_is_replaced_at_the_right_time(
    watched: tuple[Recording, list[tuple[RecordedMoment, np.ndarray, list[str]]]],
) -> None:
    recording, _ = watched
    before, after = recording.at(0.05).plan, recording.at(0.15).plan
    assert before is not None and after is not None
    assert after.duration > before.duration
    halfway = recording.at(0.5 * float(recording.times[10] + recording.times[11]))
    between = 0.5 * (recording.positions[10] + recording.positions[11])
    np.testing.assert_allclose(halfway.positions, between, atol=1e-12)


def test_recording_survives_a_file(
    watched: tuple[Recording, list[tuple[RecordedMoment, np.ndarray, list[str]]]], tmp_path: Path
) -> None:
    recording, _ = watched
    write_recording(tmp_path / "run.json", recording, {"problem": "cup_past_pillar"})
    again = read_recording(tmp_path / "run.json", recording.robot)
    for time in np.linspace(0.0, recording.duration, 20).tolist():
        same(again.at(time), recording.at(time))
    one, other = (each.sightings[-1].world.scene for each in (recording, again))
    assert (one.margin, one.allowed, one.clearances) == (other.margin, other.allowed, other.clearances)
    assert one.object("crate").parts[0][0] == other.object("crate").parts[0][0]
    document = json.loads((tmp_path / "run.json").read_text())
    assert (document["format"], document["version"]) == ("trajopt recording", 1)
    assert document["robot"]["source"] == {"problem": "cup_past_pillar"}


def test_reads_files_with_the_class_names_before_version_0_2(
    watched: tuple[Recording, list[tuple[RecordedMoment, np.ndarray, list[str]]]], tmp_path: Path
) -> None:
    recording, _ = watched
    write_recording(tmp_path / "run.json", recording)
    text = (tmp_path / "run.json").read_text()
    former = text.replace('"RecordedMotion"', '"TimedMotion"').replace('"EventKind"', '"Kind"')
    assert former.count('"TimedMotion"') > 2 and former.count('"Kind"') > 2
    (tmp_path / "former.json").write_text(former)
    again = read_recording(tmp_path / "former.json", recording.robot)
    same(again.at(0.15), recording.at(0.15))


def test_every_kind_of_object_is_written_and_read(tmp_path: Path) -> None:
    problem = asked("panda")
    track = to.Track.constant_velocity(to.placement((0.9, 0.0, 0.4)), (-0.1, 0.0, 0.0), end=5.0)
    corners = np.array([(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)])
    shapes = (
        to.Sphere(0.05), to.Cylinder(0.05, 0.1), to.Capsule(0.05, 0.1), to.Cone(0.05, 0.1), to.Plane(),
        to.convex(corners), Mesh(corners, np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])),
    )  # fmt: skip
    scene = problem.scene.add("ball", to.Sphere(0.05), motion=to.Prediction(track, (0.01, 0.02, 0.0), 4.0))
    for number, shape in enumerate(shapes):
        where, kept = to.placement((5.0, number, -0.3)), MeshPolicy(exact=True)
        scene = scene.add(f"thing {number}", shape, where, appears=0.5, meshes=kept)
    scene = scene.with_tool("tip", "panda_hand", to.placement((0.0, 0.0, 0.1)))
    scene = scene.add("cup", to.Cylinder(0.03, 0.1), frame="tip", touch_links=["panda_hand"], mass=0.2)
    scene = scene.allow("thing 0", "thing 1").with_clearance(0.001, "cup", "ball").with_margin(world=0.03)
    scene = scene.allow_contact("cup on a ball", "cup", "ball", first=0.2)
    arm, servo = led(replace(problem, scene=scene))
    logbook = Logbook()
    servo.command(Twist((0.0, 0.1, 0.0)))
    servo.tick()
    logbook.look(servo)
    assert logbook.moment.plan is None and logbook.moment.stop is not None
    write_recording(tmp_path / "servo.json", logbook.recording)
    again = read_recording(tmp_path / "servo.json", scene.robot).sightings[0].world.scene
    assert again.objects.keys() == scene.objects.keys() and again.tools.keys() == scene.tools.keys()
    for name, item in scene.objects.items():
        other = again.object(name)
        assert (other.frame, other.touch_links, other.mass) == (item.frame, item.touch_links, item.mass)
        assert other.placement == item.placement
        assert other.timing.appears == item.timing.appears
        for (shape, where), (read, there) in zip(item.parts, other.parts, strict=True):
            assert where == there and type(shape) is type(read)
            if hasattr(shape, "vertices"):
                assert np.array_equal(shape.vertices, read.vertices)  # pyright: ignore
            else:
                assert shape == read
    motion, read = (each.object("ball").timing.motion for each in (scene, again))
    assert motion is not None and read is not None and read.error == motion.error and read.until == 4.0
    assert read.track.at(1.5) == motion.track.at(1.5)
    assert again.allowed == scene.allowed and again.clearances == scene.clearances
    assert again.kind_margins == scene.kind_margins and again.allowances == scene.allowances
    del arm


def test_values_are_written_as_in_bundles(
    watched: tuple[Recording, list[tuple[RecordedMoment, np.ndarray, list[str]]]], tmp_path: Path
) -> None:
    """One form for both, and both are checked as they are read: faces between no vertices end a process."""
    recording, path = watched[0], tmp_path / "run.json"
    write_recording(path, recording)
    document = json.loads(path.read_text())
    assert document["times"] == {"array": recording.times.tolist(), "type": "float64"}
    crate = document["sightings"][-1]["scene"]["objects"]["map"]["crate"]
    assert crate["kind"] == "SceneObject" and crate["parts"][0][0]["kind"] == "Box"
    corners = {"array": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "type": "float64"}
    faces = {"array": [[0, 1, 99]], "type": "int32"}
    crate["parts"][0][0] = {"kind": "Convex", "vertices": corners, "faces": faces}
    path.write_text(json.dumps(document))
    with pytest.raises(FileFormatError, match=r"crate.parts\[0\]\[0\]: faces: refer to vertices"):
        read_recording(path, recording.robot)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "other"}, "is not a recording"),
        ({"version": 2}, "is 2, must be 1"),
        ({"times": {"array": [0.0, 0.0], "type": "float64"}}, "times"),
        ({"times": {"array": [[0.0], "x"], "type": "float64"}}, "times: is not an array"),
        ({"events": [{"kind": "Event", "time": 0.0}]}, r"events\[0\]: lacks kind"),
        ({"events": [{"kind": "Evnt"}]}, "'Evnt' is not among"),
        ({"events": [{"kind": "Event", "wordz": ""}]}, "did you mean 'words'"),
        ({"events": [{"kind": "EventKind", "is": "DONE"}]}, "must be one of .* is 'DONE'"),
        ({"committed": [{"kind": "RecordedMotion", "sinze": 0}]}, "did you mean 'since'"),
        ({"sightings": []}, "sightings must have at least one element"),
        ({"robot": {"name": "ur5", "joints": ["a"]}}, "whose joints differ from those"),
        ({"more": 1}, "unknown key 'more'"),
    ],
)
def test_errors_in_a_file_name_their_place(tmp_path: Path, change: dict[str, object], message: str) -> None:
    arm, servo = led(asked("panda"))
    logbook = Logbook()
    for _ in range(2):
        servo.tick()
        logbook.look(servo)
        arm.advance(PERIOD)
    path = tmp_path / "servo.json"
    write_recording(path, logbook.recording)
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(FileFormatError, match=message):
        read_recording(path, servo.scene.robot)


def test_logbook_records_one_driver() -> None:
    logbook = Logbook()
    with pytest.raises(ProblemError, match="the logbook has no sample"):
        logbook.recording  # noqa: B018
    logbook.look(led(asked("panda"))[1])
    with pytest.raises(ProblemError, match="records one driver"):
        logbook.look(led(asked("panda"))[1])


def test_recording_checks_its_fields(
    watched: tuple[Recording, list[tuple[RecordedMoment, np.ndarray, list[str]]]],
) -> None:
    recording, _ = watched
    with pytest.raises(ShapeError, match="positions"):
        replace(recording, positions=recording.positions[1:])
    with pytest.raises(ProblemError, match="intended must be sorted by time"):
        replace(
            recording,
            intended=[RecordedMotion(since=since, begin=0.0, trajectory=None) for since in (1.0, 0.0)],
        )
    assert isinstance(recording.sightings[0].world.scene.objects["pillar"].timing, Timing)
