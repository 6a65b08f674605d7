"""Pair lists against the plain double loop, on random scenes; and what scenes may share."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import trajopt as to
from tests.robots_for_tests import two_arms
from trajopt.scene.clearances import AllowedCollisions, ContactAllowance
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model

GROUPS = ("both", "left", "right")
SHAPES = (to.Box(0.1, 0.2, 0.3), to.Sphere(0.1), to.Plane())


@pytest.fixture(scope="module")
def arms(tmp_path_factory: pytest.TempPathFactory) -> to.Robot:
    return two_arms(tmp_path_factory.mktemp("two_arms"))


def listed(reduced: ReducedModel) -> tuple[list[tuple[int, int, float]], list[tuple[int, ContactAllowance]]]:
    """Every pair of bodies, asked about one by one."""
    scene, bodies = reduced.scene, reduced.bodies
    pairs: list[tuple[int, int, float]] = []
    allowances: list[tuple[int, ContactAllowance]] = []
    for j, b in enumerate(bodies):
        for i, a in enumerate(bodies[:j]):
            if a.owner == b.owner or a.joint == b.joint or scene.may_touch(a.owner, b.owner):
                continue
            meant = [item for item in scene.allowances if item.pair == {a.owner, b.owner}]
            allowances.extend((len(pairs), item) for item in meant)
            pairs.append((i, j, scene.margin_of(a.owner, b.owner)))
    return pairs, allowances


def immobile(reduced: ReducedModel) -> set[frozenset[str]]:
    scene = reduced.scene
    return {
        frozenset((a.owner, b.owner))
        for a in reduced.bodies
        for b in reduced.bodies
        if a.owner != b.owner and a.joint == b.joint and not scene.may_touch(a.owner, b.owner)
        if a.joint != 0 or {a.owner, b.owner} & set(scene.robot.links)
    }


def check_pairs(reduced: ReducedModel) -> None:
    pairs = reduced.pairs
    expected, allowances = listed(reduced)
    found = zip(pairs.first.tolist(), pairs.second.tolist(), pairs.margin.tolist(), strict=True)
    assert list(found) == expected
    assert list(pairs.allowances) == allowances
    assert pairs.immobile == immobile(reduced)


def placements(reduced: ReducedModel) -> list[to.Placement]:
    return [body.placement for body in reduced.bodies]


def random_scene(arms: to.Robot, rng: np.random.Generator) -> to.Scene:
    scene, links, names = to.Scene(arms), arms.links, [f"thing{i}" for i in range(12)]
    for i, name in enumerate(names):
        frames = ("world", *links, "tool", *names[:i])
        parts = [(SHAPES[int(k)], to.placement((0, 0, k))) for k in rng.integers(3, size=rng.integers(3))]
        touched = rng.choice(links, size=2) if rng.random() < 0.3 else ()
        frame = "world" if rng.random() < 0.5 else str(rng.choice(frames))
        scene = scene.add(name, parts, frame=frame, touch_links=map(str, touched))
    owners = [*links, *names]
    entries = {
        frozenset(map(str, rng.choice(owners, 2, replace=False))): bool(k) for k in rng.integers(2, size=40)
    }
    defaults = {str(name): bool(k) for name, k in zip(rng.choice(owners, 3), (0, 1, 1), strict=True)}
    scene = to.Scene(arms, scene.objects, AllowedCollisions(entries, defaults), margin=0.02)
    for value in rng.uniform(size=6):
        a, b = map(str, rng.choice(owners, 2, replace=False))
        scene = scene.with_margin(float(value), a, b)
    for i in range(6):
        a, b = map(str, rng.choice(owners, 2, replace=False))
        scene = scene.allow_contact(f"contact {i}", a, b, first=0.5)
    return scene


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("group", GROUPS)
def test_pairs_are_those_of_the_double_loop(arms: to.Robot, group: str, seed: int) -> None:
    reduced = reduce_model(random_scene(arms, np.random.default_rng(seed)), group, arms.positions())
    assert len(reduced.pairs.first) > 20
    check_pairs(reduced)


def test_every_edit_is_seen_and_leaves_the_scene_before(arms: to.Robot) -> None:
    at = arms.positions({"left_elbow": 0.4})
    scene = to.Scene(arms).add("table", to.Box(1, 1, 0.1)).add("part", to.Sphere(0.1), frame="table")
    part = to.placement((0, 0, 0.5))
    edits = [
        scene,
        scene.move("part", part),
        scene.move("table", to.placement((1, 0, 0))),
        scene.attach("part", "left_hand", at=at),
        scene.attach("part", "tool", at=at),
        scene.attach("part", "left_hand", at=at).detach("part", at=at),
        scene.add("post", to.Cylinder(0.1, 1.0)),
        scene.remove("part"),
        scene.remove("part").add("part", [(to.Sphere(0.1), part), (to.Sphere(0.2), part)]),
        scene.allow("part", "left_hand"),
        scene.allow("part"),
        scene.with_margin(0.05),
        scene.with_margin(0.05, "part", "left_hand"),
        scene.allow_contact("lift", "part", "left_hand", last=0.1),
    ]
    for _ in range(2):
        for group in GROUPS:
            for edited in edits:
                reduced = reduce_model(edited, group, at)
                check_pairs(reduced)
                for body in reduced.bodies[len(arms.bodies) :]:
                    holder = edited.holder(body.owner)
                    joint, where = reduced.attachment(body.owner)
                    assert body.joint == joint
                    link = (
                        to.placement() if holder.link == "world" else reduced.anchors[holder.link].placement
                    )
                    expected = (link * holder.placement).homogeneous
                    assert where.homogeneous == pytest.approx(expected, abs=1e-12)


def test_scenes_share_unedited_parts(arms: to.Robot) -> None:
    at = arms.positions()
    scene = to.Scene(arms).add("one", to.Sphere(0.1)).add("two", to.Sphere(0.1), frame="one")
    scene = scene.add("three", to.Sphere(0.1), frame="tool")
    before = reduce_model(scene, "left", at)
    again = reduce_model(scene, "left", arms.positions({"left_elbow": 0.3}))
    assert (again.model, again.bodies, again.pairs) == (before.model, before.bodies, before.pairs)
    assert again.derived(placements) is before.derived(placements)
    after = reduce_model(scene.move("one", to.placement((1, 2, 3))), "left", at)
    assert after.derived(placements) is not before.derived(placements)
    assert after.model is before.model and after.pairs is before.pairs
    same = [a is b for a, b in zip(after.bodies, before.bodies, strict=True)]
    assert same == [*(True for _ in arms.bodies), False, False, True]
    assert after.attachment("two")[1].translation == pytest.approx([1, 2, 3])
    assert before.attachment("two")[1].translation == pytest.approx([0, 0, 0])


def test_joints_fixed_elsewhere_make_another_model(arms: to.Robot) -> None:
    scene = to.Scene(arms).add("held", to.Sphere(0.1), frame="tool")
    for angle in np.linspace(-1.0, 1.0, 12).tolist():
        at = arms.positions({"right_elbow": angle})
        reduced = reduce_model(scene, "left", at)
        assert reduced.attachment("held")[0] == 0
        placed = scene.placement_of("held", at).homogeneous
        assert reduced.attachment("held")[1].homogeneous == pytest.approx(placed, abs=1e-12)


def test_unknown_frames_are_refused(arms: to.Robot) -> None:
    with pytest.raises(to.TrajoptError, match="nowhere"):
        reduce_model(to.Scene(arms), "left", arms.positions()).attachment("nowhere")


@pytest.mark.parametrize("length", [0.01, 0.04, 0.4])
def test_short_chains_have_small_default_margins(tmp_path: Path, length: float) -> None:
    chain = ("palm", "near", "middle", "far")
    shape = f'<collision><geometry><sphere radius="{length / 4.0}"/></geometry></collision>'
    links = "".join(f'<link name="{name}">{shape}</link>' for name in chain)
    turns = '<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="1" effort="1"/>'
    joints = "".join(
        f'<joint name="{child}_joint" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{length} 0 0"/>{turns}</joint>'
        for parent, child in pairwise(chain)
    )
    path = tmp_path / "finger.urdf"
    path.write_text(f'<robot name="finger">{links}{joints}</robot>')
    robot = to.Robot.from_urdf(path)
    scene = to.Scene(robot).add("box", to.Box(0.1, 0.1, 0.1), to.placement((1.0, 0.0, 1.0)))
    reach = 2.25 * length  # two links, and the radius of the last
    margins = reduce_model(scene, "all", robot.positions()).pairs.margin
    np.testing.assert_allclose(margins, min(0.01, 0.02 * reach))
    wide = reduce_model(replace(scene, margin=0.03), "all", robot.positions()).pairs.margin
    np.testing.assert_allclose(wide, 0.03)
