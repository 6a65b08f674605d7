"""Runs in simulation: the moving robot touches nothing among surprises, as proven."""

from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from benchmarks.driving import __main__ as driving
from benchmarks.driving.__main__ import SUPERVISOR, WAYS, keys
from benchmarks.driving.drawing import TOLERANCE, Part, drawn
from benchmarks.driving.report import failed, page
from trajopt.driving import (
    EventKind,
    Fault,
    FaultKind,
    Sensors,
    Surprise,
    Surprises,
    random_surprise,
    read_surprises,
    run,
    undisturbed,
)
from trajopt.timing.time_scaling import StopsAlong
from trajopt.values.errors import FileFormatError, ObjectNotFound
from trajopt.verify import VerifyOptions

PROBLEMS = ("cup_past_pillar", "bookshelf_ur5", "past_pillar_xarm7")
RUNS = 500
"""Random surprises in the slow test, shared among the problems."""


def named(name: str) -> to.Problem:
    try:
        return to.named_problem(name)
    except to.MissingExtra as error:
        pytest.skip(str(error))


def check(problem: to.Problem, seed: int, motion: to.Trajectory) -> None:
    done = run(problem, surprises=random_surprise(problem, motion, seed))
    assert done.contacts_at_fault == (), f"{problem.name} {seed}"
    assert done.count(EventKind.UNPROVEN_STOP) == 0, f"{problem.name} {seed}"
    assert done.clearance_proven is not None
    # Both are proven bounds, each as near to the true clearance as the judge's resolution.
    assert done.clearance_measured >= done.clearance_proven - VerifyOptions().resolution, (
        f"{problem.name} {seed}"
    )
    assert done.clearance_proven > 0.0


@pytest.mark.parametrize("name", PROBLEMS)
def test_random_surprises(name: str) -> None:
    problem = named(name)
    motion = undisturbed(problem)
    for seed in range(4):
        check(problem, seed, motion)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", PROBLEMS)
def test_many_random_surprises(name: str) -> None:
    problem = named(name)
    motion = undisturbed(problem)
    for seed in range(100, 100 + RUNS // len(PROBLEMS)):
        check(problem, seed, motion)


def test_a_run_without_surprises_is_the_plan() -> None:
    problem = named("cup_past_pillar")
    done = run(problem)
    assert [event.kind for event in done.events if event.kind is not EventKind.WORLD_CHANGED] == [
        EventKind.STARTED, EventKind.REACHED,
    ]  # fmt: skip
    assert done.reached and done.contacts == ()
    told = done.as_dict()
    assert set(told) == {
        "reached", "duration", "contacts", "contacts_at_fault", "clearance_measured", "clearance_proven",
        "stops", "replans", "latencies", "missed_deadlines", "events",
    }  # fmt: skip
    assert told["latencies"]["prove"].keys() == {"p50", "p99", "p99.9", "max"}  # pyright: ignore


def test_runs_are_deterministic() -> None:
    problem = named("cup_past_pillar")
    surprises = random_surprise(problem, undisturbed(problem), 3)
    first, second = (run(problem, surprises=surprises) for _ in range(2))
    assert first.events == second.events
    assert np.array_equal(first.measured.positions, second.measured.positions)


def test_robot_resumes_when_the_blocking_object_is_removed() -> None:
    """The gap is closed by a slab; it is moved away while the robot waits."""
    problem = named("cup_past_pillar")
    closed = problem.scene.add("slab", to.Box(0.5, 0.04, 1.2), to.placement((0.5, 0.12, 0.6)))
    away = Surprises(objects=(Surprise(name="slab", at=1.0, placement=to.placement((0.5, 2.0, 0.6))),))
    done = run(to.Problem(**{**fields(problem), "scene": closed}), surprises=away)
    assert done.reached and done.duration > 1.0
    assert done.contacts == ()


def fields(problem: to.Problem) -> dict[str, object]:
    names = ("start", "goal", "group", "constraints", "name")
    return {name: getattr(problem, name) for name in names}


def test_a_stuck_joint_ends_a_run() -> None:
    problem = named("cup_past_pillar")
    stuck = Fault(kind=FaultKind.STUCK, begin=0.2, end=9.0, joint="panda_joint1")
    done = run(problem, surprises=Surprises(faults=(stuck,)))
    assert not done.reached and done.clearance_proven is None
    assert done.count(EventKind.OFF_TRACK) == 1


@pytest.mark.parametrize("at", [0.02, 0.06, 0.3])
def test_changes_are_seen_with_the_delay_of_the_sensors(at: float) -> None:
    """A time and a delay do not add up exactly: (0.06 + 0.01) - 0.01 is less than 0.06."""
    problem = named("past_pillar_xarm7")
    far = Surprise(
        name="box",
        at=at,
        placement=to.placement((5.0, 0.0, 0.0)),
        shape=to.Box(0.1, 0.1, 0.1),
        leaves=at + 0.1,
    )
    told: list[bool] = []
    late = Surprises(objects=(far,), sensors=Sensors(delay=0.01))
    run(problem, surprises=late, watch=lambda supervisor: told.append("box" in supervisor.scene.objects))
    assert any(told) and not told[-1]


def test_stated_noise_is_not_a_fault() -> None:
    """The robot tracks to within 0.8 mrad and is measured to within 0.6: it may be seen 1.4 mrad off."""
    problem = named("past_pillar_xarm7")
    noisy = run(problem, surprises=Surprises(sensors=Sensors(delay=0.01, noise=1e-4, seed=16)))
    assert noisy.reached and noisy.count(EventKind.OFF_TRACK) == 0
    unsaid = run(problem, surprises=Surprises(sensors=Sensors(delay=0.01, noise=3e-3, stated=0.0, seed=3)))
    assert not unsaid.reached and unsaid.count(EventKind.OFF_TRACK) == 1


@pytest.mark.parametrize("seed", [14, 24])
def test_random_box_keeps_clear_of_attached_objects(seed: int) -> None:
    problem = named("level_tray_ur5")
    motion = undisturbed(problem)
    (box,) = random_surprise(problem, motion, seed).objects
    seen = Surprises(objects=(box,)).seen(problem.scene, box.at).with_clearance(0.02, "tray", "surprise")
    reduced = to.Problem(**{**fields(problem), "scene": seen, "constraints": ()}).reduced
    for at in (0.0, min(box.at, motion.duration)):
        near = to.examine(reduced, motion(at)).collisions
        assert not any({"tray", "surprise"} == {pair.first, pair.second} for pair in near)


@pytest.mark.parametrize("part", Part)
def test_every_part_of_the_driving_benchmark_is_drawn(part: Part) -> None:
    problem = named("past_pillar_xarm7")
    motion, asked = undisturbed(problem), list[float]()

    def motion_within(tolerance: float) -> to.Trajectory:
        asked.append(tolerance)
        return motion

    for seed in range(5):
        run = drawn(problem, motion_within, part, seed)
        assert run.part is part
        # What is driven keeps farther away where less is known of where the robot is.
        assert asked.pop() == pytest.approx(TOLERANCE + run.surprises.sensors.error, abs=1e-12)


def test_seed_from_a_blocked_motion_is_bent_around_the_obstacle() -> None:
    """What the try decided on is the duration too, which is no joint."""
    problem = named("level_tray_ur5")
    late = drawn(problem, lambda tolerance: undisturbed(problem, tolerance=tolerance), Part.LATE, 186)
    done = run(problem, surprises=late.surprises)
    assert done.reached and not done.contacts


def test_random_box_keeps_clear_of_a_robot_that_began_late() -> None:
    """A supervisor plans a tenth of a second ahead: so far behind the motion's clock the robot is."""
    problem = named("cage_ur5")
    motion = undisturbed(problem)
    (box,) = random_surprise(problem, motion, 222).objects
    seen = Surprises(objects=(box,)).seen(problem.scene, box.at)
    reduced = to.Problem(**{**fields(problem), "scene": seen}).reduced
    for behind in np.arange(0.0, 0.1, 0.01):
        near = to.examine(reduced, motion(max(box.at - behind, 0.0))).collisions
        assert not any("surprise" in (pair.first, pair.second) for pair in near), f"{behind:.2f} s behind"


def test_shares_of_the_driving_benchmark_partition_it() -> None:
    whole = list(keys(("one", "two"), 90, 30, 20))
    shares = [list(keys(("one", "two"), 90, 30, 20, share=(own, 3))) for own in (1, 2, 3)]
    assert sorted(map(str, whole)) == sorted(str(key) for share in shares for key in share)
    assert {part for share in shares for _, _, part, _ in share} == set(Part)
    assert min(map(len, shares)) > 0


def test_an_exception_in_a_run_is_a_row_that_names_it_and_counts_as_an_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def breaks(*_: object, **__: object) -> None:
        raise ValueError("broken in the middle")

    monkeypatch.setattr(driving, "driven_by", breaks)
    key = f"cup_past_pillar 0 {Part.BEYOND.value} {SUPERVISOR}"
    row = driving.driven("cup_past_pillar", 0, Part.BEYOND, WAYS[SUPERVISOR], key)
    assert failed(row) and "ValueError: broken in the middle (test_run.py, line" in str(row["error"])
    text = page([row], ("cup_past_pillar",))
    assert "1 runs ended with an exception" in text and f"`{key}`: ValueError" in text


def test_random_box_keeps_clear_of_the_way_to_rest() -> None:
    problem = named("past_pillar_xarm7")
    motion = undisturbed(problem)
    for seed in range(8):
        (box,) = random_surprise(problem, motion, seed).objects
        alone = to.Scene(problem.scene.robot).add("surprise", box.shape, box.placement)
        reduced = to.Problem(**{**fields(problem), "scene": alone.with_clearance(world=0.019)}).reduced
        rest = StopsAlong(motion, problem.limits).earliest(box.at).trajectory
        for time in np.linspace(0.0, rest.duration, 100):
            near = to.examine(reduced, rest(time)).collisions
            assert not any("surprise" in (pair.first, pair.second) for pair in near), f"{seed} {time}"


def test_obstacle_that_passes_a_robot_at_rest_does_not_count() -> None:
    problem = named("past_pillar_xarm7")
    motion = undisturbed(problem)
    tip = problem.scene.placement_of(
        "link7", problem.reduced.all_positions(motion(motion.duration))
    ).translation
    above = to.placement(tip + np.array((0.0, 0.0, 0.5)))
    later = motion.duration + 0.12
    falls = to.Track.through([later, later + 0.15], [above, above * to.placement((0.0, 0.0, -0.4))])
    scene = problem.scene.add("falls", to.Box(0.04, 0.04, 0.04), motion=falls)
    done = run(to.Problem(**{**fields(problem), "scene": scene}))
    assert done.reached and done.clearance_proven is not None
    assert done.clearance_measured >= done.clearance_proven - 1e-4


def test_crossing_cube_does_not_begin_in_the_robot() -> None:
    problem = named("turn_over_ur5")
    motion = undisturbed(problem)
    found = drawn(problem, lambda tolerance: motion, Part.MOVES, 39).problem
    cube = found.scene.placement_of("cube", found.start_positions)
    alone = to.Scene(problem.scene.robot).add("cube", to.Box(0.05, 0.05, 0.05), cube)
    seen = alone.with_clearance(world=0.019)
    reduced = to.Problem(**{**fields(problem), "scene": seen, "constraints": ()}).reduced
    assert to.examine(reduced, motion(0.0)).clear


FILE = """
objects:
  - object: crate
    at: 0.4
    position: [0.4, 0.1, 0.2]
    shape: {type: box, dimensions: [0.1, 0.2, 0.3]}
    leaves: 2.5
  - {object: pillar, at: 1.0, position: [0.9, 0.0, 0.4], orientation: [0, 0, 1, 0]}
sensors: {delay: 0.01, noise: 0.0002}
faults:
  - {kind: stuck, joint: panda_joint4, begin: 0.3, end: 9.0}
"""


def test_surprises_are_read_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "surprises.yaml"
    path.write_text(FILE)
    found = read_surprises(path)
    crate, pillar = found.objects
    assert (crate.name, crate.at, crate.leaves) == ("crate", 0.4, 2.5)
    assert crate.shape == to.Box(0.1, 0.2, 0.3)
    assert pillar.shape is None and pillar.placement.translation.tolist() == [0.9, 0.0, 0.4]
    assert (found.sensors.delay, found.sensors.noise) == (0.01, 0.0002)
    assert found.faults[0].kind is FaultKind.STUCK and found.times == (0.4, 1.0, 2.5)
    scene = named("cup_past_pillar").scene
    assert {"crate", "pillar moved"} <= set(found.world(scene).objects)
    assert "crate" in found.seen(scene, 1.5).objects and "crate" not in found.seen(scene, 3.0).objects
    assert found.seen(scene, 1.5).object("pillar").placement.translation[0] == 0.9


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ("objects: [{object: a, at: x, position: [0, 0, 0]}]", "at: must be a number"),
        ("objects: [{object: a, at: 1, position: [0, 0]}]", "objects\\[0\\]"),
        ("objects: [{object: a, leavs: 1}]", "did you mean 'leaves'"),
        ("faults: [{kind: stuk, begin: 0, end: 1}]", "must be one of drift, stuck, lost commands"),
        ("faults: [{kind: stuck, begin: 0, end: 1}]", "kind 'stuck' needs a joint"),
        ("sensors: {lag: 1}", "unknown key 'lag'"),
    ],
)
def test_errors_of_a_surprise_file_are_named(tmp_path: Path, wrong: str, message: str) -> None:
    path = tmp_path / "surprises.yaml"
    path.write_text(wrong)
    with pytest.raises(FileFormatError, match=message):
        read_surprises(path)


def test_moved_object_must_exist() -> None:
    moved = Surprises(objects=(Surprise(name="pilar", at=1.0, placement=to.placement((1.0, 0.0, 0.0))),))
    with pytest.raises(ObjectNotFound, match="did you mean 'pillar'"):
        run(named("cup_past_pillar"), surprises=moved)
