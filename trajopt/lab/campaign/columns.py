"""Columns of a campaign's tables, and the tables as bytes of Parquet.

What `Row` and `Task` are called here is what the files say; docs/campaigns.md lists every column.
"""

from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trajopt.lab.campaign.tables import table_of
from trajopt.values.documents.whole import written_whole
from trajopt.values.errors import CampaignError, FileFormatError, MissingExtra

if TYPE_CHECKING:
    import pyarrow as pa

Row = Mapping[str, Any]
"""One row of the results, by column."""
TIMES = ("cpu_seconds", "wall_seconds", "process")
"""Columns that differ from run to run; all others are the same wherever the row is made."""
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
"""Columns of which many rows have the same value."""
NUMBERS = ("times", "positions", "velocities", "accelerations")
"""Columns of numbers that never repeat: written byte by byte of each, they take a third less, and a tenth of
the time that looking for repetitions takes."""
ROWS_AT_ONCE = 1000
"""Rows of a table that are read at once: a megabyte or a few, whatever the size of the table."""


def need_parquet() -> None:
    """Make sure that tables can be written and read.

    Raises:
        MissingExtra: If pyarrow is not installed.
    """
    if find_spec("pyarrow") is None:
        raise MissingExtra("pyarrow", "parquet")


def task_columns() -> "pa.Schema":
    """Return the columns of the table of problems."""
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
    """Write the table of problems, row by row, in one step; equal rows once.

    Returns:
        The number of rows.

    Raises:
        CampaignError: If it cannot be written.
    """
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
    """Yield the rows of a table.

    Args:
        path: Its file.
        columns: Which columns; all when None.

    Raises:
        CampaignError: If it is missing or damaged.
    """
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
    """Return how many rows a table has, and the names of its columns.

    Raises:
        CampaignError: If it is missing or damaged.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            return file.metadata.num_rows, frozenset(file.schema_arrow.names)
    except (OSError, pa.ArrowException) as error:
        raise CampaignError(f"{path} cannot be read: {error}") from error


def _is_map(item: object) -> bool:
    """Say whether a value is a mapping as Arrow returns it: a list of pairs."""
    return isinstance(item, list) and (not item or isinstance(item[0], tuple))  # pyright: ignore[reportUnknownArgumentType]
