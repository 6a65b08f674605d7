"""Perception: what cameras measure becomes obstacles, and what that is worth is said.

A cloud contains what was measured: the certificate of a motion among it says "clear of the measured points,
each with its ball", and never "clear of the world".
"""

from trajopt.model.camera import NOISELESS as NOISELESS
from trajopt.model.camera import Camera as Camera
from trajopt.model.camera import DepthNoise as DepthNoise
from trajopt.model.camera import Intrinsics as Intrinsics
from trajopt.model.camera import looking_at as looking_at
from trajopt.model.lens import STRAIGHT as STRAIGHT
from trajopt.model.lens import Lens as Lens
from trajopt.perception.camera_info import read_camera_info as read_camera_info
from trajopt.perception.cloud import Cloud as Cloud
from trajopt.perception.clusters import Cluster as Cluster
from trajopt.perception.clusters import Clustering as Clustering
from trajopt.perception.clusters import clusters as clusters
from trajopt.perception.clusters import without as without
from trajopt.perception.depth_image import DepthImage as DepthImage
from trajopt.perception.hand_eye import Mount as Mount
from trajopt.perception.hand_eye import read_hand_eye as read_hand_eye
from trajopt.perception.perceive import Perceived as Perceived
from trajopt.perception.perceive import perceive as perceive
from trajopt.perception.perceive import with_unseen as with_unseen
from trajopt.perception.planes import Flatness as Flatness
from trajopt.perception.planes import FlatPart as FlatPart
from trajopt.perception.planes import planes as planes
from trajopt.perception.point_cloud import PointCloud as PointCloud
from trajopt.perception.sensing import Sensing as Sensing
from trajopt.perception.sensing import Workspace as Workspace
from trajopt.perception.taken import Radius as Radius
