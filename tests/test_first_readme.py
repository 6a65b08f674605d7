"""The names that the first README used go on working: its code, as it was printed."""

import re

import pytest

import trajopt as to

FIRST_PLAN = """
import numpy as np
import trajopt as to

panda = to.load("panda")  # or to.load("my_arm.urdf", srdf="my_arm.srdf")
scene = (
    to.Scene(panda)
    .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    .add("pillar", to.Cylinder(radius=0.05, length=0.8), to.placement((0.55, 0.0, 0.4)))
)
problem = to.Problem(
    scene=scene,
    group="panda_arm",
    start="ready",
    goal=to.frame_placement("panda_hand_tcp", to.placement((0.4, 0.3, 0.3), rpy=(np.pi, 0, 0))),
    constraints=[to.axis_alignment("panda_hand_tcp", direction=(0, 0, -1), tolerance=0.1)],
)
print(problem)
result = to.plan(problem)
print(result.reason)  # how it ended, in a sentence; result.explain() says why, and what would change it
plan = result.require()  # raises with the reason if there is no plan
print(plan.certificate)  # every check: value, bound, where, when, proven or not
q = plan.trajectory(np.linspace(0.0, plan.trajectory.duration, 100))
"""

STEPS = """
from trajopt.planning.seeds import straight_line
from trajopt.optimise.transcription import fixed_goal, transcribe
from trajopt.optimise.solvers import Sqp
from trajopt.timing import retime
from trajopt.verify import verify
from trajopt.simulation import simulate, render
from trajopt.viewer import view

rollout = simulate(problem.reduced, plan.trajectory)  # MuJoCo, from the same robot and scene
render(problem.reduced, rollout, "motion.gif")
view(problem.reduced, plan.trajectory).wait()  # in the browser, with a slider over time
"""

MOTIONS = """
from trajopt.tasks.cartesian import follow, follows_curve, polyline
from trajopt.tasks.grasping import Place, grasps_of, gripper_of, pick_and_place
from trajopt.tasks.grasping.simulation import simulate_handling

scene = (
    to.Scene(panda)
    .add("table", to.Box(0.9, 1.4, 0.04), to.placement((0.65, 0.0, -0.02)))
    .add("cup", to.Cylinder(radius=0.03, length=0.12), to.placement((0.5, -0.2, 0.06)), mass=0.2)
)
here = scene.placement_of("panda_hand_tcp", panda.positions("ready"))
corners = [here, here * to.placement((0, -0.2, 0)), here * to.placement((0, -0.2, 0.15))]
wiped = follow(
    scene, follows_curve("panda_hand_tcp", polyline(corners, blend=0.03)), group="panda_arm", start="ready"
)
print(wiped.fraction, wiped.stop)  # 1.0 None; or which pair, limit or jump ended it, and where

carried = pick_and_place(
    scene,
    "cup",
    group="panda_arm",
    start="ready",
    grasps=grasps_of(scene, "cup", gripper_of(panda)),
    places=Place(placement=to.placement((0.5, 0.25, 0.06))),
)
print(carried.explain())
print(simulate_handling(carried).summary())  # in MuJoCo: friction alone holds the cup
"""

WINDOWS = re.compile(r"^(render|view)\(.*$", re.MULTILINE)
"""What opens a window or writes a film."""


def test_its_code_runs(capsys: pytest.CaptureFixture[str]) -> None:
    try:
        to.load("panda")
    except to.MissingExtra as error:
        pytest.skip(str(error))
    code = WINDOWS.sub("", FIRST_PLAN + STEPS + MOTIONS)
    names: dict[str, object] = {}
    exec(compile(code, "the first README", "exec"), names)
    printed = capsys.readouterr().out
    assert "SOLVED" in printed and "1.0 None" in printed and "the fingers held the object" in printed
    assert all(callable(names[name]) for name in ("render", "view", "fixed_goal", "retime", "verify"))
