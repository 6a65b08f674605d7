"""An explanation as a picture."""

from dataclasses import dataclass
from math import inf
from pathlib import Path
from textwrap import wrap

import numpy as np

from trajopt.planning.infeasibility.reasons import ObstructionKind
from trajopt.problem.problem import Problem
from trajopt.problem.requirements import FramePlacement
from trajopt.scene.reduced import ReducedModel
from trajopt.scene.reducing import reduce_model
from trajopt.values.arrays import Floats
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, placement
from trajopt.values.shapes.shapes import Sphere
from trajopt.values.trajectory import Trajectory
from trajopt.why import Explanation

LETTERS = 116
"""Characters per line of the text over the picture."""
LINES = 6
GOAL_SIZE = 0.02
"""Radius of the ball at a goal [m]."""
GHOSTS = (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0)
"""Shares of a path at which the robot is shown translucent."""


MOMENT = 1e-3
"""Time between two configurations [s]: dynamic obstacles are shown at one time."""


@dataclass(frozen=True, eq=False)
class _Shown:
    configurations: Floats
    ghosts: tuple[float, ...]
    solid: float


@checked
def draw_explanation(
    explanation: Explanation, path: Path | str, *, width: int = 960, height: int = 640
) -> Path:
    """Draw the cause of a failure: the configuration that shows it, with the pair in contact in red.

    Translucent: the nearest free configuration, or else the best path, or the start; for a plan its motion.

    Args:
        width: Of the picture without the text [pixels], as `height`.

    Raises:
        FileFormatError: If the suffix is not an image format, or the folder does not exist.
        RenderingUnavailable: If OpenGL does not work.
    """
    from trajopt.simulation import Layout, render

    reduced, shown = _with_goals(explanation.problem, _clock(explanation)), _shown(explanation)
    goals = set(reduced.scene.objects) - set(explanation.problem.scene.objects)
    times = MOMENT * np.arange(len(shown.configurations), dtype=np.float64)
    last = float(times[-1])
    file = render(
        reduced,
        Trajectory(reduced.joint_names, times, shown.configurations),
        path,
        width=width,
        height=height,
        moments=[*(share * last for share in shown.ghosts), shown.solid * last],
        layout=Layout.SUPERPOSED,
        highlight=_highlight(explanation) | goals,
    )
    _add_words(file, explanation)
    return file


def _with_goals(problem: Problem, clock: float) -> ReducedModel:
    scene = problem.scene.at(clock) if problem.scene.changing else problem.scene
    for goal in problem.goals:
        if isinstance(goal, FramePlacement) and problem.scene.holder(goal.reference).link == WORLD:
            name = f"goal of {goal.frame}"
            if name not in scene.objects and np.isfinite(goal.position_tolerance).all():
                at = placement(problem.scene.holder(goal.reference).placement * goal.placement.translation)
                scene = scene.add(name, Sphere(GOAL_SIZE), at)
    return reduce_model(scene, problem.group, problem.start_positions)


def _clock(explanation: Explanation) -> float:
    for block in explanation.blocks:
        if block.begin is not None:
            end = block.begin if block.end is None or block.end == inf else block.end
            return max((block.begin + end) / 2.0, 0.0)
    return 0.0


def _shown(explanation: Explanation) -> _Shown:
    at, path = explanation.configuration, explanation.path
    start = explanation.problem.reduced.start_positions
    if path is not None:
        place = explanation.blocks[0].place if explanation.blocks else None
        return _Shown(path.knots, GHOSTS, 1.0 if place is None else place)
    beside = start if explanation.nearest_free is None else explanation.nearest_free.positions
    return _Shown(np.stack((beside, start if at is None else at)), (0.0,), 1.0)


def _highlight(explanation: Explanation) -> set[str]:
    touching = [block for block in explanation.blocks if block.kind is ObstructionKind.CONTACT]
    together = 2 if explanation.path is None else 1
    return {name for block in touching[:together] for name in block.subjects}


def _add_words(file: Path, explanation: Explanation) -> None:
    from PIL import Image, ImageDraw, ImageFont

    picture = Image.open(file).convert("RGB")
    size = max(11, picture.width // 60)
    lines = [line for part in str(explanation).splitlines() for line in wrap(part, LETTERS)]
    if len(lines) > LINES:
        lines = [*lines[: LINES - 1], lines[LINES - 1] + " ..."]
    top = (len(lines) + 1) * (size + 4)
    sheet = Image.new("RGB", (picture.width, picture.height + top), (255, 255, 255))
    sheet.paste(picture, (0, top))
    draw = ImageDraw.Draw(sheet)
    for row, line in enumerate(lines):
        draw.text((size, size // 2 + row * (size + 4)), line, (40, 44, 52), ImageFont.load_default(size))
    sheet.save(file, optimize=True)
