"""Objects in the hand that still touch what they stand on at the start: how to say so."""

from trajopt.geometry.supports import supports
from trajopt.problem.problem import Problem
from trajopt.values.errors import shown
from trajopt.values.placement import WORLD


def resting_hint(problem: Problem) -> str:
    """Say how to let what is carried leave what it touches at the start; empty where nothing touches.

    Args:
        problem: The problem, whose start was refused, or whose motion meets something.
    """
    scene = problem.scene
    start = problem.reduced.all_positions(problem.reduced.start_positions)
    excused = {allowance.pair for allowance in scene.allowances if allowance.first > 0.0}
    found = [
        (name, support)
        for name in scene.objects
        if scene.holder(name).link != WORLD
        for support in supports(scene, name, scene.placement_of(name, start))
        if not scene.may_touch(name, support) and frozenset((name, support)) not in excused
    ]
    if not found:
        return ""
    name, support = found[0]
    return (
        f"; {shown(name)} touches {shown(support)} at the start: if it rests there until it is lifted, "
        f"attach it with `resting_on={support!r}`"
    )
