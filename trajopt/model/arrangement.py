"""Everything in a scene that can collide, by the joint that carries it, and what must keep apart."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from trajopt.model.fixed_body import Anchor, FixedBody
from trajopt.model.pairs import BodyPairs, ContactRules, body_pairs
from trajopt.model.reduced_robot import ReducedRobot
from trajopt.model.scene import Scene


@dataclass(frozen=True, eq=False)
class Arrangement:
    """A scene's bodies, fixed to the joints of a reduced robot.

    Attributes:
        anchors: Where each frame of the robot, each object and the world is fixed, by name.
        bodies: Collision bodies of links, then of objects.
        pairs: Those that must keep apart.
        kept: What was derived of a reduced model with these bodies, by the function that built it.
    """

    anchors: Mapping[str, Anchor]
    bodies: tuple[FixedBody, ...]
    pairs: BodyPairs
    kept: dict[Callable[..., Any], Any] = field(
        default_factory=dict[Callable[..., Any], Any], init=False, repr=False
    )


def arrange(scene: Scene, robot: ReducedRobot) -> Arrangement:
    """Fix a scene's bodies to the joints of its reduced robot.

    The scene remembers the answer. An edited scene shares with the one before the bodies of all
    objects that stayed where they were, and the pairs if the edit changes none.

    Args:
        scene: The scene.
        robot: The scene's robot with one group's joints free.
    """
    return scene.arrangements.get(robot, lambda: _arranged(scene, robot))


def _arranged(scene: Scene, robot: ReducedRobot) -> Arrangement:
    anchors = dict(robot.anchors)
    for name in scene.objects:
        _anchor(name, scene, anchors)
    bodies = list(robot.bodies)
    for item in scene.objects.values():
        bodies.extend(item.anchored(anchors[item.frame]).bodies)
    objects = tuple(item.contact_traits for item in scene.objects.values())
    key = (objects, scene.allowed, scene.margin, scene.pair_margins, scene.allowances)
    return Arrangement(
        anchors,
        tuple(bodies),
        robot.pairs.get(key, lambda: body_pairs(bodies, scene.robot.links, _rules(scene))),
    )


def _anchor(name: str, scene: Scene, anchors: dict[str, Anchor]) -> Anchor:
    """Return where a frame or object is fixed, and enter it: objects may stand on later ones."""
    found = anchors.get(name)
    if found is None:
        item = scene.objects[name]
        found = anchors[name] = item.anchored(_anchor(item.frame, scene, anchors)).anchor
    return found


def _rules(scene: Scene) -> ContactRules:
    touched = {name: item.touch_links for name, item in scene.objects.items() if item.touch_links}
    return ContactRules(scene.allowed, touched, scene.margin, scene.pair_margins, scene.allowances)
