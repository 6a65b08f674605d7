"""Everything in a scene that can collide, by the joint that carries it, and what must keep apart."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from trajopt.robot.bodies import Anchor, FixedBody
from trajopt.scene.collisions.pairs import BodyPairs, ContactRules, body_pairs
from trajopt.scene.reduced_robot import ReducedRobot
from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import AnchoredObject, SceneObject
from trajopt.values.cached import LruCache, cached_per_value
from trajopt.values.placement import IDENTITY


@dataclass(frozen=True, eq=False)
class CollisionModel:
    """A scene's bodies, fixed to the joints of a reduced robot.

    Attributes:
        anchors: Where each frame of the robot, each tool, each object and the world is fixed, by name.
        bodies: Collision bodies of links, then of objects.
        pairs: Those that must keep apart.
    """

    anchors: Mapping[str, Anchor]
    bodies: tuple[FixedBody, ...]
    pairs: BodyPairs


def collision_model_of(scene: Scene, robot: ReducedRobot) -> CollisionModel:
    """Fix a scene's bodies to the joints of its reduced robot.

    What changes with time is there only if the robot has joints that time drives.

    The last answers are kept for each scene. An edited scene shares with the one before the bodies of all
    objects that stayed where they were, and the pairs if the edit changes none.

    Args:
        scene: The scene.
        robot: The scene's robot with one group's joints free.
    """
    return _collision_models(scene).get(robot, lambda: _built(scene, robot))


@cached_per_value
def _collision_models(scene: Scene) -> LruCache[ReducedRobot, CollisionModel]:
    del scene
    return LruCache(4)


@cached_per_value
def _pairs(robot: ReducedRobot) -> LruCache[object, BodyPairs]:
    """Return the pairs that the scenes seen last must keep apart, by what decides on them."""
    del robot
    return LruCache(4)


@cached_per_value
def _places(item: SceneObject) -> LruCache[Anchor, AnchoredObject]:
    del item
    return LruCache(2)


def _anchored(item: SceneObject, frame: Anchor) -> AnchoredObject:
    """Return an object where it is fixed to the joint that carries its frame.

    The answer is kept as long as that anchor is the same one: all scenes that share the object share its
    bodies.
    """
    return _places(item).get(frame, lambda: item.anchored(frame))


def _built(scene: Scene, robot: ReducedRobot) -> CollisionModel:
    anchors = dict(robot.anchors)
    still = robot.driven is None
    for name in scene.placed:
        if not (still and scene.carrier(name)):
            _anchor(name, scene, anchors)
    bodies = list(robot.bodies)
    left_out = scene.changing if still else ()
    present = [item for item in scene.objects.values() if item.name not in left_out]
    for item in present:
        bodies.extend(_bodies(item, anchors))
    objects = tuple(item.contact_traits for item in present)
    tools = tuple((item.name, item.frame) for item in scene.tools.values())  # objects may be on them
    margins = (scene.margin, scene.pair_margins, scene.kind_margins)
    key = (objects, tools, scene.allowed, margins, scene.clearances, scene.allowances)
    return CollisionModel(
        anchors,
        tuple(bodies),
        _pairs(robot).get(key, lambda: body_pairs(bodies, scene.robot.links, _rules(scene, robot))),
    )


def _bodies(item: SceneObject, anchors: Mapping[str, Anchor]) -> tuple[FixedBody, ...]:
    if item.timing.motion is None:
        return _anchored(item, anchors[item.frame]).bodies
    # What moves by itself is placed by the joint that time drives.
    return replace(item, placement=IDENTITY).anchored(anchors[item.name]).bodies


def _anchor(name: str, scene: Scene, anchors: dict[str, Anchor]) -> Anchor:
    """Return where a frame or object is fixed, and enter it: objects may stand on later ones."""
    found = anchors.get(name)
    if found is None:
        item = scene.placed[name]
        found = anchors[name] = _anchored(item, _anchor(item.frame, scene, anchors)).anchor
    return found


def _rules(scene: Scene, robot: ReducedRobot) -> ContactRules:
    touched = {name: item.touch_links for name, item in scene.objects.items() if item.touch_links}
    carriers = {name: scene.holder(name).link for name in scene.objects} if scene.clearances.links else {}
    apart = scene.kind_margins or scene.clearances.kinds
    return ContactRules(
        allowed=scene.allowed,
        touch_links=touched,
        margin=scene.margin,
        pair_margins=scene.pair_margins,
        kind_margins=scene.kind_margins,
        clearances=scene.clearances,
        carriers=carriers,
        parts={name: scene.part(name) for name in (*scene.robot.links, *scene.objects)} if apart else {},
        allowances=scene.allowances,
        robot_joints=robot.model.njoints - (0 if robot.driven is None else len(robot.driven.names)),
    )
