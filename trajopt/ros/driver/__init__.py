"""Robot drivers for ROS: an executor for `FollowJointTrajectory`, through a rosbridge server."""

from trajopt.ros.driver.executor import FollowJointTrajectoryExecutor as FollowJointTrajectoryExecutor
