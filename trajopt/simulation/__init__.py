"""Simulation in MuJoCo: physics of robot and scene, and pictures of them."""

from trajopt.simulation.camera import CameraView as CameraView
from trajopt.simulation.depth_camera import DepthCamera as DepthCamera
from trajopt.simulation.depth_camera import Flaws as Flaws
from trajopt.simulation.execution import build_spec as build_spec
from trajopt.simulation.execution import simulate as simulate
from trajopt.simulation.execution import simulate_phases as simulate_phases
from trajopt.simulation.rendering import Layout as Layout
from trajopt.simulation.rendering import render as render
from trajopt.simulation.rollout import ContactInterval as ContactInterval
from trajopt.simulation.rollout import Friction as Friction
from trajopt.simulation.rollout import Phase as Phase
from trajopt.simulation.rollout import PoseError as PoseError
from trajopt.simulation.rollout import Rollout as Rollout
from trajopt.simulation.rollout import SequenceLog as SequenceLog
from trajopt.simulation.rollout import SimulationOptions as SimulationOptions
from trajopt.simulation.rollout import TrackingError as TrackingError
from trajopt.values.errors import RenderingUnavailable as RenderingUnavailable
