"""Arguments that are right, for trying each of the others wrong; and what is not tried, with the reason."""

import inspect
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, get_args

import numpy as np

import trajopt as to
from tests.lab.campaign.samples import campaign_samples
from tests.lab.perception.scenes import cameras
from tests.server.samples import served
from tests.server.warehouse.samples import samples_of_the_warehouse
from trajopt.driving import (
    CommittedMotion,
    Fault,
    FaultKind,
    Guard,
    IdealExecutor,
    JointVelocities,
    Logbook,
    Order,
    Player,
    Recorder,
    Recording,
    Servo,
    Stream,
    Supervisor,
    TimedOrder,
)
from trajopt.optimise.methods import Knots
from trajopt.optimise.solvers import Sqp
from trajopt.optimise.terms import Velocity, Window
from trajopt.optimise.transcription import transcribe
from trajopt.tasks.cartesian import follows_curve, line
from trajopt.tasks.grasping import Grasp, Gripper, Place, Stage, gripper_of
from trajopt.values.trajectory import Path as JointPath
from trajopt.verify import Judge

RETURNED = frozenset(
    """
    Placement Plan Result Robot Scene BaseJoint MovingBase RobotBase Requirement Curve Executed Followed
    FollowsCurve StopReason PickPlaceResult Segment Timeline Exported CurveMap ConfigurationTable
    InverseSolutions Placements RandomConfigurations ReachMap SelfMotion Validity RequestFile SceneFile
    Choice Decoded Iteration SolveResult SqpStep KnotsNlp Clearance Exceeded FunctionResidual
    SoftClearance SoftDistance RetimeFailure Retimed Certificate Check Counts Examination OutOfLimit
    Overload PairClearance PairDistance Unproven Verdict ContactInterval PoseError Rollout SequenceLog
    TrackingError Viewer ProblemChange Explanation NearestFree Price Remedy Moment RunOutcome Finding
    PairEvidence ProposedGroup SrdfProposal Attempt BudgetTracker PlanningWorkspace Phase Instance
    Definition Track Prediction PathTime Event RobotState Rule RunReport TaskReport StopTaken RecordedMoment
    Recording Sighting RecordedMotion LiveView MirrorView RunViewer ServoPage Entry Cloud Cluster FlatPart
    Mount Perceived Radius CampaignFolder Progress ProblemSource Dataset Extracted CampaignSummary
    Comparison Memory Session AsyncSession SessionCalls Reply Watch Decision IterationRecord
    ExecutionOutcome ServiceSession
    """.split()
)
"""Classes that a function returns, and that no caller makes: their constructors are not tried."""
INNER = frozenset(
    """
    KnotsNlp Events again_after document_of error_of refusal_of
    BudgetTracker PlanningWorkspace TrustRegion Judge.certify Judge.decide Judge.check
    check_requirement constrain Lens.bent Lens.straightened Lens.stretch Intrinsics.pixels_of
    DepthNoise.sigma DepthNoise.sigmas DepthImage.taken PointCloud.taken Options.plan Campaign.tasks
    CampaignFolder.write Local.pool Ray.pool ServiceSession.move ServiceSession.replace Cancellation.of
    Watch.progress Watch.incumbent Problem.evaluator
    """.split()
)
"""What only planning, or perception, itself calls, many times; other packages add to the last two."""
CALLED_BY_SOLVERS = frozenset({"linearise", "expression", "bounds", "excess", "objection", "by_pair"})
"""Methods of terms and methods that the program calls, with a motion of its own."""
OPEN: Mapping[str, str] = {
    "Answer.document": "JSON holds any kind of plain data, and says where it holds something else",
    "Guard.act.actions": "a policy may emit anything, and the robot then stops",
    "during.required": "a problem checks it: a term of one's own is not known where it is stated",
}
"""Arguments that take more than their annotation says, each with the reason."""
AT, FARTHER = to.placement((0.4, 0.0, 0.4)), to.placement((0.5, 0.0, 0.4))
ALONG: Mapping[str, Mapping[str, Any]] = {
    "Scene.attach": {"placement": AT},
    "distance_between": {"lower": 0.1},
    "during": {"after": "via"},
    "tool_speed": {"linear": 0.1},
}
"""Arguments that may be left out, without which a call does not look at its others."""
UP, ALONG_Y = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
HANDLING = ("pick", "place", "pick_and_place", "grasps_of")


@cache
def by_argument() -> Mapping[str, Any]:
    """Return right arguments by their name, where their kind says too little."""
    two, rows, goal = np.zeros(2), np.zeros((24, 2)), joints()
    return {
        "a": "box",
        "acceleration": (1.0, 1.0),
        "approach": UP,
        "axis": UP,
        "b": "tool",
        "begin": AT,
        "centre": AT,
        "closing": ALONG_Y,
        "cloud": to.Points(np.zeros((1, 3)), 0.01),
        "direction": UP,
        "document": {},
        "end": FARTHER,
        "eye": UP,
        "field": "f",
        "first": "tool",
        "frame": "tool",
        "goal": goal,
        "gripper": hand(),
        "group": "arm",
        "interim": (0.45, 0.02, 0.4),
        "joint": "joint1",
        "joint_names": ("joint1", "joint2"),
        "joints": ("joint1",),
        "knots": rows,
        "link": "tool",
        "lower": (-1.0, -1.0),
        "method": "sqp",
        "model": to.load("planar2").model,
        "name": "box",
        "normal": UP,
        "on": "tool",
        "openings": (0.01, 0.08),
        "part": to.during(goal, after="via"),
        "placement": AT,
        "points": np.eye(4, 3),
        "poses": (AT, FARTHER, AT),
        "positions": two,
        "problems": [problem()],
        "reference": "world",
        "region": to.Box(1.0, 1.0, 1.0),
        "required": goal,
        "rotation": np.eye(3),
        "second": "box",
        "seed": rows,
        "start": two,
        "subject": to.plan(problem()),
        "target": (1.0, 0.0, 0.2),
        "through": (0.4, 0.0, 0.4),
        "times": np.arange(3.0),
        "to": "csv",
        "upper": (1.0, 1.0),
        "value": UP,
        "velocity": (1.0, 1.0),
        "watched": Servo(ideal(), problem()),
        "weights": {"joint1": 1.0},
        "x0": rows,
        "grasps": (Grasp(placement=AT, width=0.03, opening=0.06),),
    }


@cache
def by_call() -> Mapping[str, Any]:
    """Return right arguments by "function.argument", where the argument's name says too little."""
    two, goal = np.zeros(2), joints()
    return {
        "pallet.corner": AT,
        "pallet.counts": (2, 2, 1),
        "pallet.steps": (0.1, 0.1, 0.1),
        "pallet.access": (0.0, 0.0, 0.0),
        "CameraView.target": UP,
        "LostManipulability.reference": 1.0,
        "Path.knots": np.zeros((3, 2)),
        "ReachMap.centres.axis": 0,
        "Track.constant_velocity.velocity": UP,
        "Fault.begin": 0.0,
        "Fault.end": 1.0,
        "SimulatedExecutor.change.begin": 0.0,
        "Supervisor.executor": ideal(),
        "Supervisor.follow_goal.goal": "tool",
        "Supervisor.follow_goal.tool": "tool",
        "Guard.executor": ideal(),
        "Guard.act_poses.poses": [AT],
        "Servo.executor": ideal(),
        "Servo.command.command": JointVelocities({"joint1": 0.1}),
        "Order.command": JointVelocities({"joint1": 0.1}),
        "Stream.orders": (said(),),
        "Played.stream": Stream((said(),)),
        "Recorder.source": played(),
        "Logbook.look.watched": Servo(ideal(), problem()),
        "write_recording.recording": recording(),
        "view_run.recording": recording(),
        "guide.servo": Servo(ideal(), problem()),
        "guide.source": played(),
        "JointVelocities.velocities": {"joint1": 0.1},
        "Track.of.motion": to.plan(problem()),
        "Track.through.placements": (AT, FARTHER),
        "Track.through.times": (0.0, 1.0),
        "Gripper.fingers": ("left", "right"),
        "RestPosture.positions": {"joint1": 0.1},
        "Robot.frame.name": "tool",
        "Robot.group.name": "arm",
        "Robot.state.name": "home",
        "RobotBase.rolling.moved": (),
        **dict.fromkeys(("Scene.add.name", "Scene.with_cloud.name"), "new"),
        "Scene.add.shape": to.Sphere(0.1),
        "Scene.detach.at": two,
        "Scene.with_robot_in_motion.motion": to.plan(problem()),
        "Scene.with_robot_in_motion.name": "other",
        "Scene.with_tool.name": "tcp",
        "ToolLimits.names": ("a",),
        "ToolLimits.speeds": np.zeros,
        "Trajectory.between.begin": 0.2,
        "Trajectory.between.end": 0.6,
        "Trajectory.positions": np.zeros((3, 2)),
        "view.motion": to.plan(problem()),
        "simulate.motion": to.plan(problem()),
        "any_of.goals": {"a": goal},
        "compare.methods": ["sqp"],
        "exporter_named.name": "csv",
        **dict.fromkeys(("follow.required", "curve_map.required"), follows_curve("tool", line(AT, FARTHER))),
        "import_modules.package": "trajopt.optimise.terms",
        "joint_positions.positions": {"joint1": 0.1},
        "load.robot": "planar2",
        "manipulability.reference": 1.0,
        "method_named.name": "sqp",
        "named_problem.name": "planar_fold",
        "Mesh.vertices": np.eye(3),
        "Mesh.faces": [(0, 1, 2)],
        "place.scene": carried(),
        "point_on_arc.tolerance": 0.01,
        "rail.acceleration": 1.0,
        "rail.lower": -1.0,
        "rail.upper": 1.0,
        "rail.velocity": 1.0,
        "raster.mesh": to.Mesh(np.eye(3), np.array([(0, 1, 2)], dtype=np.int32)),
        "raster.face": 0,
        "render.motion": Path("nothing.png"),
        "rest_posture.positions": {"joint1": 0.1},
        "straight_line.knots": 3,
        **{f"{call}.start": "ready" for call in HANDLING},
        **{f"{call}.name": "cup" for call in HANDLING},
        **{f"{call}.scene": held() for call in HANDLING if call != "place"},
    } | samples_of_the_warehouse(goal)


@cache
def carried() -> to.Scene:
    return held().attach("cup", "panda_hand", placement=AT)


@cache
def held() -> to.Scene:
    return to.Scene(to.load("panda")).add("cup", to.Cylinder(0.03, 0.1), AT)


@cache
def problem() -> to.Problem:
    scene = to.Scene(to.load("planar2")).add("box", to.Box(0.1, 0.1, 0.1), to.placement((1, 1, 1)))
    return to.Problem(scene=scene, start="home", goal=joints())


@cache
def joints() -> to.Requirement:
    return to.joint_positions({"joint1": 0.2})


@cache
def hand() -> Gripper:
    return gripper_of(to.load("panda"))


@cache
def pool() -> tuple[Any, ...]:
    """Return things of many kinds: an argument is the first that fits its annotation."""
    asked = problem()
    moving = to.Trajectory(("joint1", "joint2"), np.linspace(0.0, 1.0, 5), np.zeros((5, 2)))
    return (
        0.1,
        3,
        False,
        "box",
        asked,
        asked.reduced,
        asked.scene,
        asked.scene.robot,
        moving,
        joints(),
        AT,
        Sqp(),
        Path("nothing.csv"),
        np.random.default_rng(0),
        JointPath(("joint1", "joint2"), np.zeros((3, 2))),
        hand(),
        to.Sphere(0.1),
        transcribe(asked, np.zeros((24, 2))),
        Velocity(),
        asked.limits,
        Window(),
        to.Budget(),
        Stage.APPROACH,
        follows_curve("tool", line(AT, FARTHER)),
        line(AT, FARTHER),
        lambda *_: np.zeros(2),
        {},
        (),
        np.zeros(0),
        None,
    )


def sample(call: str, parameter: inspect.Parameter, fits: Callable[[Any], bool]) -> Any:
    """Return an argument that is right for a parameter of a call; `fits` says what is of its kind."""
    calls = by_call() | campaign_samples(problem())
    for known, name in ((calls, f"{call}.{parameter.name}"), (by_argument(), parameter.name)):
        if name in known:
            return known[name]
    for value in pool():
        if fits(value):
            return value
    kinds = [
        each for each in (parameter.annotation, *get_args(parameter.annotation)) if inspect.isclass(each)
    ]
    assert kinds, f"give a sample of {parameter.name} of {call} in tests/public_samples.py"
    assert kinds[0].__module__ != "builtins", f"give a sample of {parameter.name} of {call}"
    return object.__new__(kinds[0])  # of what only planning makes


@cache
def instances() -> Mapping[str, Any]:
    """Return an instance of each class whose methods look at it before they look at their arguments."""
    asked = problem()
    return {
        "Problem": asked,
        "Scene": asked.scene,
        "Robot": asked.scene.robot,
        "Curve": line(AT, FARTHER),
        "Mesh": to.Mesh(np.eye(3), np.array([(0, 1, 2)], dtype=np.int32)),
        "Gripper": hand(),
        "Trajectory": to.Trajectory(("joint1", "joint2"), np.linspace(0.0, 1.0, 5), np.zeros((5, 2))),
        "Judge": Judge(asked.reduced),
        "Place": Place(placement=AT),
        "Knots": Knots(),
        "Sqp": Sqp(),
        "CommittedMotion": CommittedMotion(("joint1", "joint2"), np.zeros(2)),
        "IdealExecutor": ideal(),
        "Fault": Fault(kind=FaultKind.LOST_COMMANDS, begin=0.0, end=1.0),
        "Supervisor": Supervisor(ideal(), asked),
        "Guard": Guard(asked.scene, asked.group, ideal()),
        "Servo": Servo(ideal(), asked),
        "Order": said().order,
        "Logbook": Logbook(),
        "Player": played(),
        "Recorder": Recorder(played()),
        **cameras(asked.scene, "arm"),
        "Stream": Stream((said(),)),
        **served(asked.scene.robot),
    }


def recording() -> Recording:
    logbook = Logbook()
    logbook.look(Servo(ideal(), problem()))
    return logbook.recording


def said() -> TimedOrder:
    return TimedOrder(Order(command=JointVelocities({"joint1": 0.1})), 0.0, 0.1)


def played() -> Player:
    return Player(Stream((said(),)))


def ideal() -> IdealExecutor:
    return IdealExecutor(("joint1", "joint2"), np.zeros(2))
