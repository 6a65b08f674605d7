"""The stages of a task that remain in the present world."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

from trajopt.scene.scene import Scene
from trajopt.tasks.grasping.grasp import Grasp, Place
from trajopt.tasks.grasping.stages import PickObject, PlaceObject
from trajopt.tasks.grasping.straight import to_configuration
from trajopt.tasks.search import Item, StageWithItems, TaskStage, as_items, flat, held_objects, is_step_of
from trajopt.tasks.stages import Fallback, FollowCurve, ForEach, MoveTo, OneOf, Together, Within
from trajopt.values.arrays import Floats

SHORT = 1e-3
"""A shorter rest of a curve counts as followed [m]."""


@dataclass(frozen=True, eq=False)
class RemainingStages:
    """The stages that remain.

    Attributes:
        done: Names of steps of the plan that are done.
        ahead: Names of steps of the plan that remain -> positions of all joints at their ends [rad | m].
        failed: Stage -> grasps that held nothing.
        followed: Stage -> length along its curve at which it was interrupted [m].
        absent: Objects that cannot be handled, although the world has them.
        skipped: Missing objects whose items were left out -> why they are missing.
    """

    scene: Scene
    group: str
    done: Collection[str]
    ahead: Mapping[str, Floats]
    failed: Mapping[str, Sequence[Grasp]]
    followed: Mapping[str, float] = field(default_factory=dict[str, float])
    absent: Collection[str] = ()
    skipped: dict[str, str] = field(default_factory=dict[str, str])

    def of(self, stages: Sequence[TaskStage]) -> list[TaskStage]:
        """Return the remaining stages in order; all before the last that is begun are done."""
        begun = [place for place, stage in enumerate(stages) if self._begun(stage)]
        after = begun[-1] + 1 if begun else 0
        rest = [left for stage in stages[after - 1 : after] for left in self._rest(stage)] if begun else []
        return [*rest, *(left for stage in stages[after:] for left in self._untouched(stage))]

    def _begun(self, stage: TaskStage) -> bool:
        if isinstance(stage, StageWithItems):
            return any(self._begun(inner) for item in as_items(stage.items) for inner in item)
        return any(is_step_of(step, stage) for step in self.done)

    def _rest(self, stage: TaskStage) -> Sequence[TaskStage]:
        if isinstance(stage, StageWithItems):
            return self._rest_of_items(stage)
        ends = [at for step, at in self.ahead.items() if is_step_of(step, stage)]
        if not ends:
            return ()
        held = held_objects(self.scene)
        handled = (isinstance(stage, PickObject) and stage.object in held) or (
            isinstance(stage, PlaceObject) and stage.object not in held
        )
        if isinstance(stage, FollowCurve) and stage.name not in self.done:
            done = self.followed.get(stage.name, 0.0)
            if stage.curve.until - done >= SHORT:
                return (replace(stage, curve=stage.curve.after(done)),)
        if handled or isinstance(stage, FollowCurve):
            return (MoveTo(to_configuration(self.scene, self.group, ends[-1]), name=stage.name),)
        return tuple(self._untouched(stage))

    def _rest_of_items(self, stage: StageWithItems) -> Sequence[TaskStage]:
        items = as_items(stage.items)
        if isinstance(stage, Together):
            return self._with_items(stage, [left for item in items if (left := self.of(item))])
        begun = [item for item in items if any(map(self._begun, item))]
        rest = [] if self._skips(stage, begun[-1]) else self.of(begun[-1])
        others = [item for item in items if item not in begun]
        if isinstance(stage, ForEach | Within):
            return self._with_items(stage, [rest, *others] if rest else others)
        return (*rest, *(() if isinstance(stage, OneOf | Fallback) else self._with_items(stage, others)))

    def _untouched(self, stage: TaskStage) -> Sequence[TaskStage]:
        if isinstance(stage, StageWithItems):
            return self._with_items(stage, as_items(stage.items))
        if isinstance(stage, PickObject) and (failed := self.failed.get(stage.name)):
            return (replace(stage, grasps=self._grasps(stage, failed) or stage.grasps),)
        return (stage,)

    def _with_items(self, stage: StageWithItems, items: Sequence[Sequence[TaskStage]]) -> Sequence[TaskStage]:
        left: list[Item] = [self.of(item) for item in items if not self._skips(stage, item)]
        if not left and items and isinstance(stage, OneOf | Fallback):
            return (stage,)
        return (cast("TaskStage", replace(cast("Any", stage), items=left)),) if left else ()

    def _skips(self, stage: TaskStage, item: Sequence[TaskStage]) -> bool:
        if not isinstance(stage, ForEach | OneOf | Fallback):
            return False
        missing = self.missing(item)
        self.skipped.update(missing)
        return bool(missing)

    def missing(self, stages: Sequence[TaskStage]) -> Mapping[str, str]:
        """Return the objects of stages that cannot be handled -> the reason."""
        found: dict[str, str] = {}
        for stage in flat(stages):
            name = str(getattr(stage, "object", ""))
            if name and name not in self.scene.objects:
                found[name] = "it is not in the world"
            elif name in self.absent:
                found[name] = "the gripper did not hold it"
            elif isinstance(stage, PickObject) and not self._grasps(stage, self.failed.get(stage.name, ())):
                found[name] = "no grasp held it"
        return found

    @staticmethod
    def _grasps(stage: PickObject, failed: Sequence[Grasp]) -> list[Grasp]:
        return [grasp for grasp in stage.grasps if not any(grasp is other for other in failed)]


def objects_of(stage: TaskStage, scene: Scene, group: str) -> set[str]:
    """Return the objects on whose places a stage depends."""
    names = {str(getattr(stage, "object", ""))}
    match stage:
        case PlaceObject():
            assert not isinstance(stage.places, Place)
            names |= {place.frame for place in stage.places}
        case FollowCurve():
            names |= {stage.curve.frame, stage.curve.reference}
        case MoveTo():
            names |= {name for required in stage.wanted(scene, group) for name in required.frames}
        case _:
            pass
    return names & set(scene.objects)
