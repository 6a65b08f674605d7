"""Whether a configuration is free, by Pinocchio and Coal alone: balls and links as Coal's own geometries."""

from importlib import import_module
from typing import Any

import numpy as np
import pinocchio as pin

import trajopt as to
from trajopt.scene.reduced import ReducedModel
from trajopt.verify.kernel.shapes import coal_geometry

coal: Any = import_module("coal")  # its managers of objects are not in our stubs


class Checker:
    """A robot next to a cloud.

    It reads which bodies and pairs there are, and nothing of how they are measured.
    """

    def __init__(self, reduced: ReducedModel, cloud: to.Points) -> None:
        """Make Coal's geometries, and a tree of its own over all balls."""
        self._model, self._data = reduced.model, reduced.model.createData()
        self._reduced = reduced
        bodies = reduced.bodies
        robot = [number for number, body in enumerate(bodies) if not isinstance(body.shape, to.Points)]
        self._links = {number: coal_geometry(bodies[number].shape) for number in robot}
        self._objects = {number: coal.CollisionObject(self._links[number]) for number in robot}
        pairs = list(zip(reduced.pairs.first.tolist(), reduced.pairs.second.tolist(), strict=True))
        self._own = [(a, b) for a, b in pairs if a in self._links and b in self._links]
        self._beside = sorted(
            {a if a in self._links else b for a, b in pairs if (a in self._links) != (b in self._links)}
        )
        ball = coal.Sphere(cloud.radius)
        self._balls = [
            coal.CollisionObject(ball, coal.Transform3s(np.eye(3), point)) for point in cloud.points
        ]
        self._tree = coal.DynamicAABBTreeCollisionManager()
        self._tree.registerObjects(self._balls)
        self._tree.setup()

    def free(self, positions: np.ndarray) -> bool:
        """Say whether nothing touches at a configuration of the group, shape (n,)."""
        reduced = self._reduced
        configuration = reduced.configuration(positions)
        pin.forwardKinematics(self._model, self._data, configuration)
        for number, item in self._objects.items():
            body = reduced.bodies[number]
            joint = self._data.oMi[body.joint]
            item.setTransform(
                coal.Transform3s(
                    joint.rotation @ body.placement.rotation,
                    joint.rotation @ body.placement.translation + joint.translation,
                )
            )
            item.computeAABB()
        for number in self._beside:
            callback = coal.CollisionCallBackDefault()
            self._tree.collide(self._objects[number], callback)
            if callback.data.result.isCollision():
                return False
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        for a, b in self._own:
            result.clear()
            if coal.collide(self._objects[a], self._objects[b], request, result):
                return False
        return True
