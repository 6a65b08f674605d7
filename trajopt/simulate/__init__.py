"""Simulation in MuJoCo: the same robot and scene under physics, and pictures of them."""

from trajopt.simulate.before_mujoco import load_mujoco as load_mujoco
from trajopt.simulate.camera import CameraView as CameraView
from trajopt.simulate.contacts import Contact as Contact
from trajopt.simulate.loose import Friction as Friction
from trajopt.simulate.offscreen import RenderingUnavailable as RenderingUnavailable
from trajopt.simulate.options import SimulationOptions as SimulationOptions
from trajopt.simulate.phases import Phase as Phase
from trajopt.simulate.phases import SequenceLog as SequenceLog
from trajopt.simulate.phases import simulate_phases as simulate_phases
from trajopt.simulate.rendering import Layout as Layout
from trajopt.simulate.rendering import render as render
from trajopt.simulate.rollout import PoseError as PoseError
from trajopt.simulate.rollout import Rollout as Rollout
from trajopt.simulate.rollout import TrackingError as TrackingError
from trajopt.simulate.spec import build_spec as build_spec
from trajopt.simulate.stepping import simulate as simulate
