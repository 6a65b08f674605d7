"""Questions from folders of MoveIt scenes and requests."""

from collections.abc import Callable
from pathlib import Path

from trajopt.benchmark.folders import find_instances
from trajopt.benchmark.question import Question
from trajopt.model.robot import Robot
from trajopt.moveit import read_request, read_scene
from trajopt.problem import Problem


def file_questions(folder: Path, robot: Robot, *, limit: int | None = None) -> tuple[Question, ...]:
    """Return the MoveIt problems of a folder, named by set and number.

    Args:
        folder: Laid out as <set>/sceneNNNN.yaml, requestNNNN.yaml.
        robot: The robot they are for.
        limit: How many of each set at most.

    Raises:
        FileFormatError: If the folder holds no problem.
    """

    def maker(scene: Path, request: Path) -> Callable[[], Problem]:
        return lambda: read_request(request, read_scene(scene, robot)).problem()

    return tuple(
        Question(f"{item.set_name}/{item.index}", maker(item.scene, item.request))
        for item in find_instances(folder, limit=limit)
    )
