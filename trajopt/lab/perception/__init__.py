"""Measurements of cameras as obstacles.

A motion is proven clear of the measured points, never of the world.
"""

from trajopt.lab.perception.calibration import Mount as Mount
from trajopt.lab.perception.calibration import read_camera_info as read_camera_info
from trajopt.lab.perception.calibration import read_hand_eye as read_hand_eye
from trajopt.lab.perception.clusters import Cluster as Cluster
from trajopt.lab.perception.clusters import Clustering as Clustering
from trajopt.lab.perception.clusters import Flatness as Flatness
from trajopt.lab.perception.clusters import FlatPart as FlatPart
from trajopt.lab.perception.clusters import clusters as clusters
from trajopt.lab.perception.clusters import planes as planes
from trajopt.lab.perception.clusters import without as without
from trajopt.lab.perception.depth_image import DepthImage as DepthImage
from trajopt.lab.perception.depth_image import PointCloud as PointCloud
from trajopt.lab.perception.perceive import Cloud as Cloud
from trajopt.lab.perception.perceive import Perceived as Perceived
from trajopt.lab.perception.perceive import perceive as perceive
from trajopt.lab.perception.perceive import with_unseen as with_unseen
from trajopt.lab.perception.sensing import Radius as Radius
from trajopt.lab.perception.sensing import Sensing as Sensing
from trajopt.lab.perception.sensing import Workspace as Workspace
from trajopt.scene.camera import NOISELESS as NOISELESS
from trajopt.scene.camera import STRAIGHT as STRAIGHT
from trajopt.scene.camera import Camera as Camera
from trajopt.scene.camera import DepthNoise as DepthNoise
from trajopt.scene.camera import Intrinsics as Intrinsics
from trajopt.scene.camera import Lens as Lens
from trajopt.scene.camera import looking_at as looking_at
