"""Each source makes the problems that it says, as a worker makes them: from documents alone."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import trajopt as to
from tests.lab.campaign.rooms import REQUEST, SCENE
from trajopt.lab.campaign import (
    Campaign,
    ProblemSource,
    base_placements,
    from_folder,
    from_problems,
    from_table,
    installed,
    perturbed,
    random_motions,
)
from trajopt.lab.campaign.recipes import Library, Packer, Workshop, read
from trajopt.lab.suite.instance import find_instances
from trajopt.optimise.kinematics import validity
from trajopt.robot.loading.pinocchio_model import root_placement
from trajopt.values.errors import CampaignError, FileFormatError, ModelError, ProblemError, ProblemNotFound


def made(source: ProblemSource, folder: Path) -> Sequence[to.Problem]:
    """Make the problems of a source as a worker does."""
    packer = Packer()
    tasks = list(Campaign("x", [source]).tasks(packer))
    packer.write(folder)
    assert len(tasks) == source.count
    shop = Workshop(Library(folder))
    return [read(task.recipe).problem(shop) for task in tasks]


def same_motion(a: to.Problem, b: to.Problem) -> bool:
    one, other = to.plan(a), to.plan(b)
    assert one.trajectory is not None and other.trajectory is not None
    return all(
        np.array_equal(getattr(one.trajectory, name), getattr(other.trajectory, name))
        for name in ("times", "positions", "velocities", "accelerations")
    )


def test_a_problem_comes_back_to_the_last_digit(task: to.Problem, tmp_path: Path) -> None:
    (found,) = made(from_problems("own", [task]), tmp_path)
    assert found.name == task.name and same_motion(found, task)


def test_problems_share_robot_and_scene(task: to.Problem, tmp_path: Path) -> None:
    one, other = made(from_problems("own", [task, task]), tmp_path)
    assert one.scene is other.scene and len(list(tmp_path.iterdir())) == 2


def test_code_of_the_callers_is_refused(task: to.Problem, tmp_path: Path) -> None:
    class Mine(to.Sphere):
        pass

    scene = task.scene.add("mine", Mine(0.01), to.placement((2.0, 0.0, 0.0)))
    with pytest.raises(ModelError, match="is code, not data"):
        made(random_motions(scene, 1), tmp_path)


def test_a_folder_of_messages_is_read_as_bench_reads_it(tmp_path: Path) -> None:
    data = tmp_path / "data"
    (data / "balls").mkdir(parents=True)
    (data / "balls" / "scene0007.yaml").write_text(SCENE)
    (data / "balls" / "request0007.yaml").write_text(REQUEST)
    robot = to.load("planar2")
    (found,) = made(from_folder(data, robot), tmp_path / "documents")
    (instance,) = find_instances(data, robot)
    assert found.name == "balls/7" and same_motion(found, instance.make())


def test_tables_of_messages_and_of_starts_and_goals(scene: to.Scene, tmp_path: Path) -> None:
    messages, motions = tmp_path / "messages.parquet", tmp_path / "motions.parquet"
    pq.write_table(
        pa.table({"scene": [SCENE, SCENE], "request": [REQUEST, REQUEST], "number": [5, 0]}), messages
    )
    pq.write_table(pa.table({"start": [[0.0, 0.4]], "goal": [[1.4, 0.4]]}), motions)
    first, second = made(from_table(messages, scene.robot), tmp_path / "a")
    assert (first.name, second.name) == ("messages/5", "messages/0")
    (third,) = made(from_table(motions, scene), tmp_path / "b")
    assert same_motion(first, second) and same_motion(first, third)


def test_tables_of_something_else_are_refused(scene: to.Scene, tmp_path: Path) -> None:
    file = tmp_path / "else.parquet"
    with pytest.raises(CampaignError, match="cannot be read"):
        from_table(file, scene)
    pq.write_table(pa.table({"start": [[0.0]]}), file)
    with pytest.raises(FileFormatError, match="neither the columns"):
        from_table(file, scene)
    pq.write_table(pa.table({"start": [[0.0]], "goal": [[1.0]]}), file)
    with pytest.raises(ProblemError, match="a position of each of 2 joints"):
        made(from_table(file, scene), tmp_path)


def test_random_motions_are_free_and_differ(scene: to.Scene, tmp_path: Path) -> None:
    found = made(random_motions(scene, 20), tmp_path)
    starts = np.array([problem.start_positions for problem in found])
    assert len(np.unique(starts, axis=0)) == 20
    for problem in found:
        assert validity(problem.reduced, problem.start_positions).valid


def test_random_motions_where_nothing_is_free_are_refused(scene: to.Scene, tmp_path: Path) -> None:
    full = scene.add("everything", to.Box(9.0, 9.0, 9.0), to.placement((0.0, 0.0, 0.0)))
    with pytest.raises(ProblemError, match="random configurations are free"):
        made(random_motions(full, 1), tmp_path)


def test_objects_are_perturbed_within_bounds(task: to.Problem, tmp_path: Path) -> None:
    at = task.scene.objects["ball"].placement
    found = made(perturbed(task, 30, shift=0.03, turn=0.2), tmp_path)
    shifts = np.array([each.scene.objects["ball"].placement.translation - at.translation for each in found])
    turns = np.array([each.scene.objects["ball"].placement.rpy[2] for each in found])
    assert np.abs(shifts).max() <= 0.03 and np.abs(shifts).max(axis=0).min() > 0.02
    assert np.abs(turns).max() <= 0.2 and np.abs(turns).max() > 0.1
    assert {each.goals for each in found} == {found[0].goals}


def test_perturbing_by_nothing_changes_nothing(task: to.Problem, tmp_path: Path) -> None:
    (found,) = made(perturbed(task, 1, shift=0.0), tmp_path)
    assert same_motion(found, task)


def test_base_placements_follow_the_grid(scene: to.Scene, tmp_path: Path) -> None:
    task = to.Problem(scene=scene, start=[0.0, 0.4], goal={"joint1": 0.2}, name="reach")
    found = made(base_placements([task, task], x=(0.0, 0.1), y=(0.3,), yaw=(0.0, 1.0)), tmp_path)
    bases = [root_placement(each.scene.robot.model) for each in found[::2]]
    assert [each.translation.tolist()[:2] for each in bases] == [[0, 0.3], [0, 0.3], [0.1, 0.3], [0.1, 0.3]]
    assert np.allclose([each.rpy[2] for each in bases], [0.0, 1.0, 0.0, 1.0])
    for problem, base in zip(found[::2], bases, strict=True):
        assert problem.scene.objects["ball"].placement == scene.objects["ball"].placement
        tip = problem.scene.placement_of(scene.robot.links[-1], problem.start_positions)
        before = scene.placement_of(scene.robot.links[-1], problem.start_positions)
        assert np.allclose(tip.translation, (base * before).translation)
    assert found[0].scene is found[1].scene


def test_installed_problems(tmp_path: Path) -> None:
    fixed, drawn = made(installed("past_pillar_ur5", 2), tmp_path)
    assert not np.array_equal(fixed.start_positions, drawn.start_positions) or fixed.goals != drawn.goals
    with pytest.raises(ProblemNotFound, match="did you mean 'planar_fold'"):
        installed("planar_folt")
    with pytest.raises(ProblemError, match="has no random instances"):
        installed("walled_in", 2)


def test_invalid_recipes_are_refused() -> None:
    with pytest.raises(CampaignError, match="no recipe of a problem"):
        read('{"recipe": "Spell"}')


def test_grids_without_anything_are_refused(task: to.Problem) -> None:
    with pytest.raises(ProblemError, match="x is empty"):
        base_placements([task], x=(), y=(0.0,))
    with pytest.raises(ProblemError, match="tasks is empty"):
        base_placements([], x=(0.0,), y=(0.0,))


def test_a_source_is_printed_under_its_own_name() -> None:
    assert repr(installed("planar_fold", 1)) == "ProblemSource(name='planar_fold', count=1)"
