"""Motion planning for robot arms by optimisation, with a proof of what was asked.

The short way is here: a robot, a scene, a problem, `plan`; then `explain`, `simulate`, `view` and `render`
take the result. The steps that `plan` is made of are in `trajopt.planning`, `trajopt.transcription`,
`trajopt.solvers`, `trajopt.retime` and `trajopt.verify`. `trajopt.simulate` and `trajopt.view` are functions
here and packages to import from; `bases` says how a robot's base moves.
"""

from trajopt.benchmark import compare as compare
from trajopt.benchmark import expected_status as expected_status
from trajopt.cartesian import follow as follow
from trajopt.errors import MissingExtra as MissingExtra
from trajopt.errors import TrajoptError as TrajoptError
from trajopt.explanation import explain as explain
from trajopt.grasping import pick_and_place as pick_and_place
from trajopt.kinematics import goal_configurations as goal_configurations
from trajopt.model import bases as bases
from trajopt.model.load import load as load
from trajopt.model.meshes.mesh_cover import MeshPolicy as MeshPolicy
from trajopt.model.meshes.mesh_file import load_mesh as load_mesh
from trajopt.model.placement import Placement as Placement
from trajopt.model.placement import placement as placement
from trajopt.model.requirements import *  # every kind is named there
from trajopt.model.robot import Robot as Robot
from trajopt.model.scene import Scene as Scene
from trajopt.model.shapes import Box as Box
from trajopt.model.shapes import Capsule as Capsule
from trajopt.model.shapes import Cone as Cone
from trajopt.model.shapes import Cylinder as Cylinder
from trajopt.model.shapes import Plane as Plane
from trajopt.model.shapes import Sphere as Sphere
from trajopt.model.shapes import convex as convex
from trajopt.model.tool_speed import tool_speed as tool_speed
from trajopt.model.track import Prediction as Prediction
from trajopt.model.track import Track as Track
from trajopt.model.trajectory import Trajectory as Trajectory
from trajopt.planning.attempt import plan_once as plan_once
from trajopt.planning.budget import Budget as Budget
from trajopt.planning.judgement import judge as judge
from trajopt.planning.many import plan_many as plan_many
from trajopt.planning.plan import plan as plan
from trajopt.planning.result import Result as Result
from trajopt.planning.result import Status as Status
from trajopt.problem import Problem as Problem
from trajopt.problem import named_problem as named_problem
from trajopt.simulate import render as render
from trajopt.simulate import simulate as simulate
from trajopt.terms import Constraint as Constraint
from trajopt.terms import Cost as Cost
from trajopt.verify import Moment as Moment
from trajopt.verify import examine as examine
from trajopt.view import view as view
