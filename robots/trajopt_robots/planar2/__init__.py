"""Planar arm of two links, for teaching and tests."""

from pathlib import Path

import trajopt as to

__all__ = ["load"]

_HERE = Path(__file__).parent


def load() -> to.Robot:
    """Load the planar arm: two joints [rad] about the vertical, links of 0.4 m + 0.5 m.

    Group ``arm``; states ``home``, ``ready`` and ``folded``; tool frame ``tool``, the
    tip of the stylus. The tip moves in the plane z = 0.14 m of ``base_link``; folded
    far enough, the second link strikes the column of the first joint.

    Returns:
        The robot; it needs no optional package.
    """
    return to.Robot.from_urdf(
        _HERE / "planar2.urdf",
        srdf=_HERE / "planar2.srdf",
        limits=_HERE / "joint_limits.yaml",
        package_dirs=(),
        name="planar2",
    )
