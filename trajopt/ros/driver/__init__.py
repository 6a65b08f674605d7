"""Drivers of robots in ROS: an executor for `FollowJointTrajectory`, through a rosbridge server."""

from trajopt.ros.driver.executor import FollowJointTrajectoryExecutor as FollowJointTrajectoryExecutor
