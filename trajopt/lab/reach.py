"""Reach maps of a frame and of a curve, and tables of sampled configurations."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from enum import Enum
from importlib.util import find_spec
from itertools import pairwise
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trajopt.geometry import Evaluator, evaluator
from trajopt.optimise.kinematics.forward import frame_of, manipulability, moving_frame, stacked_jacobian
from trajopt.optimise.kinematics.projection import Projection
from trajopt.optimise.kinematics.sampling import BATCH, Progress, Sampler
from trajopt.optimise.kinematics.validity import clear, count_of, pair_margins
from trajopt.problem.requirements import FollowsCurve, FramePlacement, frame_placement
from trajopt.problem.requirements.joints import LENGTH
from trajopt.robot.joints import draw_positions, joint_unit
from trajopt.scene.reduced import ReducedModel
from trajopt.values.arrays import Bools, Floats, Ints, Value, direction_of, floats, number, readonly
from trajopt.values.errors import FileFormatError, MissingExtra, ProblemError, ShapeError, shown
from trajopt.values.errors.arguments import checked
from trajopt.values.placement import WORLD, Placement, placement
from trajopt.values.printed import in_length

CELL = 0.05
"""Edge of a cell [m]."""
DIRECTIONS = 100
"""Directions that the sphere around each cell is divided into."""
MOST_DIRECTIONS, MOST_CELLS = 10_000, 10**8
"""Most directions and cells; more would take gigabytes."""


@dataclass(frozen=True, eq=False)
class ReachMap(Value):
    """A grid of cells over the reach of a frame, filled by sampling.

    Cell (i, j, k) is the cube that begins at `origin + cell * (i, j, k)`. A cell without a sample may still
    be reachable.

    Attributes:
        origin: Lowest corner of the grid, shape (3,) [m].
        cell: Edge [m].
        hits: Configurations with the frame in each cell, shape (X, Y, Z).
        reached: Approach directions in each cell, shape (X, Y, Z).
        manipulability: Largest in each cell, 0 without a sample, shape (X, Y, Z).
        drawn: Number of drawn configurations, including those in collision.
    """

    robot: str
    group: str
    frame: str
    reference: str
    origin: Floats
    cell: float
    hits: Ints
    reached: Ints
    directions: int
    manipulability: Floats
    valid: int
    drawn: int

    @property
    def volume(self) -> float:
        """Volume of the cells that were met [m^3]."""
        return float((self.hits > 0).sum()) * self.cell**3

    @property
    def reachability_index(self) -> Floats:
        """Share of the directions met in each cell, shape (X, Y, Z), in [0, 1].

        Source: Zacharias, Borst, Hirzinger, Capturing robot workspace structure, IROS 2007, with samples of
        the joints in place of inverse kinematics.
        """
        return self.reached / self.directions

    @checked
    def centres(self, axis: int) -> Floats:
        """Return the middles of the cells along an axis, 0 to 2 [m]."""
        middles = np.arange(self.hits.shape[axis], dtype=np.float64) + 0.5
        return float(self.origin[axis]) + self.cell * middles

    def cell_of(self, point: ArrayLike) -> tuple[int, int, int] | None:
        """Return the indices of the cell of a point; None outside of the grid."""
        i, j, k = np.floor((floats("point", point, (3,)) - self.origin) / self.cell).astype(int).tolist()
        inside = all(0 <= at < size for at, size in zip((i, j, k), self.hits.shape, strict=True))
        return (i, j, k) if inside else None

    @checked
    def save(self, path: Path | str) -> Path:
        """Write the map as a compressed npz; returns the file written, its suffix added if there was none."""
        target = Path(path) if Path(path).suffix else Path(path).with_suffix(".npz")
        if target.suffix != ".npz":
            raise FileFormatError(str(target), "a reach map is written as .npz")
        with target.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **vars(self))
        return target

    @staticmethod
    @checked
    def load(path: Path | str) -> "ReachMap":
        """Read a map that `save` wrote."""
        try:
            return ReachMap(**_read_npz(path, ReachMap))
        except (OSError, ValueError, KeyError) as error:
            raise FileFormatError(str(path), f"holds no reach map: {error}") from error

    def __str__(self) -> str:
        met, index = self.hits > 0, 100.0 * self.reachability_index
        return (
            f"{self.frame} of {self.robot} reaches {self.volume:.3f} m^3 ({int(met.sum())} cells of "
            f"{1000.0 * self.cell:g} mm) in {self.valid} valid of {self.drawn} drawn configurations; of "
            f"{self.directions} directions a cell is met from {index[met].mean():.0f} % on average, "
            f"{index.max():.0f} % at most"
        )


@checked
def reach_map(
    reduced: ReducedModel,
    frame: str,
    count: int,
    *,
    rng: np.random.Generator,
    cell: float = CELL,
    directions: int = DIRECTIONS,
    approach: ArrayLike = (0.0, 0.0, 1.0),
    reference: str = WORLD,
    margin: float | None = 0.0,
    length: float = LENGTH,
    progress: Progress | None = None,
) -> ReachMap:
    """Map the reach of a frame without collision, by random configurations.

    Args:
        count: Drawn configurations; the map omits those in collision.
        approach: Axis of the frame whose direction is counted, shape (3,).
        margin: Clearance to keep from everything [m]; the scene's own margins if None.
        length: Length of a radian in the manipulability [m].

    Raises:
        FrameNotFound: If a frame is unknown.
        ShapeError: If a number is invalid, or no configuration is free of collision.
    """
    count_of("count", count)
    if count_of("directions", directions) > MOST_DIRECTIONS:
        raise ShapeError("directions", f"must be at most {MOST_DIRECTIONS}, is {directions}")
    if number("length", length) < 0.0:
        raise ShapeError("length", f"is negative: {length:g} m")
    if not number("cell", cell) > 0.0:
        raise ShapeError("cell", f"must be positive, is {cell:g} m")
    axis = direction_of("approach", approach)
    frame_of(reduced, frame)
    frame_of(reduced, reference)
    query = evaluator(reduced)
    sampler = Sampler(query, (), pair_margins(reduced, margin), rng)
    sphere = even_directions(directions)

    def meet(size: int) -> _Met:
        at = moving_frame(query, frame, sampler.draw(size).positions, reference)
        nearest = np.argmax((at.rotation @ axis) @ sphere.T, axis=1)
        return _Met(at.point, nearest, manipulability(stacked_jacobian(at), length=length))

    met = _all_met(meet, count, progress)
    if len(met.point) == 0:
        raise ShapeError("count", f"none of {count} configurations is free of collision")
    return ReachMap(
        robot=reduced.scene.robot.name,
        group=reduced.group,
        frame=frame,
        reference=reference,
        **_grid(met, cell, directions),
        cell=cell,
        directions=directions,
        valid=len(met.point),
        drawn=count,
    )


def _all_met(meet: Callable[[int], "_Met"], count: int, progress: Progress | None) -> "_Met":
    parts: list[_Met] = []
    for drawn in range(0, count, BATCH):
        size = min(BATCH, count - drawn)
        parts.append(meet(size))
        if progress is not None:
            progress(drawn + size)
    return _Met(
        np.concatenate([part.point for part in parts]),
        np.concatenate([part.direction for part in parts]),
        np.concatenate([part.manipulability for part in parts]),
    )


@dataclass(frozen=True, eq=False)
class _Met:
    point: Floats
    direction: Ints
    manipulability: Floats


def _grid(met: _Met, cell: float, directions: int) -> dict[str, Any]:
    lines: Floats = np.floor(met.point / cell)
    around = prod((lines.max(axis=0) - lines.min(axis=0) + 1.0).tolist())
    if not around <= MOST_CELLS:
        raise ShapeError("cell", f"is {cell:g} m, which gives {around:.3g} cells; at most are {MOST_CELLS:g}")
    index = lines.astype(np.int64)
    lowest = index.min(axis=0)
    shape = tuple((index.max(axis=0) - lowest + 1).tolist())
    place = np.ravel_multi_index(tuple((index - lowest).T), shape)
    cells = prod(shape)
    best = np.zeros(cells)
    np.maximum.at(best, place, met.manipulability)
    seen = np.unique(place * directions + met.direction) // directions
    return {
        "origin": readonly(lowest * cell),
        "hits": np.bincount(place, minlength=cells).reshape(shape),
        "reached": np.bincount(seen, minlength=cells).reshape(shape),
        "manipulability": readonly(best.reshape(shape)),
    }


class CurveReach(Enum):
    """Reach of a point of a curve with one spin."""

    REACHED = "reached"
    SINGULAR = "singularity"
    COLLISION = "collision"
    OUT_OF_REACH = "out of reach"


CAUSES = tuple(CurveReach)
"""All values, the best first."""


@dataclass(frozen=True, eq=False)
class CurveMap(Value):
    """Reach along a curve, for turns of the frame about the axis of its spin.

    Attributes:
        spins: Turns from the orientation of the curve, shape (k,) [rad].
        cells: Place in `CAUSES` of each point and spin, shape (m, k).
    """

    frame: str
    lengths: Floats
    spins: Floats
    cells: Ints

    @property
    def stretches(self) -> tuple[tuple[float, float, CurveReach], ...]:
        """Begin and end [m] of each stretch that no spin reaches, with the cause of the best spin."""
        best: list[CurveReach] = [CAUSES[place] for place in self.cells.min(axis=1).tolist()]
        ends = [0, *(k for k in range(1, len(best)) if best[k] is not best[k - 1]), len(best)]
        return tuple(
            (float(self.lengths[first]), float(self.lengths[end - 1]), best[first])
            for first, end in pairwise(ends)
            if best[first] is not CurveReach.REACHED
        )

    def __str__(self) -> str:
        lines = [
            f"from {in_length(first)} to {in_length(last)}: {cause.value}"
            for first, last, cause in self.stretches
        ]
        share = float((self.cells.min(axis=1) == 0).mean())
        return "\n  ".join([f"{self.frame} reaches {share:.0%} of the points of the curve", *lines])


RANDOM_STARTS, NEIGHBOURS = 12, 2
"""Random starts for each cell of a map of a curve, and starts from each neighbour."""
NEARLY_SINGULAR = 0.01
"""Smallest singular value of a configuration that is not near a singularity, by the size of the arm."""
RADIAN = 0.3
"""Length of a radian of the frame, relative to the size of the arm [1/rad]."""


@checked
def curve_map(
    reduced: ReducedModel,
    required: FollowsCurve,
    *,
    rng: np.random.Generator,
    points: int = 30,
    spins: int = 24,
    margin: float | None = None,
) -> CurveMap:
    """Map the points of a curve that a frame reaches, for each turn about the axis of its spin.

    A cell is evidence: searches begin at random starts and at the configurations of its neighbours. Whether
    these connect is not examined.

    Args:
        required: The curve; without a free spin the map has turns about z of the frame.
        margin: Clearance to keep from everything [m]; the scene's own margins if None.

    Raises:
        FrameNotFound: If a frame is unknown.
        ProblemError: If the curve leaves the rotation free.
        ShapeError: If a number is invalid.
    """
    for name, count in (("points", points), ("spins", spins)):
        count_of(name, count)
    for frame in (required.frame, required.reference):
        frame_of(reduced, frame)
    if np.isinf(required.rotation_tolerance):
        raise ProblemError("the rotation along the curve is free: a map needs an axis that is held")
    query, margins = evaluator(reduced), pair_margins(reduced, margin)
    lengths = np.linspace(0.0, required.until, points)
    turns = np.linspace(-np.pi, np.pi, spins, endpoint=False)
    drawn = draw_positions(reduced.limits, RANDOM_STARTS, rng=rng)
    regular = _Regular.of(query, required, drawn)
    cells: Ints = np.empty((points, spins), dtype=np.int64)
    before = [drawn[:0]] * spins
    for row, length in enumerate(lengths.tolist()):
        for column, turn in enumerate(turns.tolist()):
            project = Projection(reduced, (_turned(required, length, turn),), query)
            cells[row, column] = CAUSES.index(CurveReach.OUT_OF_REACH)
            for starts in (np.concatenate((before[column], before[column - 1])), drawn):
                projected = project(starts)
                found = projected.positions[projected.violation == 0.0]
                cause, kept = _cause(regular, found, margins)
                if CAUSES.index(cause) < cells[row, column]:
                    cells[row, column], before[column] = CAUSES.index(cause), kept[:NEIGHBOURS]
                if cause is CurveReach.REACHED:
                    break
    return CurveMap(required.frame, readonly(lengths), readonly(turns), cells)


def _cause(regular: "_Regular", found: Floats, margins: Floats) -> tuple[CurveReach, Floats]:
    if len(found) == 0:
        return CurveReach.OUT_OF_REACH, found
    free = found[clear(regular.query, found, margins)]
    if len(free) == 0:
        return CurveReach.COLLISION, found
    kept = regular(free)
    return (CurveReach.REACHED, free[kept]) if kept.any() else (CurveReach.SINGULAR, free)


@dataclass(frozen=True, eq=False)
class _Regular:
    """Tells which configurations are not near a singularity.

    Attributes:
        units: Motion of each joint that counts as 1: a radian, or the range of a slide, shape (n,) [rad | m].
        size: Largest motion of the frame per unit of a joint, in the drawn configurations [m].
    """

    query: Evaluator
    required: FollowsCurve
    units: Floats
    size: float

    @staticmethod
    def of(query: Evaluator, required: FollowsCurve, drawn: Floats) -> "_Regular":
        reduced = query.reduced
        limits, model = reduced.limits, reduced.scene.robot.model
        slides = np.array([joint_unit(model, name) == "m" for name in limits.joint_names])
        ranges = np.where(np.isfinite(limits.upper - limits.lower), limits.upper - limits.lower, 2.0 * np.pi)
        units = np.where(slides, ranges, 1.0)
        at = moving_frame(query, required.frame, drawn, required.reference, required.offset)
        moved = np.linalg.norm(at.point_jacobian * units, axis=1)
        return _Regular(query, required, units, float(moved.max()))

    def __call__(self, positions: Floats) -> Bools:
        need = self.required
        at = moving_frame(self.query, need.frame, positions, need.reference, need.offset)
        angular, rows = at.angular_jacobian, 6
        if need.spin is not None:
            axis = at.rotation @ need.spin
            angular, rows = angular - axis[:, :, None] * np.einsum("si,sij->sj", axis, angular)[:, None], 5
        jacobian = np.concatenate((at.point_jacobian, RADIAN * self.size * angular), axis=1) * self.units
        sizes = np.linalg.svd(jacobian, compute_uv=False)
        return sizes[:, min(rows, positions.shape[1]) - 1] >= NEARLY_SINGULAR * self.size


def _turned(required: FollowsCurve, length: float, turn: float) -> FramePlacement:
    from scipy.spatial.transform import Rotation

    axis = np.array((0.0, 0.0, 1.0)) if required.spin is None else required.spin
    place: Placement = required.curve.placement(length)
    rotation = place.rotation @ Rotation.from_rotvec(turn * axis).as_matrix()
    return frame_placement(
        required.frame,
        placement(place.translation, rotation=rotation),
        reference=required.reference,
        offset=required.offset,
        position_tolerance=required.position_tolerance,
        rotation_tolerance=required.rotation_tolerance,
    )


@checked
def even_directions(count: int) -> Floats:
    """Return directions spread evenly over the sphere, shape (count, 3).

    Source: the Fibonacci lattice, Gonzalez, Measurement of areas on a sphere using Fibonacci and
    latitude-longitude lattices, Mathematical Geosciences 2010.
    """
    step = np.arange(count) + 0.5
    height = 1.0 - 2.0 * step / count
    around = np.pi * (1.0 + np.sqrt(5.0)) * step
    ring = np.sqrt(1.0 - height**2)
    return np.stack((ring * np.cos(around), ring * np.sin(around), height), axis=1)


HOPELESS = 100 * BATCH
"""Number of draws without a clear one after which the search ends."""
COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw", "manipulability", "clear")


@dataclass(frozen=True, eq=False)
class ConfigurationTable(Value):
    """Configurations, the placements of a frame, and whether they are clear of everything, one per row.

    Attributes:
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
        margin: Clearance of a clear configuration [m]; the scene's own margins if None.
        only_clear: Whether to draw until `count` rows are clear; otherwise rows in collision count too.

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
    try:
        if check_table_path(path) == ".npz":
            return ConfigurationTable(**_read_npz(path, ConfigurationTable))
        return _read_parquet(path)
    except (OSError, ValueError, KeyError) as error:
        raise FileFormatError(str(path), f"holds no table of configurations: {error}") from error


@checked
def check_table_path(path: Path | str) -> str:
    """Return the suffix of a table's file, once it is known that it can be written and read."""
    suffix = Path(path).suffix
    if suffix not in (".npz", ".parquet"):
        raise FileFormatError(str(path), "a table is written as .parquet or .npz")
    if suffix == ".parquet" and find_spec("pyarrow") is None:
        raise MissingExtra("pyarrow", "parquet")
    return suffix


def _read_npz(path: Path | str, kind: type[ReachMap | ConfigurationTable]) -> dict[str, Any]:
    def stated(array: NDArray[Any]) -> Any:
        names = array.dtype.kind == "U" and array.ndim
        return tuple(array.tolist()) if names else readonly(array) if array.ndim else array.item()

    with np.load(path) as file:
        return {each.name: stated(file[each.name]) for each in fields(kind)}


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
