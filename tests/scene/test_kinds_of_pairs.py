"""Margins and clearances of the world, of what is carried and of the robot itself, each for itself."""

import pickle
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import odd_arm
from trajopt.scene.clearances import PairKind
from trajopt.scene.reducing import reduce_model
from trajopt.scene.track import Track
from trajopt.values.errors import ModelError, ShapeError
from trajopt.verify import verify
from trajopt.verify.kernel.pair_distances import required_clearances

OF = {
    ("turret", "fore"): PairKind.ROBOT,
    ("base", "fore"): PairKind.ROBOT,
    ("fore", "table"): PairKind.WORLD,
    ("fore", "rack"): PairKind.WORLD,
    ("base", "drill"): PairKind.CARRIED,
    ("drill", "screw"): PairKind.CARRIED,
}
"""Pairs of one kind; "table" stands in the world, "rack" on the base, which no joint moves."""


@pytest.fixture
def scene(tmp_path: Path) -> to.Scene:
    box = to.Box(0.02, 0.02, 0.02)
    return (
        to.Scene(odd_arm(tmp_path))
        .add("table", to.Box(1, 1, 0.1), to.placement((0.8, 0, -0.3)))
        .add("rack", box, to.placement((0, 0.9, 0)), frame="base")
        .add("drill", box, to.placement((0, 0, 0.1)), frame="tip")
        .add("screw", box, to.placement((0, 0, 0.1)), frame="finger")
    )


@pytest.mark.parametrize("pair", OF)
def test_each_kind_keeps_its_own(scene: to.Scene, pair: tuple[str, str]) -> None:
    values = {PairKind.WORLD: 0.03, PairKind.CARRIED: 0.02, PairKind.ROBOT: 0.004}
    kept = scene.with_clearance(world=0.03, carried=0.02, robot=0.004)
    assert kept.clearance_of(*pair) == values[OF[pair]] and scene.clearance_of(*pair) == 0.0
    wished = scene.with_margin(world=0.03, carried=0.02, robot=0.004)
    assert wished.margin_of(*pair) == values[OF[pair]] and scene.margin_of(*pair) == 0.01


def test_attached_objects_keep_the_larger_clearance_from_the_world(scene: to.Scene) -> None:
    pair = ("drill", "table")
    assert scene.with_clearance(world=0.03).clearance_of(*pair) == 0.03
    assert scene.with_clearance(carried=0.02).clearance_of(*pair) == 0.02
    both = scene.with_clearance(world=0.03, carried=0.02)
    assert both.clearance_of(*pair) == 0.03 == both.with_clearance(carried=0.01).clearance_of(*pair)
    assert scene.with_margin(world=0.0).margin_of(*pair) == 0.0, "the default is of what nobody spoke of"


def test_later_clearances_replace_earlier_ones(scene: to.Scene) -> None:
    stated = scene.with_clearance(0.01).with_clearance(world=0.03)
    assert stated.clearance_of("fore", "table") == 0.03 and stated.clearance_of("base", "fore") == 0.01
    again = stated.with_clearance(0.02)
    assert again.clearance_of("fore", "table") == 0.02 and not again.clearances.kinds
    assert scene.with_clearance(0.01, world=0.03).clearance_of("fore", "table") == 0.03
    margins = scene.with_margin(robot=0.001)
    assert margins.kind_margins and not margins.with_margin(0.02).kind_margins
    single = stated.with_clearance(0.05, "fore", "table")
    assert single.clearance_of("fore", "table") == 0.05 and single.clearance_of("tip", "table") == 0.03


def test_the_pairs_of_the_model_have_the_stated_clearances(scene: to.Scene) -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        names = rng.permutation(["world", "carried", "robot"])[: rng.integers(1, 4)].tolist()
        first, second = ({name: float(rng.choice([0.0, 0.01, 0.03])) for name in names} for _ in "ab")
        asked = scene.with_clearance(**first).with_margin(**second).with_clearance(0.007, "tip", "table")
        asked = replace(asked, clearances=replace(asked.clearances, links={"tip": 0.02}))
        reduced = reduce_model(asked, "all", asked.robot.positions())
        for pair, required in enumerate(required_clearances(reduced).tolist()):
            owners = reduced.owners(pair)
            assert required == asked.clearance_of(*owners) == reduced.pairs.required[pair]
            assert reduced.pairs.margin[pair] == asked.margin_of(*owners)


def test_a_tool_that_moves_takes_its_objects_along(scene: to.Scene) -> None:
    scene = scene.with_tool("flange", on="tip").move("drill", to.placement((0, 0, 0.1)), frame="flange")
    still = scene.with_clearance(carried=0.02).move("flange", to.placement((0, 0.9, 0)), frame="base")
    reduced = reduce_model(scene.with_clearance(carried=0.02), "all", scene.robot.positions())
    moved = reduce_model(still, "all", scene.robot.positions())
    assert any(
        "drill" in reduced.owners(pair) and "base" in reduced.owners(pair)
        for pair in range(len(reduced.pairs.first))
    )
    assert frozenset(("drill", "base")) in moved.pairs.immobile


def test_it_is_printed_and_kept(scene: to.Scene) -> None:
    asked = scene.with_clearance(world=0.03, robot=0.0).with_margin(0.02, carried=0.05)
    words = "clearance 0 mm (world 30 mm, robot 0 mm) required, margin 20 mm (carried 50 mm)"
    assert words in str(asked) and words in str(pickle.loads(pickle.dumps(asked)))
    assert "world" not in str(asked.with_clearance(0.01))


@pytest.mark.parametrize("edit", ["with_clearance", "with_margin"])
def test_invalid_clearances_are_refused(scene: to.Scene, edit: str) -> None:
    call = getattr(scene, edit)
    with pytest.raises(ModelError, match="world, carried or robot"):
        call()
    with pytest.raises(ModelError, match="one value for 'fore' and 'table'"):
        call(None, "fore", "table")
    with pytest.raises(ModelError, match="one value for 'fore' and 'table'"):
        call(0.01, "fore", "table", world=0.02)
    for wrong in (-0.01, np.nan, "far"):
        with pytest.raises(ShapeError):
            call(world=wrong)


def turn(scene: to.Scene, *corners: dict[str, float]) -> to.Trajectory:
    """Go through corners at a quarter of a radian a second."""
    reduced = reduce_model(scene, "all", scene.robot.positions(corners[0]))
    places = np.array([scene.robot.positions(at)[scene.robot.index(reduced.joint_names)] for at in corners])
    steps = [0.0, *(4.0 * np.abs(after - before).max() for before, after in pairwise(places))]
    return to.Trajectory(reduced.joint_names, np.cumsum(steps), places)


def test_the_judge_proves_the_kinds_apart(scene: to.Scene) -> None:
    bent, straight = {"elbow": 0.6, "pan": -0.5}, {"elbow": 0.4, "pan": 0.5}
    asked = scene.with_clearance(world=0.05, carried=0.03, robot=0.002)
    motion = turn(asked, bent, straight)

    def judged(kept: to.Scene) -> dict[str, bool]:
        reduced = reduce_model(kept, "all", kept.robot.positions(bent))
        rows = verify(reduced, motion, goals=()).checks
        return {check.name: check.holds for check in rows if check.name.startswith("clearance")}

    from_world, carried, itself = names = (
        "clearance from the world",
        "clearance of attached objects",
        "clearance of the robot from itself",
    )
    assert judged(asked) == dict.fromkeys(names, True)
    assert judged(scene) == {"clearance": True}
    broken = {"world": {from_world}, "carried": {from_world, carried}, "robot": {itself}}
    for kind, rows in broken.items():
        found = judged(asked.with_clearance(**{kind: 0.9}))
        assert {name for name, holds in found.items() if not holds} == rows, "nothing keeps 0.9 m"


def test_the_judge_reads_the_scene_itself(scene: to.Scene) -> None:
    reduced = reduce_model(scene.with_clearance(world=0.9), "all", scene.robot.positions())
    wrong = replace(reduced.pairs, required=np.zeros(len(reduced.pairs.first)))
    misled = replace(reduced, collision_model=replace(reduced.collision_model, pairs=wrong))
    assert to.examine(misled, misled.start_positions).collisions, "what the planner believes does not count"


def test_dynamic_obstacles_belong_to_the_world(scene: to.Scene) -> None:
    away = [to.placement((1.6, side, 0.3)) for side in (-0.3, 0.3)]
    cart = Track.through([0.0, 10.0], away)
    moving = scene.add("cart", to.Box(0.1, 0.1, 0.1), motion=cart).with_clearance(world=0.05, robot=0.002)
    assert moving.clearance_of("fore", "cart") == 0.05 == moving.clearance_of("drill", "cart")
    motion = turn(moving, {"elbow": 0.6, "pan": -0.5}, {"elbow": 0.4, "pan": 0.5})

    def holds(kept: to.Scene) -> dict[str, bool]:
        reduced = reduce_model(kept, "all", kept.robot.positions({"elbow": 0.6, "pan": -0.5}))
        rows = verify(reduced, motion, goals=()).checks
        return {check.name: check.holds for check in rows if check.name == "clearance from the world"}

    assert holds(moving) == {"clearance from the world": True}
    assert holds(moving.with_clearance(1.5, "fore", "cart")) == {"clearance from the world": False}


def box(name: str, x: float) -> str:
    shape = f'<origin xyz="{x} 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry>'
    return f'<link name="{name}"><collision>{shape}</collision></link>'


def fixed(name: str, parent: str) -> str:
    return f'<joint name="to_{name}" type="fixed"><parent link="{parent}"/><child link="{name}"/></joint>'


CELL = (
    '<robot name="cell">{root}<link name="plate"/>'
    + "".join(box(name, x) for name, x in (("table", 0.9), ("pedestal", 0.0), ("mount", 0.3), ("arm", 0.5)))
    + fixed("plate", "root")
    + fixed("table", "plate")
    + fixed("pedestal", "root")
    + fixed("mount", "pedestal")
    + '<joint name="turn" type="revolute"><parent link="pedestal"/><child link="arm"/><axis xyz="0 0 1"/>'
    '<limit lower="-2" upper="2" effort="1" velocity="1"/></joint></robot>'
)
"""A table beside an arm on a pedestal, with something mounted on that."""


@pytest.mark.parametrize("root", ['<link name="root"/>', box("root", -0.5)])
def test_a_table_of_the_description_is_part_of_the_world(tmp_path: Path, root: str) -> None:
    (tmp_path / "cell.urdf").write_text(CELL.format(root=root))
    scene = to.Scene(to.load(tmp_path / "cell.urdf")).allow("pedestal", "arm", allowed=False)
    asked = scene.with_clearance(world=0.03, robot=0.004)
    meant = {"table": 0.03 if "collision" not in root else 0.004, "mount": 0.004, "pedestal": 0.004}
    assert {name: asked.clearance_of("arm", name) for name in meant} == meant
    reduced = reduce_model(asked, "all", asked.robot.positions())
    found = required_clearances(reduced)
    assert np.array_equal(found, reduced.pairs.required) and set(found.tolist()) == set(meant.values())


def test_the_world_of_an_mjcf_file_is_the_world(tmp_path: Path) -> None:
    (tmp_path / "bench.xml").write_text(
        """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 0.1" pos="0 0 -0.5"/>
        <body name="base"><geom type="sphere" size="0.05"/><body name="arm" pos="0 0 0.2">
        <joint name="turn" axis="0 1 0" range="-1 1"/><geom type="sphere" size="0.05" pos="0.3 0 0"/>
        </body></body></worldbody></mujoco>"""
    )
    asked = to.Scene(to.Robot.from_mjcf(tmp_path / "bench.xml")).with_clearance(world=0.03)
    assert asked.clearance_of("arm", "world/floor") == 0.03 and asked.clearance_of("arm", "base") == 0.0
    reduced = reduce_model(asked, next(iter(asked.robot.groups)), asked.robot.positions())
    assert np.array_equal(required_clearances(reduced), reduced.pairs.required)
