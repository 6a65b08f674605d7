"""ROS's message packages as modules: `from trajopt.ros.commander.geometry_msgs.msg import Pose`.

Each module `msg` holds the classes of its package, from the table of `trajopt.files.messages`.
"""

import sys
from types import ModuleType

from trajopt.files.messages import class_in, classes_of

PACKAGES = (
    "geometry_msgs",
    "moveit_msgs",
    "sensor_msgs",
    "shape_msgs",
    "std_msgs",
    "trajectory_msgs",
    "visualization_msgs",
)
"""Packages whose messages MoveIt's scripts use."""


def import_package(parent: str, name: str) -> ModuleType:
    """Return the module of a message package, importable by its name from now on."""
    package = ModuleType(f"{parent}.{name}", f"Stand-in for the ROS package {name}.")
    module = ModuleType(f"{package.__name__}.msg", f"Messages of {name}.")
    vars(module).update(classes_of(name), __getattr__=class_in(name))
    vars(package).update(msg=module, __path__=[])
    sys.modules.update({each.__name__: each for each in (package, module)})
    return package
