"""A scene as it is at a moment: what moves stands where it is then, what is not there is left out."""

from dataclasses import replace

from trajopt.model.scene import Scene
from trajopt.model.scene_object import SceneObject
from trajopt.model.timing import ALWAYS


def still(scene: Scene, time: float) -> Scene:
    """Return the scene at a time of its clock [s]; nothing in it changes any more.

    What is no longer known stands where it was known last. What carries something is kept, there or not.
    """
    if not scene.changing:
        return scene
    fixed = {name: _fixed(item, time) for name, item in scene.objects.items()}
    found = replace(scene, objects=fixed)
    carrying = {item.frame for item in fixed.values()}
    for name, item in scene.objects.items():
        if not item.timing.appears <= time <= item.timing.expires and name not in carrying:
            found = found.remove(name)
    return found


def _fixed(item: SceneObject, time: float) -> SceneObject:
    motion = item.timing.motion
    where = item.placement if motion is None else motion.track.at(min(time, motion.until))
    return replace(item, placement=where, timing=ALWAYS)
