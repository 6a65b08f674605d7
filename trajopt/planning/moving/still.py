"""Static scenes: without dynamic obstacles, or with some of them at their places of a time."""

from dataclasses import replace

from trajopt.scene.scene import Scene
from trajopt.scene.timing import ALWAYS


def without_changes(scene: Scene) -> Scene:
    """Return a scene in which objects that move by themselves, appear or expire are mere frames.

    Requirements may name them: a goal on a tray that appears, an object that a line of sight ignores.
    """
    changing = set(scene.changing)
    frames = {
        name: replace(item, parts=(), mass=0.0, timing=ALWAYS) if name in changing else item
        for name, item in scene.objects.items()
    }
    return replace(scene, objects=frames) if changing else scene


def stopped(scene: Scene, carriers: frozenset[str], time: float) -> Scene:
    """Return a scene with moving objects at rest at their places of a time, without other dynamic obstacles.

    Args:
        scene: The scene.
        carriers: The moving objects; their cargo is there too, unless it appears or expires.
        time: By the clock of the scene [s].
    """
    for name in carriers:
        motion = scene.objects[name].timing.motion
        if motion is not None:
            scene = scene.with_motion(name).move(name, motion.track.at(time))
    return without_changes(scene)
