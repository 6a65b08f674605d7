"""What is kept is found again, as it was, in each of its versions."""

import pickle
import sqlite3
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from trajopt.files.bundle import Holds, read_bundle, save
from trajopt.optimise.terms.user_functions import FunctionResidual
from trajopt.planning import Result
from trajopt.problem.residual import Constraint
from trajopt.server.warehouse import Constraints, Entry, EntryKind, StoredState, Warehouse
from trajopt.tasks import Dwell, MoveTo, Task, TaskResult
from trajopt.values.errors import EntryNotFound, ModelError, ProblemError


def names(found: tuple[Entry, ...]) -> list[str]:
    return [entry.name for entry in found]


def test_a_plan_is_kept_as_a_bundle_keeps_it(kept: Warehouse, solved: Result) -> None:
    entry = kept.add("around", solved, tags=["demo"], note="the first one")
    assert (entry.kind, entry.version, entry.robot, entry.status) == (EntryKind.PLAN, 1, "planar2", "SOLVED")
    assert solved.trajectory is not None and entry.duration == solved.trajectory.duration
    bundle = kept.plan("around")
    assert bundle.holds is Holds.PLAN and bundle.judged().verified
    np.testing.assert_array_equal(bundle.require().positions, solved.trajectory.positions)
    assert str(bundle.problem) == str(solved.problem)


def test_a_failure_is_kept_with_its_explanation(kept: Warehouse, failed: Result) -> None:
    kept.add("stuck", failed)
    bundle = kept.plan("stuck")
    assert bundle.holds is Holds.FAILURE and bundle.status == failed.status.name
    assert bundle.explanation
    assert names(kept.find(solved=False)) == ["stuck"]
    assert kept.find(solved=True) == ()


def test_each_kind_is_read_as_it_was(kept: Warehouse, asked: to.Problem, cell: to.Scene) -> None:
    upright = asked.goals[0]
    kept.add("arm", cell.robot)
    kept.add("cell", cell)
    kept.add("task", asked)
    kept.add("home", StoredState("planar2", {"joint1": 0.25, "joint2": -0.5}))
    kept.add("there", Constraints("planar2", (upright,), group="arm"))
    assert kept.robot("arm").name == "planar2"
    assert list(kept.scene("cell").objects) == ["ball"]
    assert str(kept.problem("task")) == str(asked)
    assert dict(kept.state("home").positions) == {"joint1": 0.25, "joint2": -0.5}
    again = kept.constraints("there")
    assert (str(again.requirements[0]), again.group) == (str(upright), "arm")
    assert {entry.kind for entry in kept.find()} == set(EntryKind) - {EntryKind.PLAN, EntryKind.TASK}


def test_a_state_begins_a_problem(kept: Warehouse, cell: to.Scene) -> None:
    kept.add("home", StoredState("planar2", {"joint1": 0.25, "joint2": 0.5}))
    problem = to.Problem(scene=cell, start=kept.state("home").positions, goal={"joint1": 0.4, "joint2": 0.4})
    np.testing.assert_array_equal(problem.reduced.start_positions, [0.25, 0.5])


def test_saving_again_keeps_the_earlier_versions(kept: Warehouse, cell: to.Scene) -> None:
    kept.add("cell", cell)
    second = kept.add("cell", cell.remove("ball"))
    assert second.version == 2
    assert not kept.scene("cell").objects
    assert list(kept.scene("cell", version=1).objects) == ["ball"]
    assert [entry.version for entry in kept.find(name="cell")] == [2, 1]
    assert [entry.version for entry in kept.find(newest=True)] == [2]


def test_the_number_of_a_removed_version_is_not_given_again(kept: Warehouse, cell: to.Scene) -> None:
    kept.add("cell", cell)
    kept.add("cell", cell)
    assert [entry.version for entry in kept.remove("cell", version=2)] == [2]
    assert kept.add("cell", cell).version == 3
    assert len(kept.remove("cell")) == 2
    with pytest.raises(EntryNotFound):
        kept.scene("cell")


def test_equal_contents_are_kept_once(kept: Warehouse, cell: to.Scene) -> None:
    kept.add("cell", cell)

    def count() -> int:
        connection = sqlite3.connect(kept.path)
        number: int = connection.execute("SELECT count(*) FROM contents").fetchone()[0]
        connection.close()
        return number

    once = count()
    kept.add("cell", cell)
    assert count() == once
    kept.remove("cell", version=1)
    assert list(kept.scene("cell").objects) == ["ball"]
    kept.remove("cell")
    assert count() == 0


def test_found_by_robot_goal_scene_tag_and_text(
    kept: Warehouse, cell: to.Scene, solved: Result, failed: Result
) -> None:
    kept.add("cell", cell)
    kept.add("around", solved, tags=["Shelf", "demo"], note="Made on Monday")
    kept.add("stuck", failed)
    kept.add("other", to.load("panda"))
    assert set(names(kept.find(robot="planar2"))) == {"cell", "around", "stuck"}
    assert names(kept.find(goal="JOINT1 1.4")) == ["around"]
    assert names(kept.find(kind=EntryKind.PLAN, goal={"joint1": 1.39})) == ["around"]
    assert kept.find(goal={"joint1": 1.39}, within=0.001) == ()
    assert kept.find(goal={"no such joint": 0.0}) == ()
    assert set(names(kept.find(scene="cell"))) == {"cell", "around"}
    assert names(kept.find(tags=["demo", "Shelf"])) == ["around"]
    assert kept.find(tags=["demo", "none"]) == ()
    assert names(kept.find(text="monday shelf past")) == ["around"]
    assert set(names(kept.find(text="BALL"))) == {"cell", "around", "stuck"}
    assert kept.find(text="50%_off") == ()


def test_found_by_date(kept: Warehouse, cell: to.Scene) -> None:
    before = datetime.now(UTC)
    kept.add("cell", cell)
    after = datetime.now(UTC) + timedelta(milliseconds=1)
    assert names(kept.find(since=before, until=after)) == ["cell"]
    assert kept.find(since=after) == () == kept.find(until=before)
    local = before.astimezone().replace(tzinfo=None)
    assert names(kept.find(since=local)) == ["cell"]


def test_unknown_names_are_refused_with_near_ones(kept: Warehouse, cell: to.Scene) -> None:
    kept.add("welding cell", cell)
    with pytest.raises(EntryNotFound, match="no scene named 'weldin cell'; did you mean 'welding cell'"):
        kept.scene("weldin cell")
    with pytest.raises(EntryNotFound, match="no version of scene 'welding cell' named '4'"):
        kept.scene("welding cell", version=4)
    with pytest.raises(EntryNotFound, match="did you mean 'welding cell'"):
        kept.find(scene="welding sell")
    with pytest.raises(EntryNotFound, match="there are none"):
        kept.plan("anything")
    entry = kept.entry("welding cell")
    kept.remove("welding cell")
    for gone in (lambda: kept.load(entry), lambda: kept.mark(entry, note="x"), lambda: kept.entry("x")):
        with pytest.raises(EntryNotFound):
            gone()


def test_a_name_of_two_kinds_needs_its_kind(kept: Warehouse, cell: to.Scene, solved: Result) -> None:
    kept.add("shelf", cell)
    kept.add("shelf", solved)
    with pytest.raises(ModelError, match="'shelf' is the name of a plan and a scene"):
        kept.entry("shelf")
    assert kept.entry("shelf", kind=EntryKind.SCENE).kind is EntryKind.SCENE
    assert kept.plan("shelf").status == "SOLVED"


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "x" * 201])
def test_refuses_names_that_cannot_be_typed(kept: Warehouse, cell: to.Scene, name: str) -> None:
    with pytest.raises(ModelError, match="name must be"):
        kept.add(name, cell)
    with pytest.raises(ModelError, match="tag must be"):
        kept.add("cell", cell, tags=[name])
    assert kept.find() == ()


def test_refuses_invalid_data_as_a_whole(kept: Warehouse, cell: to.Scene) -> None:
    def above(positions: np.ndarray) -> np.ndarray:
        return positions[:1]

    own = Constraint(FunctionResidual("above", above, None, 1e-6), np.array([-1.0]), np.array([3.0]))
    problem = to.Problem(scene=cell, start=[0.0, 0.4], goal={"joint1": 1.4}, constraints=[own])
    with pytest.raises(ModelError, match="code"):
        kept.add("task", problem)
    with pytest.raises(ProblemError):
        kept.add("task", 3.0)  # pyright: ignore
    assert kept.find() == ()


def test_tags_and_notes_change(kept: Warehouse, cell: to.Scene) -> None:
    entry = kept.add("cell", cell, tags=["old"])
    changed = kept.mark(entry, tags=["new", "good", "new"], note="looked at")
    assert (changed.tags, changed.note) == (("good", "new"), "looked at")
    assert kept.mark(changed).as_dict() == changed.as_dict()
    assert kept.find(tags=["old"]) == ()


def test_a_bundle_goes_in_and_comes_out_to_the_last_byte(
    kept: Warehouse, solved: Result, tmp_path: Path
) -> None:
    solved.save(tmp_path / "a.trajopt")
    entry = kept.add_bundle(tmp_path / "a.trajopt")
    assert entry.name == "past a ball"
    kept.export(entry, tmp_path / "b.trajopt")
    assert (tmp_path / "a.trajopt").read_bytes() == (tmp_path / "b.trajopt").read_bytes()
    assert read_bundle(tmp_path / "b.trajopt").judged().verified


def test_a_bundle_of_a_problem_is_a_problem(kept: Warehouse, asked: to.Problem, tmp_path: Path) -> None:
    save(asked, tmp_path / "a.trajopt")
    assert kept.add_bundle(tmp_path / "a.trajopt", "task").kind is EntryKind.PROBLEM
    assert str(kept.problem("task")) == str(asked)


def test_the_result_of_a_task_is_kept_found_and_exported(
    kept: Warehouse, cell: to.Scene, tmp_path: Path
) -> None:
    there = {"joint1": 1.4, "joint2": 0.4}
    stages = [MoveTo(there, name="past the ball"), Dwell(0.1)]
    result = to.plan(Task(scene=cell, start=[0.0, 0.4], stages=stages, name="rounds"))
    kept.add("cell", cell)
    entry = kept.add("rounds", result)
    assert (entry.kind, entry.status, entry.goal) == (EntryKind.TASK, "SOLVED", "past the ball, dwell")
    assert entry.duration == pytest.approx(result.duration)
    for found in (
        kept.find(kind=EntryKind.TASK, scene="cell", solved=True),
        kept.find(goal=there, within=1e-3),
        kept.find(goal="past", text="ball"),
    ):
        assert [each.name for each in found] == ["rounds"]
    again = kept.task("rounds")
    assert isinstance(again, TaskResult) and again.stages == result.stages
    kept.export(entry, tmp_path / "a.trajopt")
    assert kept.add_bundle(tmp_path / "a.trajopt").version == 2
    with Warehouse(tmp_path / "other.warehouse") as other:
        kept.copy_to(other, [entry])
        assert isinstance(other.task("rounds"), TaskResult)
    impossible = to.plan(Task(scene=cell, start=[0.0, 0.4], stages=[MoveTo(to.placement((9.0, 0.0, 0.0)))]))
    assert kept.add("far", impossible).status == "NO_INVERSE_KINEMATICS"
    assert kept.find(text="far", solved=False)


def test_refuses_to_export_a_scene_as_a_bundle(kept: Warehouse, cell: to.Scene, tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="copy it to another warehouse"):
        kept.export(kept.add("cell", cell), tmp_path / "cell.trajopt")
    assert not (tmp_path / "cell.trajopt").exists()


def test_a_whole_warehouse_is_copied_once(
    kept: Warehouse, cell: to.Scene, solved: Result, tmp_path: Path
) -> None:
    kept.add("cell", cell, tags=["a"], note="b")
    kept.add("cell", cell.remove("ball"))
    kept.add("around", solved)
    with Warehouse(tmp_path / "other.warehouse") as other:
        other.add("cell", cell.move("ball", to.placement((0.1, 0.2, 0.3))))
        copied = kept.copy_to(other)
        assert [(entry.name, entry.version) for entry in copied] == [("cell", 2), ("cell", 3), ("around", 1)]
        assert kept.copy_to(other) == ()
        first = other.entry("cell", version=2)
        assert (first.made, first.tags, first.note) == (kept.entry("cell", version=1).made, ("a",), "b")
        assert other.plan("around").judged().verified
        assert not other.scene("cell").objects


def test_versions_are_copied_in_their_order_where_the_clock_was_set_back(
    tmp_path: Path, kept: Warehouse, cell: to.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    dates = iter(("2026-11-02T00:00:00+00:00", "2026-11-01T00:00:00+00:00"))
    monkeypatch.setattr("trajopt.server.warehouse.rows.moment", lambda _: next(dates))
    kept.add("cell", cell)
    kept.add("cell", cell.remove("ball"))
    with Warehouse(tmp_path / "other.warehouse") as other:
        kept.copy_to(other)
        assert other.entry("cell").version == 2
        assert not other.scene("cell").objects


def test_it_closes_opens_again_and_goes_to_other_processes(kept: Warehouse, cell: to.Scene) -> None:
    kept.add("cell", cell)
    kept.close()
    assert names(kept.find()) == ["cell"]
    with pickle.loads(pickle.dumps(kept)) as other:
        assert names(other.find()) == ["cell"]
    assert repr(kept).startswith("Warehouse(")


def test_an_entry_prints(kept: Warehouse, solved: Result) -> None:
    entry = kept.add("around", solved, tags=["demo"])
    for words in ("plan", "'around'", "version 1", "planar2", "SOLVED", "tags demo"):
        assert words in str(entry)
    assert entry.as_dict()["kind"] == "plan"


def test_a_transaction_is_stored_completely_or_not_at_all(kept: Warehouse, cell: to.Scene) -> None:
    kept.add("cell", cell)
    with pytest.raises(ZeroDivisionError), kept.together():
        kept.add("cell", cell.remove("ball"))
        kept.add("home", StoredState("planar2", {"joint1": 0.25, "joint2": -0.5}))
        kept.remove("cell", version=1)
        raise ZeroDivisionError
    assert [(entry.name, entry.version) for entry in kept.find()] == [("cell", 1)]
    with kept.together():
        kept.add("cell", cell.remove("ball"))
        kept.remove("cell", version=1)
    assert [(entry.name, entry.version) for entry in kept.find()] == [("cell", 2)]


def test_a_caught_failure_leaves_the_rest_of_a_transaction(kept: Warehouse, cell: to.Scene) -> None:
    with kept.together():
        kept.add("cell", cell)
        with pytest.raises(EntryNotFound):
            kept.remove("another")
        kept.add("home", StoredState("planar2", {"joint1": 0.25, "joint2": -0.5}))
    assert sorted(names(kept.find())) == ["cell", "home"]


def test_a_stored_plan_can_be_proven_in_a_changed_scene(
    kept: Warehouse, solved: Result, failed: Result
) -> None:
    kept.add("past", solved)
    held = kept.standing("past")
    scene = held.problem.scene
    assert held.proven_in(scene.move("ball", to.placement((0.9, 0.9, 0.1))))
    assert not held.proven_in(scene.move("ball", to.placement((0.3, 0.6, 0.1))))
    kept.add("failed", failed)
    with pytest.raises((ModelError, ProblemError)):
        kept.standing("failed")
