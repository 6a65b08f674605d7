"""Columns of a campaign's tables, and the tables as Parquet.

docs/campaigns.md lists every column.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from trajopt.values.documents.files import written_whole
from trajopt.values.errors import CampaignError, FileFormatError, MissingExtra

Row = Mapping[str, Any]
"""One result, by column."""
TIMES = ("cpu_seconds", "wall_seconds", "process")
"""Columns that differ from run to run; all others are reproducible."""
REPEATED = (
    "family",
    "robot",
    "group",
    "method",
    "status",
    "certainty",
    "cause",
    "message",
    "stopped",
    "won_by",
)
"""Columns with few distinct values."""
NUMBERS = ("times", "positions", "velocities", "accelerations")
"""Columns of distinct numbers: with byte stream splitting they take a third less space, and a tenth of the
time of
a dictionary.
"""
ROWS_AT_ONCE = 1000
"""Rows read in one batch: a few megabytes."""


def need_parquet() -> None:
    if find_spec("pyarrow") is None:
        raise MissingExtra("pyarrow", "parquet")


def task_columns() -> "pa.Schema":
    import pyarrow as pa

    text, whole = pa.string(), pa.int64()
    return pa.schema(
        [
            *(("id", text), ("problem_id", text), ("family", text), ("number", whole), ("robot", text)),
            *(("seed", whole), ("options", whole), ("recipe", text)),
            ("parameters", pa.map_(text, pa.float64())),
        ]
    )


def row_columns() -> "pa.Schema":
    """Return the columns of the table of results."""
    import pyarrow as pa

    text, whole, real, truth = pa.string(), pa.int64(), pa.float64(), pa.bool_()
    reals, counts = pa.list_(real), pa.map_(text, whole)
    return pa.schema(
        [
            *(("id", text), ("problem_id", text), ("family", text), ("number", whole), ("robot", text)),
            *(("seed", whole), ("options", whole), ("parameters", pa.map_(text, real))),
            *(("group", text), ("method", text), ("status", text), ("verified", truth)),
            *(("certainty", text), ("cause", text), ("message", text), ("stopped", text)),
            *(("clearance", real), ("duration", real), ("path_length", real)),
            *(("counts", counts), ("attempts", counts), ("won_by", text), ("goal_name", text)),
            *(("joint_names", pa.list_(text)), ("times", reals), ("positions", reals)),
            *(("velocities", reals), ("accelerations", reals)),
            *(("cpu_seconds", pa.map_(text, real)), ("wall_seconds", real), ("process", text)),
        ]
    )


def encoded(rows: Sequence[Row]) -> bytes:
    """Return rows of the results as a file of Parquet."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    stream = pa.BufferOutputStream()
    pq.write_table(
        table_of(rows, row_columns()),
        stream,
        compression="zstd",
        write_page_checksum=True,
        use_dictionary=list(REPEATED),
        use_byte_stream_split=[f"{name}.list.element" for name in NUMBERS],
    )
    return stream.getvalue().to_pybytes()


def write_tasks(path: Path, tasks: Iterator[Row]) -> int:
    """Write the table of problems atomically, without duplicates; return the number of rows."""
    import pyarrow.parquet as pq

    columns, seen = task_columns(), set[bytes]()
    try:
        with (
            written_whole(path, durable=True) as draft,
            draft.open("wb") as file,
            pq.ParquetWriter(file, columns, compression="zstd", write_page_checksum=True) as writer,
        ):
            some: list[Row] = []
            for task in tasks:
                key = bytes.fromhex(task["id"])
                if key in seen:
                    continue
                seen.add(key)
                some.append(task)
                if len(some) == ROWS_AT_ONCE:
                    writer.write_table(table_of(some, columns))
                    some = []
            writer.write_table(table_of(some, columns))
    except FileFormatError as error:
        raise CampaignError(str(error)) from error
    return len(seen)


def read_rows(path: Path, columns: Sequence[str] | None = None) -> Iterator[dict[str, Any]]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            for batch in file.iter_batches(ROWS_AT_ONCE, columns=None if columns is None else list(columns)):
                for row in batch.to_pylist():
                    yield {name: dict(item) if _is_map(item) else item for name, item in row.items()}
    except (OSError, pa.ArrowException) as error:
        raise CampaignError(f"{path} cannot be read: {error}") from error


def size_of(path: Path) -> tuple[int, frozenset[str]]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            return file.metadata.num_rows, frozenset(file.schema_arrow.names)
    except (OSError, pa.ArrowException) as error:
        raise CampaignError(f"{path} cannot be read: {error}") from error


def _is_map(item: object) -> bool:
    return isinstance(item, list) and (not item or isinstance(item[0], tuple))  # pyright: ignore[reportUnknownArgumentType]


def table_of(rows: Sequence[Mapping[str, Any]], columns: "pa.Schema") -> "pa.Table":
    """Return rows as a table; missing values become null."""
    import pyarrow as pa

    arrays = [_array([row.get(column.name) for row in rows], column.type) for column in columns]
    return pa.Table.from_arrays(arrays, schema=columns)


def _array(values: Sequence[Any], kind: "pa.DataType") -> "pa.Array":
    import pyarrow as pa

    known = pa.py_buffer(_bits([each is not None for each in values]))
    if kind == pa.string():
        texts = [b"" if each is None else each.encode() for each in values]
        return _built(kind, len(values), known, _ends(texts), b"".join(texts))
    if isinstance(kind, pa.ListType | pa.MapType):
        ends = pa.py_buffer(_ends(() if each is None else each for each in values))
        there = [each for each in values if each is not None]
        inner = _pairs(there, kind) if isinstance(kind, pa.MapType) else _items(there, kind)
        return pa.Array.from_buffers(kind, len(values), [known, ends], children=[inner])
    if kind == pa.bool_():
        return _built(kind, len(values), known, _bits([bool(each) for each in values]))
    for number, dtype in ((pa.int64(), np.int64), (pa.float64(), np.float64)):
        if kind == number:
            data = np.array([0 if each is None else each for each in values], dtype=dtype)
            return _built(kind, len(values), known, data)
    raise TypeError(f"no column of a campaign is of the kind {kind}")


def _items(values: Sequence[Sequence[Any]], kind: "pa.ListType") -> "pa.Array":
    import pyarrow as pa

    if kind.value_type == pa.float64() and values:
        data = np.concatenate([np.asarray(each, dtype=np.float64) for each in values])
        return _built(kind.value_type, len(data), None, data)
    return _array(list(chain.from_iterable(values)), kind.value_type)


def _pairs(values: Sequence[Mapping[str, Any]], kind: "pa.MapType") -> "pa.Array":
    import pyarrow as pa

    keys = _array(list(chain.from_iterable(values)), kind.key_field.type)
    items = _array([item for each in values for item in each.values()], kind.item_field.type)
    pair = pa.struct([kind.key_field, kind.item_field])
    return pa.Array.from_buffers(pair, len(keys), [None], children=[keys, items])


def _built(
    kind: "pa.DataType", length: int, known: "pa.Buffer | None", *data: NDArray[np.generic] | bytes
) -> "pa.Array":
    import pyarrow as pa

    return pa.Array.from_buffers(kind, length, [known, *map(pa.py_buffer, data)])


def _ends(values: Iterable[Sequence[Any]]) -> NDArray[np.int32]:
    return np.cumsum([0, *map(len, values)], dtype=np.int32)


def _bits(truth: Sequence[bool]) -> NDArray[np.uint8]:
    return np.packbits(np.array(truth, dtype=bool), bitorder="little")
