"""Data sets for training: the verified motions of a campaign as arrays of one shape, with numpy only."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trajopt.lab.campaign.extract import MOTIONS, motion_of
from trajopt.lab.campaign.kept import CampaignFolder
from trajopt.values.arrays import Floats, Value, readonly
from trajopt.values.documents.whole import written_whole
from trajopt.values.errors import CampaignError, FileFormatError, ShapeError
from trajopt.values.errors.arguments import checked

SHARES = 2**32
"""Beginnings of ids, by which rows are shared out: even, for ids are hashes."""


@dataclass(frozen=True, eq=False)
class Dataset(Value):
    """Verified motions, each at the same number of points, evenly spaced in time.

    Attributes:
        joint_names: The joints.
        ids: Of the rows, shape (N,).
        problem_ids: Of their problems, shape (N,).
        families: Sets of the problems, shape (N,).
        positions: Shape (N, T, n) [rad | m]; the start is the first point, the goal the last.
        velocities: Shape (N, T, n) [rad/s | m/s].
        durations: Of the motions, shape (N,) [s].
        clearances: Smallest proven clearance, NaN without pairs, shape (N,) [m].
    """

    joint_names: tuple[str, ...]
    ids: NDArray[np.str_]
    problem_ids: NDArray[np.str_]
    families: NDArray[np.str_]
    positions: Floats
    velocities: Floats
    durations: Floats
    clearances: Floats

    def __len__(self) -> int:
        """Return the number of motions."""
        return len(self.ids)

    @checked
    def chosen(self, first: float, last: float) -> "Dataset":
        """Return the motions of a share of the problems: 0 to 0.8 to train, 0.8 to 1 to test.

        A problem is always on the same side, on every machine and in every campaign.

        Args:
            first: Beginning of the share, in [0, 1].
            last: End of it, in [0, 1].

        Raises:
            ShapeError: If they do not increase within [0, 1].
        """
        if not 0.0 <= first < last <= 1.0:
            raise ShapeError("first, last", f"must increase within [0, 1], are {first:g} and {last:g}")
        place = np.array([int(key[:8], 16) / SHARES for key in self.problem_ids.tolist()])
        return self._rows((place >= first) & (place < last))

    @checked
    def batches(self, size: int, *, rng: np.random.Generator) -> Iterator["Dataset"]:
        """Yield all motions once in random order, in batches; the last batch may be smaller.

        Args:
            size: Motions of a batch.
            rng: Random generator.

        Raises:
            ShapeError: If the size is not positive.
        """
        if size < 1:
            raise ShapeError("size", f"must be positive, is {size}")
        order = rng.permutation(len(self))
        return (self._rows(order[begin : begin + size]) for begin in range(0, len(order), size))

    @checked
    def write(self, path: Path | str) -> None:
        """Write the arrays as they are called here.

        Args:
            path: The file, `.npz`.

        Raises:
            FileFormatError: If its name does not end so, or it cannot be written.
        """
        if Path(path).suffix != ".npz":
            raise FileFormatError(str(path), "a data set is written as .npz")
        with written_whole(path) as draft, draft.open("wb") as file:
            np.savez_compressed(file, allow_pickle=False, **vars(self))

    def _rows(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> "Dataset":
        names = [name for name in vars(self) if name != "joint_names"]
        return replace(self, **{name: getattr(self, name)[which] for name in names})


@checked
def dataset(folder: CampaignFolder, points: int = 64) -> Dataset:
    """Return the verified motions of a campaign, in the order of their ids.

    Args:
        folder: The campaign; all of its motions are of the same joints.
        points: Points of each motion, at least 2.

    Raises:
        ShapeError: If there are fewer points.
        CampaignError: If there is no verified motion, or they are of different joints.
    """
    if points < 2:
        raise ShapeError("points", f"must be at least 2, is {points}")
    found: list[tuple[str, str, str, Floats, Floats, float, float]] = []
    joints: set[tuple[str, ...]] = set()
    for row in folder.rows(("problem_id", "family", "verified", "clearance", *MOTIONS)):
        motion = motion_of(row) if row["verified"] else None
        if motion is None:
            continue
        joints.add(motion.joint_names)
        if len(joints) > 1:
            raise CampaignError(f"{folder.path} has motions of different joints: {sorted(joints)}")
        times = np.linspace(0.0, motion.duration, points)
        near = np.nan if row["clearance"] is None else float(row["clearance"])
        keys = str(row["id"]), str(row["problem_id"]), str(row["family"])
        found.append((*keys, motion(times), motion(times, 1), motion.duration, near))
    if not found:
        raise CampaignError(f"{folder.path} has no verified motion")
    columns = zip(*sorted(found, key=lambda each: each[0]), strict=True)
    ids, problems, families, positions, velocities, durations, clearances = map(np.array, columns)
    motions = readonly(positions), readonly(velocities)
    return Dataset(next(iter(joints)), ids, problems, families, *motions, durations, clearances)


@checked
def read_dataset(path: Path | str) -> Dataset:
    """Read a file written by `Dataset.write`.

    Raises:
        FileFormatError: If the file is missing or is not a data set.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in Dataset.__dataclass_fields__ if name != "joint_names"}
            return Dataset(tuple(file["joint_names"].tolist()), **arrays)
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise FileFormatError(str(path), f"holds no data set: {error}") from error
