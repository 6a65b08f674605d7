"""Robots ready to load: URDF, SRDF and joint limits, one sub-package each.

* ``panda``: Franka Emika Panda with its hand, 7 + 2 joints.
* ``two_pandas``: two of them side by side, with a group ``both``.
* ``ur5``: Universal Robots UR5 (CB3), 6 joints.
* ``xarm7``: UFACTORY xArm7, 7 joints.
* ``planar2``: a planar arm of two links for teaching, made of primitives.

Each sub-package holds its SRDF (groups, named states, disabled collision pairs), its
``joint_limits.yaml``, a ``SOURCE.md`` that says where every number comes from, and a
function ``load()`` that returns a ``trajopt.Robot``. ``planar2`` is complete in itself;
the URDFs and meshes of the others come from the optional package
``example-robot-data`` (``pip install "trajopt-planner[robots]"``).

Nothing here is privileged. A robot is known by name because an entry point of the
group ``trajopt.robots`` maps the name to a callable that takes no argument and returns
a ``trajopt.Robot``; any installed package adds its own robots the same way::

    # pyproject.toml of that package
    [project.entry-points."trajopt.robots"]
    my_arm = "my_package.my_arm:load"

    # my_package/my_arm/__init__.py
    from pathlib import Path

    import trajopt as to

    _HERE = Path(__file__).parent


    def load() -> to.Robot:
        return to.Robot.from_urdf(
            _HERE / "my_arm.urdf",
            srdf=_HERE / "my_arm.srdf",
            limits=_HERE / "joint_limits.yaml",
            package_dirs=(_HERE,),
            name="my_arm",
        )
"""
