"""What an object rests on: the objects that it touches and that the robot does not carry."""

from trajopt.geometry.gap import TOUCHING, gap
from trajopt.scene.scene import Scene
from trajopt.values.placement import WORLD, Placement


def supports(scene: Scene, name: str, where: Placement) -> tuple[str, ...]:
    """Return the objects, at rest or moved by themselves, that an object touches when the clock shows 0.

    Args:
        scene: The scene.
        name: The object.
        where: Its placement in the world.
    """
    own = [(where * placed, shape) for shape, placed in scene.object(name).parts]
    found = (
        body.owner
        for body in scene.object_bodies()
        if body.owner != name
        and body.frame == WORLD
        and any(abs(gap(placed, shape, body.placement, body.shape)) < TOUCHING for placed, shape in own)
    )
    return tuple(dict.fromkeys(found))
