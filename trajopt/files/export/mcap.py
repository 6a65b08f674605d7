"""A motion as an MCAP log, for Foxglove and other viewers."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from trajopt.files.export.exporter import Exported
from trajopt.files.log.mcap_log import McapLog
from trajopt.files.log.robot_messages import RobotMessages, motion, write_joint_states
from trajopt.files.log.schemas import PLAN
from trajopt.scene.reduced import ReducedModel
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

RATE = 50.0
"""Default sample rate, as of a recorded run [1/s]."""


@checked
@dataclass(frozen=True)
class Mcap:
    """A log of a motion that begins at time 0: the motion, joint states, and of a plan frames and scene.

    Attributes:
        reduced: Robot and scene; None for joint states alone. `export` sets it to those of a plan.
    """

    reduced: ReducedModel | None = None

    @checked
    def with_model(self, reduced: ReducedModel) -> "Mcap":
        return self if self.reduced is not None else replace(self, reduced=reduced)

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        """Write a motion; see `Exporter.write`.

        Raises:
            MissingExtra: If the package `mcap` is not installed.
        """
        log, rate = McapLog(), RATE if hz is None else hz
        samples = trajectory.sampled(rate)
        log.add(PLAN, 0.0, motion(0.0, trajectory))
        notes = (f"{rate:g} samples per second, and the motion's own points in {PLAN.name}", "rad, m and s")
        assert samples.velocities is not None and samples.accelerations is not None
        states = np.stack((samples.positions, samples.velocities, samples.accelerations), axis=1)
        write_joint_states(log, samples.joint_names, samples.times, states)
        if self.reduced is None:
            notes = (*notes, "without frames and scene: those of a plan or bundle are included")
        else:
            positions = samples.ordered(self.reduced.joint_names).positions
            RobotMessages(self.reduced).write(log, samples.times, positions, samples.times)
        log.save(path)
        return Exported(path, len(samples.times), samples.duration, notes)
