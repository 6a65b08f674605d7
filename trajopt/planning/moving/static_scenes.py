"""Static scenes: without dynamic obstacles, or with them at rest at some of their places."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import ceil, inf

import numpy as np

from trajopt.scene.scene import Scene
from trajopt.scene.scene_object import SceneObject
from trajopt.scene.track import ALWAYS
from trajopt.values.arrays import Floats
from trajopt.values.placement import WORLD
from trajopt.values.shapes.shapes import bounding_box

MOST_PLACES = 24
"""Most places of one obstacle: more would enclose the arm."""


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


def at_rest(scene: Scene, carriers: frozenset[str], time: float) -> Scene:
    """Return a scene with moving objects at rest at their places of a time [s], without dynamic obstacles.

    Args:
        carriers: The moving objects; objects on them are present too, unless they appear or expire.
    """
    for name in carriers:
        motion = scene.objects[name].timing.motion
        if motion is not None:
            scene = scene.with_motion(name).move(name, motion.track.at(time))
    return without_changes(scene)


def along_tracks(scene: Scene, duration: float) -> Scene:
    """Return a scene with copies of each dynamic obstacle at rest along its track, until a time [s]."""
    return _with_copies(scene, {name: _times(scene, name, duration) for name in scene.changing})


def at_ends(scene: Scene) -> Scene | None:
    last = {name: max(_last(scene, name), 0.0) for name in _staying(scene)}
    return _with_copies(scene, {name: np.array((time,)) for name, time in last.items()}) if last else None


def _with_copies(scene: Scene, times: Mapping[str, Floats]) -> Scene:
    static = without_changes(scene)
    copies = dict[str, SceneObject]()
    for name, moments in times.items():
        item = scene.objects[name]
        for number, time in enumerate(moments.tolist()):
            placement, label = scene.placement_at(name, time), f"{name} {number}"
            copies[label] = SceneObject(label, item.parts, placement, WORLD, item.touch_links)
    return replace(static, objects={**static.objects, **copies})


def _staying(scene: Scene) -> Iterator[str]:
    for name in scene.changing:
        if scene.objects[name].timing.expires == inf and _last(scene, name) < inf:
            yield name


def _last(scene: Scene, name: str) -> float:
    carrier = scene.carrier(name)
    motion = None if carrier is None else scene.objects[carrier].timing.motion
    return -inf if motion is None else motion.track.end


def _times(scene: Scene, name: str, duration: float) -> Floats:
    """Return times at which the places of an object leave no gaps for the arm, approximately."""
    item = scene.objects[name]
    begin, end = max(item.timing.appears, 0.0), min(item.timing.expires, duration)
    if begin >= end or scene.carrier(name) is None:
        return np.array((begin,)) if begin < duration else np.empty(0)
    samples = np.linspace(begin, end, 4 * MOST_PLACES)
    points = np.array([scene.placement_at(name, time).translation for time in samples.tolist()])
    length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
    sizes = [float((np.subtract(*bounding_box(shape)[::-1])).min()) for shape, _ in item.parts]
    count = min(MOST_PLACES, 1 + ceil(length / max(min(sizes, default=length), 1e-3)))
    return np.linspace(begin, end, count)
