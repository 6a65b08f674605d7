"""Room: what a motion is planned with so that it can be proven of a robot that is a little off it."""

from dataclasses import replace

from trajopt.scene.scene import Scene


def with_room(scene: Scene, off: float) -> Scene:
    """Return a scene whose clearances are larger by how far a robot can be off where it has to be.

    Args:
        scene: What is around the robot.
        off: How far any point of it can be off [m].
    """
    stated = scene.clearances
    wider = replace(
        stated,
        everywhere=stated.everywhere + off,
        pairs={pair: value + off for pair, value in stated.pairs.items()},
        links={link: value + off for link, value in stated.links.items()},
        kinds={kind: value + off for kind, value in stated.kinds.items()},
    )
    return replace(scene, clearances=wider)
