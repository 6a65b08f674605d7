"""Columns of a campaign's tables (docs/campaigns.md), and the tables as Parquet."""

from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trajopt.values.documents.files import written_whole
from trajopt.values.errors import CampaignError, FileFormatError, MissingExtra

if TYPE_CHECKING:
    import pyarrow as pa

Row = Mapping[str, Any]
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
"""Columns of distinct numbers: byte stream splitting takes a third less space, and a tenth of the time of a
dictionary.
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
        pa.Table.from_pylist(rows, schema=row_columns()),
        stream,
        compression="zstd",
        write_page_checksum=True,
        use_dictionary=list(REPEATED),
        use_byte_stream_split=[f"{name}.list.element" for name in NUMBERS],
    )
    return stream.getvalue().to_pybytes()


def write_tasks(path: Path, tasks: Iterator[Row]) -> int:
    """Write the table of problems atomically, without duplicates; return the number of rows."""
    import pyarrow as pa
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
                    writer.write_table(pa.Table.from_pylist(some, schema=columns))
                    some = []
            writer.write_table(pa.Table.from_pylist(some, schema=columns))
    except FileFormatError as error:
        raise CampaignError(str(error)) from error
    return len(seen)


def read_rows(path: Path, columns: Sequence[str] | None = None) -> Iterator[dict[str, Any]]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            for batch in file.iter_batches(ROWS_AT_ONCE, columns=None if columns is None else list(columns)):
                yield from batch.to_pylist(maps_as_pydicts="lossy")
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
