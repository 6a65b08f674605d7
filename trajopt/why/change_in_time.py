"""Changes in time: begin later, have longer, or let something that moves come later or not at all."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf, isfinite

import numpy as np

from trajopt.geometry import Counts
from trajopt.planning.infeasibility.in_time import LONGEST, LOOK, InTime
from trajopt.planning.infeasibility.reasons import Block
from trajopt.problem.problem import Problem
from trajopt.scene.scene import Scene
from trajopt.scene.timed import timed_model
from trajopt.values.arrays import Floats
from trajopt.values.placement import WORLD
from trajopt.values.printed import in_unit
from trajopt.why.change import Change

FIRST = 0.5
"""First amount of a change of times [s]: about half of what a motion takes."""
THINGS = 2
"""How many of the things in the way changes are tried for."""


def changes_in_time(problem: Problem, blocks: Sequence[Block]) -> list[Change]:
    """Return what might be changed about a problem that fails among what changes with time.

    Args:
        problem: The problem.
        blocks: What is in the way, its thing named second.
    """
    named = dict.fromkeys(block.subjects[-1] for block in blocks)
    things = [name for name in named if name in problem.scene.changing][:THINGS]
    found = [removed(problem, name) for name in things]
    found += [delayed(problem, name) for name in things if problem.scene.objects[name].frame == WORLD]
    ends = [block.end for block in blocks if block.end is not None and block.end < inf]
    later = begun_later(problem, max([FIRST, *ends]))
    deadline = None if problem.finish_by is None else longer(problem, problem.finish_by)
    return [change for change in (later, deadline, *found) if change is not None]


def begun_later(problem: Problem, first: float) -> Change | None:
    """Return the change that begins later; None where that cannot help, or nothing is known then."""
    timed, scene = timed_model(problem.reduced), problem.scene
    if timed is None or timed.until <= 2.0 * LOOK or problem.finish_by is not None:
        return None
    largest = min(LONGEST, timed.until - LOOK)
    looks: Floats = np.arange(0.0, largest, LOOK, dtype=np.float64)
    start = np.tile(problem.reduced.start_positions, (len(looks), 1))
    free = InTime(problem, timed, Counts()).occupancy.free(start, looks)

    def words(amount: float) -> str:
        swept = not free[looks <= amount].all()
        return f"start {in_unit(amount, 's')} later" + (", and be elsewhere before" if swept else "")

    return Change(
        what="time of the start",
        unit="s",
        first=min(first, largest),
        largest=largest,
        words=words,
        apply=lambda amount: replace(problem, scene=scene.at(amount)),
    )


def longer(problem: Problem, deadline: float) -> Change:
    """Return the change that puts a deadline off."""
    return Change(
        what="deadline",
        unit="s",
        first=FIRST,
        largest=LONGEST,
        words=lambda amount: f"allow {in_unit(amount, 's')} more, until {deadline + amount:.3g} s",
        apply=lambda amount: replace(problem, finish_by=deadline + amount),
    )


def may_touch(problem: Problem, link: str, name: str) -> Change:
    """Return the change that lets something touch a link."""
    touching = replace(problem, scene=problem.scene.allow(link, name))
    return Change(
        what=f"contact of {link} and {name}",
        unit="",
        first=1.0,
        largest=1.0,
        words=lambda _: f"let {name} touch {link}",
        apply=lambda amount: touching if amount >= 1.0 else problem,
        whole=True,
    )


def removed(problem: Problem, name: str) -> Change:
    """Return the change that takes something out of the scene, with what is placed on it."""
    without = replace(problem, scene=_without(problem.scene, name))
    return Change(
        what=name,
        unit="",
        first=1.0,
        largest=1.0,
        words=lambda _: f"remove {name}",
        apply=lambda amount: without if amount >= 1.0 else problem,
        whole=True,
    )


def delayed(problem: Problem, name: str) -> Change:
    """Return the change that lets something come, and go, later."""
    scene, timing = problem.scene, problem.scene.objects[name].timing
    # What was always there would come later only from where it is.
    moves = timing.motion is not None

    def apply(amount: float) -> Problem:
        motion = timing.motion
        if motion is not None:
            motion = replace(motion, track=motion.track.shifted(-amount), until=motion.until + amount)
        times = {
            "appears": timing.appears + amount if isfinite(timing.appears) else None,
            "expires": timing.expires + amount if timing.expires < inf else None,
        }
        return replace(problem, scene=scene.with_motion(name, motion, **times))

    return Change(
        what=f"time of {name}",
        unit="s",
        first=FIRST,
        largest=8.0 * FIRST,
        words=lambda amount: f"let {name} {'move' if moves else 'appear'} {in_unit(amount, 's')} later",
        apply=apply,
    )


def _without(scene: Scene, name: str) -> Scene:
    for other, item in scene.objects.items():
        if item.frame == name and other in scene.objects:
            scene = _without(scene, other)
    return scene.remove(name)
