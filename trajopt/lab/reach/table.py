"""Tables of configurations with the placements of a frame, for training, as Parquet or npz."""

from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from trajopt.geometry import Evaluator, evaluator
from trajopt.optimise.kinematics.arguments import count_of, frame_of
from trajopt.optimise.kinematics.forward import manipulability, moving_frame, stacked_jacobian
from trajopt.optimise.kinematics.sampling import BATCH, Progress
from trajopt.optimise.kinematics.validity import clear, pair_margins
from trajopt.robot.limits import draw_positions
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, Value, readonly
from trajopt.values.errors import FileFormatError, MissingExtra, ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD

HOPELESS = 100 * BATCH
"""Number of draws without a clear one after which the search ends."""
COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw", "manipulability", "clear")
"""Columns after those of the joints."""


@dataclass(frozen=True, eq=False)
class ConfigurationTable(Value):
    """Configurations, the placements of a frame, and whether they are clear of everything, one per row.

    Attributes:
        robot: Name of the robot.
        group: Its group that moves.
        frame: The frame.
        reference: The reference frame of placements.
        joint_names: The group's joints.
        positions: Shape (S, n) [rad | m].
        translation: Of the frame, shape (S, 3) [m].
        quaternion: Of the frame (x, y, z, w), w >= 0, shape (S, 4).
        manipulability: Yoshikawa's, shape (S,); see `manipulability`.
        clear: Whether all margins are kept, shape (S,).
    """

    robot: str
    group: str
    frame: str
    reference: str
    joint_names: tuple[str, ...]
    positions: Floats
    translation: Floats
    quaternion: Floats
    manipulability: Floats
    clear: Bools

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.positions)

    @checked
    def write(self, path: Path | str) -> None:
        """Write the table: `.parquet` with a column for each number, `.npz` with the arrays.

        Parquet's columns are the joints by name, then x, y, z, qx, qy, qz, qw, manipulability and clear;
        robot, group, frame and reference are in its metadata.

        Raises:
            FileFormatError: If the suffix is neither, or a joint has the name of a column.
            MissingExtra: If Parquet is requested and pyarrow is not installed.
        """
        match check_table_path(path):
            case ".npz":
                with Path(path).open("wb") as file:
                    np.savez(file, allow_pickle=False, **vars(self))
            case _:
                self._write_parquet(Path(path))

    def _write_parquet(self, path: Path) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        taken = set(COLUMNS) & set(self.joint_names)
        if taken:
            raise FileFormatError(str(path), f"joint {shown(min(taken))} is named like a column; write .npz")
        numbers = [
            *self.positions.T,
            *self.translation.T,
            *self.quaternion.T,
            self.manipulability,
            self.clear,
        ]
        columns = dict(zip((*self.joint_names, *COLUMNS), numbers, strict=True))
        facts = {name: getattr(self, name) for name in ("robot", "group", "frame", "reference")}
        facts["joints"] = ",".join(self.joint_names)
        pq.write_table(pa.table(columns).replace_schema_metadata(facts), path, write_page_checksum=True)


@checked
def sample_table(
    reduced: ReducedModel,
    frame: str,
    count: int,
    *,
    rng: np.random.Generator,
    reference: str = WORLD,
    margin: float | None = 0.0,
    only_clear: bool = True,
    progress: Progress | None = None,
) -> ConfigurationTable:
    """Draw configurations uniformly within limits and compute the placements of a frame.

    Args:
        reduced: The robot with its group's joints free, in its scene.
        frame: Link, tool frame or attached object.
        count: Number of configurations.
        rng: Random generator.
        reference: The reference frame of placements.
        margin: Clearance of a clear configuration [m]; the scene's own margins if None.
        only_clear: Whether to draw until `count` rows are clear; otherwise rows in collision count too.
        progress: Called with the number of rows so far.

    Raises:
        FrameNotFound: If a frame is unknown.
        ShapeError: If a number is invalid, or nothing is clear.
    """
    count_of("count", count)
    query, margins = evaluator(reduced), pair_margins(reduced, margin)
    frame_of(reduced, frame)
    frame_of(reduced, reference)
    parts: list[ConfigurationTable] = []
    rows = drawn = 0
    while rows < count:
        batch = draw_positions(reduced.limits, BATCH if only_clear else min(BATCH, count - rows), rng=rng)
        drawn += len(batch)
        free = clear(query, batch, margins)
        chosen = np.flatnonzero(free)[: count - rows] if only_clear else np.arange(len(batch))
        parts.append(_rows(query, frame, reference, batch[chosen], free[chosen]))
        rows += len(chosen)
        if rows == 0 and drawn >= HOPELESS:
            raise ShapeError("count", f"none of {drawn} configurations is free of collision")
        if progress is not None:
            progress(rows)
    columns = ("positions", "translation", "quaternion", "manipulability", "clear")
    whole = {name: np.concatenate([getattr(part, name) for part in parts]) for name in columns}
    return replace(parts[0], **whole)


def _rows(query: Evaluator, frame: str, reference: str, positions: Floats, free: Bools) -> ConfigurationTable:
    from scipy.spatial.transform import Rotation

    reduced = query.reduced
    at = moving_frame(query, frame, positions, reference)
    jacobian = stacked_jacobian(at)
    return ConfigurationTable(
        robot=reduced.scene.robot.name,
        group=reduced.group,
        frame=frame,
        reference=reference,
        joint_names=reduced.joint_names,
        positions=positions,
        translation=at.point,
        quaternion=Rotation.from_matrix(at.rotation).as_quat(canonical=True),
        manipulability=manipulability(jacobian),
        clear=free,
    )


@checked
def read_table(path: Path | str) -> ConfigurationTable:
    """Read a table written by `ConfigurationTable.write`.

    Raises:
        FileFormatError: If the file is missing or is not such a table.
        MissingExtra: If it is Parquet and pyarrow is not installed.
    """
    try:
        return _read_npz(path) if check_table_path(path) == ".npz" else _read_parquet(path)
    except (OSError, ValueError, KeyError) as error:
        raise FileFormatError(str(path), f"holds no table of configurations: {error}") from error


def check_table_path(path: Path | str) -> str:
    """Return the suffix of a table's file, once it is known that it can be written and read.

    Raises:
        FileFormatError: If it is neither `.npz` nor `.parquet`.
        MissingExtra: If it is Parquet and pyarrow is not installed.
    """
    suffix = Path(path).suffix
    if suffix not in (".npz", ".parquet"):
        raise FileFormatError(str(path), "a table is written as .parquet or .npz")
    if suffix == ".parquet" and find_spec("pyarrow") is None:
        raise MissingExtra("pyarrow", "parquet")
    return suffix


def _read_npz(path: Path | str) -> ConfigurationTable:
    with np.load(path) as file:
        return ConfigurationTable(
            robot=str(file["robot"]),
            group=str(file["group"]),
            frame=str(file["frame"]),
            reference=str(file["reference"]),
            joint_names=tuple(file["joint_names"].tolist()),
            positions=readonly(file["positions"]),
            translation=readonly(file["translation"]),
            quaternion=readonly(file["quaternion"]),
            manipulability=readonly(file["manipulability"]),
            clear=file["clear"],
        )


def _read_parquet(path: Path | str) -> ConfigurationTable:
    import pyarrow.parquet as pq

    table = pq.read_table(path, page_checksum_verification=True)
    facts = {key.decode(): value.decode() for key, value in (table.schema.metadata or {}).items()}
    joints = tuple(facts["joints"].split(","))

    def stack(names: tuple[str, ...]) -> Floats:
        columns = [table[name].to_numpy().astype(np.float64) for name in names]
        return readonly(np.stack(columns, axis=1))

    return ConfigurationTable(
        robot=facts["robot"],
        group=facts["group"],
        frame=facts["frame"],
        reference=facts["reference"],
        joint_names=joints,
        positions=stack(joints),
        translation=stack(COLUMNS[:3]),
        quaternion=stack(COLUMNS[3:7]),
        manipulability=readonly(stack(COLUMNS[7:8])[:, 0]),
        clear=table["clear"].to_numpy().astype(np.bool_),
    )
