"""Tables of a trajectory's samples: CSV with a named column for each number, as trajopt exports it."""

import csv
import io
from collections.abc import Sequence
from itertools import pairwise
from math import isfinite
from pathlib import Path

import numpy as np

from trajopt.values.arrays import Floats
from trajopt.values.documents.files import read_text
from trajopt.values.errors import FileFormatError, listed, shown
from trajopt.values.trajectory import Trajectory

ORDERS = ("position", "velocity", "acceleration")
"""Prefixes of column names, before `_` and the joint's name."""


def read_table(path: Path | str) -> Trajectory:
    """Read a table: `time` [s], and `position_NAME`, `velocity_NAME` and `acceleration_NAME` of each joint.

    Columns may have any order; the joints follow the order of the position columns. Accelerations, or
    velocities and accelerations, may be omitted for all joints. Rows are interpolated by quintic polynomials
    with both, by cubic ones with velocities, else linearly.

    Raises:
        FileFormatError: If columns are missing, unknown or duplicate, a number is malformed, or time does not
            increase from 0.
    """
    try:
        lines = [line for line in csv.reader(io.StringIO(read_text(path)), strict=True) if line]
    except csv.Error as error:
        raise FileFormatError(str(path), f"is not a table: {error}") from error
    if len(lines) < 3:
        raise FileFormatError(str(path), "a table has a line of column names and two rows at least")
    columns = [name.strip() for name in lines[0]]
    names = _joints(path, columns)
    table = _numbers(path, columns, lines[1:])
    times = table[:, columns.index("time")]
    _check_times(path, times)
    rows = [
        table[:, [columns.index(f"{order}_{name}") for name in names]]
        if f"{order}_{names[0]}" in columns
        else None
        for order in ORDERS
    ]
    assert rows[0] is not None
    return Trajectory(names, times, rows[0], rows[1], rows[2])


def _joints(path: Path | str, columns: Sequence[str]) -> tuple[str, ...]:
    """Return the joint names, after checking that every column occurs once and none is unknown."""
    names = tuple(name.removeprefix("position_") for name in columns if name.startswith("position_"))
    if "time" not in columns or not all(names) or not names:
        raise FileFormatError(
            str(path), "the first line must name the columns: time, position_JOINT, ... for each joint"
        )
    has = [any(column.startswith(f"{order}_") for column in columns) for order in ORDERS]
    if has[2] and not has[1]:
        raise FileFormatError(str(path), "has accelerations, but no velocities")
    due = ["time"]
    due += [f"{order}_{name}" for order, there in zip(ORDERS, has, strict=True) if there for name in names]
    missing = [name for name in due if name not in columns]
    if missing:
        raise FileFormatError(str(path), f"has no column {listed(missing)}")
    for place, name in enumerate(columns):
        if name not in due:
            raise FileFormatError(str(path), f"unknown column {shown(name)}")
        if name in columns[:place]:
            raise FileFormatError(str(path), f"has the column {shown(name)} twice")
    return names


def _numbers(path: Path | str, columns: Sequence[str], lines: Sequence[Sequence[str]]) -> Floats:
    table = np.empty((len(lines), len(columns)))
    for row, line in enumerate(lines):
        if len(line) != len(columns):
            raise FileFormatError(str(path), f"row {row + 1}: {len(line)} numbers for {len(columns)} columns")
        for place, text in enumerate(line):
            try:
                table[row, place] = float(text)
            except ValueError:
                table[row, place] = np.nan
            if not isfinite(table[row, place]):
                where = f"row {row + 1}, {columns[place]}"
                raise FileFormatError(str(path), f"{where}: must be a finite number, is {shown(text)}")
    return table


def _check_times(path: Path | str, times: Floats) -> None:
    if times[0] != 0.0:
        raise FileFormatError(str(path), f"row 1, time: must be 0, is {times[0]:g} s")
    for row, (before, after) in enumerate(pairwise(times.tolist()), start=2):
        if after <= before:
            raise FileFormatError(str(path), f"row {row}, time: {after:g} s does not come after {before:g} s")
