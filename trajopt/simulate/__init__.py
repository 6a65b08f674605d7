"""Simulation in MuJoCo: the same robot and scene under physics, and pictures of them.

Importing this package does not import MuJoCo; calling one of its functions does.
"""

from trajopt.errors import RenderingUnavailable as RenderingUnavailable
from trajopt.simulate.camera import CameraView as CameraView
from trajopt.simulate.contacts import Contact as Contact
from trajopt.simulate.depth_camera import DepthCamera as DepthCamera
from trajopt.simulate.depth_camera import Flaws as Flaws
from trajopt.simulate.execution import build_spec as build_spec
from trajopt.simulate.execution import simulate as simulate
from trajopt.simulate.options import Friction as Friction
from trajopt.simulate.options import SimulationOptions as SimulationOptions
from trajopt.simulate.phases import simulate_phases as simulate_phases
from trajopt.simulate.rendering import Layout as Layout
from trajopt.simulate.rendering import render as render
from trajopt.simulate.rollout import Phase as Phase
from trajopt.simulate.rollout import PoseError as PoseError
from trajopt.simulate.rollout import Rollout as Rollout
from trajopt.simulate.rollout import SequenceLog as SequenceLog
from trajopt.simulate.rollout import TrackingError as TrackingError
