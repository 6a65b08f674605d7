"""Scenes in which time stands still: without what changes, or with something where it is at a time."""

from trajopt.scene.scene import Scene


def without_changes(scene: Scene) -> Scene:
    """Return a scene without what moves by itself, appears or expires."""
    left = list(scene.changing)
    while left:
        on_top = next(name for name in left if not any(scene.objects[other].frame == name for other in left))
        scene = scene.remove(on_top)
        left.remove(on_top)
    return scene


def stopped(scene: Scene, carriers: frozenset[str], time: float) -> Scene:
    """Return a scene with objects that move standing where they are at a time, without what else changes.

    Args:
        scene: The scene.
        carriers: The objects that move; what is on them is there too, unless it appears or expires.
        time: By the clock of the scene [s].
    """
    for name in carriers:
        motion = scene.objects[name].timing.motion
        if motion is not None:
            scene = scene.with_motion(name).move(name, motion.track.at(time))
    return without_changes(scene)
