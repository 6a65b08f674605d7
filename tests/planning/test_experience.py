"""What was planned is remembered, tried first for what is like it, and forgotten where it never helps."""

import sqlite3
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.files.bundle import read_bundle, replay
from trajopt.planning import Result, Status
from trajopt.planning.experience import FORGIVEN, Experience, _likeness, _scene_signature, _scenes_apart
from trajopt.planning.goal_search import Candidate, attempt
from trajopt.planning.seeds import SeedKind
from trajopt.problem.problem import named_problem
from trajopt.server.warehouse import Warehouse
from trajopt.values.errors import FileFormatError, ProblemError, ShapeError


def problem(
    *, ball: tuple[float, float, float] = (0.65, 0.65, 0.1), start: float = 0.0, end: float = 1.4
) -> to.Problem:
    scene = to.Scene(to.load("planar2")).add("ball", to.Sphere(0.1), to.placement(ball))
    return to.Problem(scene=scene, start=[start, 0.4], goal={"joint1": end, "joint2": 0.4})


@pytest.fixture
def learnt() -> Experience:
    experience = Experience()
    assert to.plan(problem(), experience=experience).verified
    assert len(experience) == 1 and experience.version == 1
    return experience


def test_it_is_off_by_default() -> None:
    result = to.plan(problem())
    assert result.arguments is not None and result.arguments.recalled is None
    assert result.as_dict()["experience"] is None


def test_a_similar_problem_begins_from_the_memory(learnt: Experience) -> None:
    result = to.plan(problem(ball=(0.66, 0.64, 0.1), start=0.05), experience=learnt)
    assert result.verified and result.won is not None
    assert result.won.kind is SeedKind.GIVEN and len(result.attempts) == 1
    assert result.as_dict()["experience"] == {"version": 1, "memories": [1]}
    memory = learnt.storage.all()[1]
    assert (memory.wins, memory.failures, memory.used) == (1, 0, 2)
    assert len(learnt) == 1, "what came from a memory this near is not kept beside it"


NEARLY_FIXED = to.joint_positions({"joint2": 0.4}, above={"joint2": 1.0}, below={"joint2": 1.0})


@pytest.mark.parametrize(
    "other",
    [
        problem(end=-1.4),
        problem(start=-1.0),
        problem(ball=(-0.9, -0.9, 0.9)),
        replace(problem(), goal={"joint1": 1.4}),
        replace(
            problem(),
            constraints=[NEARLY_FIXED],
        ),
    ],
    ids=["goal", "start", "scene", "kind of goal", "constraints"],
)
def test_an_unlike_problem_does_not(learnt: Experience, other: to.Problem) -> None:
    result = to.plan(other, experience=learnt)
    assert result.as_dict()["experience"] == {"version": 1, "memories": []}
    assert len(learnt) == 2


def test_the_answer_is_the_one_without_it_where_nothing_is_remembered() -> None:
    alone, asked = to.plan(problem()), to.plan(problem(), experience=Experience())
    assert alone.trajectory is not None and asked.trajectory is not None
    np.testing.assert_array_equal(alone.trajectory.positions, asked.trajectory.positions)
    assert dict(alone.counts) == dict(asked.counts)


def test_where_a_memory_fails_the_usual_tries_follow(
    learnt: Experience, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved = problem(ball=(0.66, 0.64, 0.1))
    fail_first(monkeypatch)
    result = to.plan(moved, experience=learnt)
    assert result.verified and result.won is not None and result.won.kind is not SeedKind.GIVEN
    assert result.attempts[0].kind is SeedKind.GIVEN
    memories = learnt.storage.all()
    assert memories[1].failures == 1 and len(memories) == 2, "what was found otherwise is learnt"


def fail_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have attempts from given paths fail, as from a path that leads nowhere."""

    def failing(candidate: Candidate) -> Result:
        if candidate.kind is SeedKind.GIVEN:
            return candidate.workspace.result(Status.STUCK, "on purpose")
        return attempt(candidate)

    monkeypatch.setattr(import_module("trajopt.planning.search"), "attempt", failing)


def test_memories_that_never_win_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    experience = Experience()
    to.plan(problem(), experience=experience)
    fail_first(monkeypatch)
    frozen = Experience(experience.storage, learning=False)
    for turn in range(1, FORGIVEN + 1):
        near = frozen.recall(problem())
        assert near.memories == (1,)
        result = to.plan(problem(), seeds=near.seeds)
        experience.learn(problem(), replace(result, path=None), near)
        failures = {number: each.failures for number, each in experience.storage.all().items()}
        assert failures == ({} if turn == FORGIVEN else {1: turn})


def test_it_is_bounded_and_keeps_winning_memories() -> None:
    experience = Experience(most=3)
    for end in (0.3, 0.9, 1.4):
        to.plan(problem(end=end, ball=(-0.9, -0.9, 0.9)), experience=experience)
    to.plan(problem(end=0.3, ball=(-0.9, -0.9, 0.9)), experience=experience)  # the oldest wins
    to.plan(problem(end=-0.9, ball=(-0.9, -0.9, 0.9)), experience=experience)
    assert sorted(experience.storage.all()) == [1, 3, 4]


def test_without_learning_nothing_changes(learnt: Experience) -> None:
    frozen = Experience(learnt.storage, learning=False)
    first = to.plan(problem(start=0.05), experience=frozen)
    second = to.plan(problem(start=0.05), experience=frozen)
    assert dict(first.counts) == dict(second.counts) and frozen.version == 1
    assert first.trajectory is not None and second.trajectory is not None
    np.testing.assert_array_equal(first.trajectory.positions, second.trajectory.positions)


def test_a_bundle_replays_without_the_memory(learnt: Experience, tmp_path: Path) -> None:
    to.plan(problem(start=0.05), experience=learnt).save(tmp_path / "x.trajopt")
    bundle = read_bundle(tmp_path / "x.trajopt")
    assert bundle.arguments is not None and bundle.arguments.recalled is not None
    assert bundle.arguments.recalled.as_dict() == {"version": 1, "memories": [1]}
    assert replay(bundle).same


def test_seeds_of_the_caller_come_first(learnt: Experience) -> None:
    path = to.plan(problem()).path
    assert path is not None
    result = to.plan(problem(start=0.05), seeds=[path], experience=learnt)
    assert result.arguments is not None and len(result.arguments.seeds) == 2
    memory = learnt.storage.all()[1]
    assert (memory.wins, memory.failures) == (0, 0), "it was not even tried"


def test_goal_sets_recall_for_each_goal(learnt: Experience) -> None:
    either = to.any_of(
        {"far": to.joint_positions({"joint1": -1.2, "joint2": 0.4}), "near": problem().goals[0]}
    )
    result = to.plan(replace(problem(start=0.05), goal=either), experience=learnt)
    assert result.verified and result.as_dict()["experience"] == {"version": 1, "memories": [1]}


def test_problems_with_dynamic_obstacles_or_waypoints_are_not_remembered() -> None:
    experience = Experience()
    via = replace(problem(), waypoints=[to.joint_positions({"joint1": 0.7, "joint2": 0.9})])
    assert to.plan(via, experience=experience).verified
    assert len(experience) == 0 and experience.recall(via).memories == ()


def test_failures_teach_nothing() -> None:
    experience = Experience()
    scene = problem().scene.move("ball", to.placement((0.2, 0.6, 0.1)))
    blocked = to.Problem(scene=scene, start=[0.0, 0.4], goal={"joint1": 1.2, "joint2": 0.1})
    assert not to.plan(blocked, experience=experience).verified
    assert len(experience) == 0


def test_names_of_objects_do_not_matter() -> None:
    scene = problem().scene
    other = scene.remove("ball").add("sphere", to.Sphere(0.1), to.placement((0.65, 0.65, 0.1)))
    assert _scenes_apart(_scene_signature(scene), _scene_signature(other)) == 0.0
    assert _scenes_apart(_scene_signature(scene), _scene_signature(to.Scene(scene.robot))) == 1.0
    moved = scene.move("ball", to.placement((0.65, 0.68, 0.1)))
    assert _scenes_apart(_scene_signature(scene), _scene_signature(moved)) == pytest.approx(0.03)


@pytest.mark.parametrize("name", ["cup_past_pillar", "bookshelf_panda", "wiping_panda", "wide_berth"])
def test_every_kind_of_problem_has_a_likeness(name: str) -> None:
    asked = named_problem(name)
    for alone in (asked.alternatives or {"": asked}).values():
        like = _likeness(alone)
        assert (
            like.key == _likeness(alone).key
            and np.isfinite(like.scene).all()
            and np.isfinite(like.goal).all()
        )


def test_a_file_keeps_it_for_other_processes(tmp_path: Path) -> None:
    first = Warehouse(tmp_path / "w").experience()
    second = Warehouse(tmp_path / "w").experience()
    to.plan(problem(), experience=first)
    result = to.plan(problem(start=0.05), experience=second)
    assert result.won is not None and result.won.kind is SeedKind.GIVEN
    assert first.version == second.version == 2
    in_memory = Experience()
    to.plan(problem(), experience=in_memory)
    stored, known = first.storage.all()[1], in_memory.storage.all()[1]
    np.testing.assert_array_equal(stored.knots, known.knots)
    assert (stored.key, stored.wins) == (known.key, 1)


def test_a_damaged_memory_is_named(tmp_path: Path) -> None:
    experience = Warehouse(tmp_path / "w").experience()
    to.plan(problem(), experience=experience)
    for arrays in ("{}", '{"start": [0], "goal": [], "scene": [], "knots": [[1, 2]]}', "nonsense"):
        with closing(sqlite3.connect(tmp_path / "w")) as connection, connection:
            connection.execute("UPDATE memories SET arrays = ?", (arrays,))
        connection.close()
        with pytest.raises(FileFormatError, match="memory 1 is damaged"):
            Warehouse(tmp_path / "w").experience().recall(problem())


def test_threads_share_one(learnt: Experience) -> None:
    def planned(turn: int) -> Result:
        return to.plan(problem(start=0.01 * turn), experience=learnt)

    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(planned, range(8)))
    assert all(result.verified for result in results)
    assert learnt.storage.all()[1].wins == 8


def test_a_path_from_elsewhere_is_remembered_like_a_motion(learnt: Experience) -> None:
    result = to.plan(problem())
    assert result.trajectory is not None
    told = Experience()
    assert told.remember(problem(), result.trajectory.positions)
    assert not told.remember(problem(start=0.02), result.trajectory.positions), "a near one is there already"
    again = to.plan(problem(ball=(0.66, 0.64, 0.1), start=0.05), experience=told)
    assert again.won is not None and again.won.kind is SeedKind.GIVEN and len(again.attempts) == 1
    assert told.storage.all()[1].knots.shape == learnt.storage.all()[1].knots.shape


def test_a_full_store_replaces_its_oldest_path() -> None:
    experience = Experience(most=2)
    for end in (0.3, 0.9, 1.4):
        assert experience.remember(problem(end=end), [[0.0, 0.4], [end, 0.4]])
    assert sorted(experience.storage.all()) == [2, 3]


def test_paths_that_cannot_be_remembered() -> None:
    straight = [[0.0, 0.4], [1.4, 0.4]]
    via = replace(problem(), waypoints=[to.joint_positions({"joint1": 0.7, "joint2": 0.9})])
    assert not Experience().remember(via, straight)
    assert not Experience(learning=False).remember(problem(), straight)
    with pytest.raises(ShapeError, match=r"path: needs shape \(any, 2\)"):
        Experience().remember(problem(), [[0.0], [1.4]])
    with pytest.raises(ShapeError, match="at least 2 points"):
        Experience().remember(problem(), straight[:1])


def test_invalid_experience_is_refused() -> None:
    with pytest.raises(ProblemError, match="experience must be an Experience"):
        to.plan(problem(), experience=3)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ProblemError, match="most must be at least 1"):
        Experience(most=0)
