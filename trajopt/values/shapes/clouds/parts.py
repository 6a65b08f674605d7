"""Clouds as what they are unions of, for those who know balls and cubes only; and as fewer, larger ones."""

from trajopt.values.arrays import Floats
from trajopt.values.shapes.clouds.points import Points
from trajopt.values.shapes.clouds.voxels import Voxels
from trajopt.values.sizes import LARGEST_SIZE


def fewer(cloud: Points | Voxels, most: int) -> Points | Voxels:
    """Return a cloud of at most so many balls or cubes, larger ones, that contain those of this one.

    Args:
        cloud: The cloud; the same is returned if it has few enough.
        most: How many there may be, at least 8: so many cells of any size meet in one corner.
    """
    while len(cloud) > most:
        if isinstance(cloud, Voxels):
            cloud = Voxels(cloud.keys >> 1, 2.0 * cloud.size)
        else:
            cloud = _coarser(cloud, most)
    return cloud


def _coarser(cloud: Points, most: int) -> Points:
    """Thin a cloud by the first of doubled cells, from half a ball on, that leave few enough."""
    cell, thin = cloud.radius / 2.0, cloud
    while len(thin) > most:
        cell *= 2.0
        thin = cloud.thinned(min(cell, LARGEST_SIZE))
    return thin


def centres_of(cloud: Points | Voxels) -> Floats:
    """Return the centres of the balls or cubes of a cloud, shape (n, 3) [m]."""
    return cloud.points if isinstance(cloud, Points) else cloud.centres
