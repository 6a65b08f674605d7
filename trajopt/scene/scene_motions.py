"""What moves in a scene or is seen anew: objects along tracks, other robots as planned, clouds of cameras."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import inf
from typing import Self

from trajopt.scene.planned_robot import MovingRobot, Planned, model_and_trajectory
from trajopt.scene.robot_in_motion import robot_objects
from trajopt.scene.scene_object import SceneObject, cloud_parts, object_placement, replaced_cloud
from trajopt.scene.scene_parts import SceneParts
from trajopt.scene.timing import timing_of
from trajopt.scene.track import TOLERANCE, Prediction, Track
from trajopt.values.arrays import name_of, one_of, several
from trajopt.values.errors import DuplicateObject, ModelError, shown
from trajopt.values.placement import IDENTITY, WORLD, PlacementLike, as_placement
from trajopt.values.shapes.shapes import Points, Voxels
from trajopt.values.trajectory import Trajectory


class SceneMotions(SceneParts):
    """The edits of a scene that say what moves by itself, or is seen again and again."""

    def with_motion(
        self,
        name: str,
        motion: Prediction | Track | None = None,
        *,
        appears: float | None = None,
        expires: float | None = None,
    ) -> Self:
        """Let an object move, appear and expire; see `add`.

        Raises:
            ObjectNotFound: If there is none of that id.
            ModelError: If it is to move, and is placed in another frame than the world.
            ShapeError: If it expires before it appears.
        """
        item, timing = self.object(name), timing_of(name, motion, appears, expires)
        if timing.motion is None:
            return self._with(replace(item, timing=timing))
        if item.frame != WORLD:
            raise ModelError(f"{shown(name)} is placed in {shown(item.frame)}: only in the world it moves")
        where = object_placement(name, timing.motion.track.at(0.0))
        return self._with(replace(item, timing=timing, placement=where))

    def with_robot_in_motion(
        self,
        name: str,
        motion: Planned[MovingRobot] | MovingRobot,
        trajectory: Trajectory | None = None,
        *,
        base: PlacementLike = IDENTITY,
        start: float = 0.0,
        until: float = inf,
        tolerance: float = TOLERANCE,
    ) -> Self:
        """Add another robot that moves as planned: `scene.with_robot_in_motion("left", plan, base=...)`.

        Each of its links with a shape, and what it carries, becomes an object "left/link7": on a track where
        it moves, with an error that is proven to hold how far the track is from the robot (the module
        `trajopt.scene.frame_pieces` says how). Before the motion it rests at its start, after it at its
        end. What stands in the other robot's scene is not taken over.

        Args:
            name: What its objects' ids begin with.
            motion: A plan, a result that has one, or a reduced model.
            trajectory: The motion of a reduced model; of a plan, None for its own.
            base: Of the world of the other robot's scene in this one's.
            start: When it begins, by the clock of this scene; negative if it has begun [s].
            until: Until when it is known to move so [s].
            tolerance: How far its points may be from where tracks have them; they are taken to be as near to
                everything as that. Tighter tracks have more pieces, which the judge takes longer for [m].

        Raises:
            PlanningFailed: If the result has no plan.
            ProblemError: If `motion` is neither, or the trajectory is missing.
            DuplicateObject: If an id is taken.
            ModelError: If a half-space would have to move.
            ShapeError: If a number or the placement is none.
        """
        robot, moved = model_and_trajectory("with_robot_in_motion", motion, trajectory, MovingRobot)
        if not one_of("name", name, str):
            raise ModelError("name of the robot is empty: its links could not be told from this one's")
        where = as_placement("base", base)
        added = robot_objects(name, robot, moved, base=where, start=start, until=until, tolerance=tolerance)
        for key in added:
            if key in self.placed or key in self.frame_names:
                raise DuplicateObject(key)
        return replace(self, objects={**self.objects, **added})

    def with_cloud(self, name: str, cloud: Points | Voxels | None, *, given: Iterable[str] = ()) -> Self:
        """Put what was seen into the world, in place of all that was seen before under that name.

        What else is said of the object stays: what may touch it, margins and clearances.

        Args:
            name: Of the object: a new one, or a cloud that the scene has.
            cloud: In the world, about its origin; None where nothing was seen: a mere frame remains.
            given: What is taken for granted of it, as phrases: each certificate repeats them.

        Raises:
            ModelError: If the name is one of the robot's, or of an object that is no cloud.
        """
        stated = several("given", given, str)
        if one_of("the cloud's id", name, str) in self.objects:
            return self._with(replaced_cloud(self.objects[name], cloud, stated))
        self._check_free(name)
        return self._with(SceneObject(name, cloud_parts(cloud), IDENTITY, WORLD, given=stated))

    def _check_free(self, name: str) -> None:
        """Refuse the id of an object that is taken."""
        if name_of("object id", name) in self.objects:
            raise DuplicateObject(name)
        if not name or name == WORLD or name in self.frame_names:
            raise ModelError(f"object id {shown(name)} is taken by a frame of the robot, or empty")

    def _with(self, item: SceneObject) -> Self:
        return replace(self, objects={**self.objects, item.name: item})

    def _with_tool(self, item: SceneObject) -> Self:
        return replace(self, tools={**self.tools, item.name: item})
