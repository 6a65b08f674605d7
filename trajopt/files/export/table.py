"""CSV table of samples, for programs that do not read ROS messages."""

import csv
import io
from dataclasses import dataclass
from pathlib import Path

from trajopt.files.export.exporter import Exported
from trajopt.files.export.sampled import excess
from trajopt.values.documents.document import write_text
from trajopt.values.errors.arguments import checked
from trajopt.values.trajectory import Trajectory

TABLE_RATE = 100.0
"""Default sample rate, common for control loops in Python [1/s]."""


@dataclass(frozen=True)
class Csv:
    """One row per sample: time, then position, velocity and acceleration of each joint, in SI units."""

    @checked
    def write(self, trajectory: Trajectory, path: Path, hz: float | None) -> Exported:
        """Write a motion; see `Exporter.write`."""
        rate = TABLE_RATE if hz is None else hz
        samples = trajectory.sampled(rate)
        assert samples.velocities is not None and samples.accelerations is not None
        columns = [
            f"{what}_{name}"
            for what in ("position", "velocity", "acceleration")
            for name in samples.joint_names
        ]
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(["time", *columns])
        for time, *rows in zip(
            samples.times, samples.positions, samples.velocities, samples.accelerations, strict=True
        ):
            table.writerow([float(time), *(float(value) for row in rows for value in row)])
        write_text(path, text.getvalue())
        notes = (
            f"{rate:g} samples per second; the last row is the end itself, its step may be shorter",
            "time in s; positions in rad or m, with velocities and accelerations per s and s^2",
            *excess(trajectory, samples),
        )
        return Exported(path, len(samples.times), samples.duration, notes)
