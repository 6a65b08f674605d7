"""The arm that the bridge of these tests serves."""

from tests.ros.commander.conftest import lab_arm

__all__ = ["lab_arm"]
