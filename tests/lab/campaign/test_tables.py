"""Rows are put into tables as Arrow itself does it, without the packages that it would look into."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from trajopt.lab.campaign import CampaignFolder
from trajopt.lab.campaign.columns import encoded, read_rows, row_columns, table_of, task_columns
from trajopt.values.errors import CampaignError

WITHOUT_PANDAS = """
import sys
from trajopt.lab.campaign.columns import encoded, row_columns
encoded([{"id": "a", "parameters": {"x": 1.0}, "times": [0.0, 1.0], "verified": True}])
assert "pyarrow" in sys.modules
sys.exit("pandas" in sys.modules)
"""


def odd() -> list[dict[str, object]]:
    """Return rows that have hardly anything, and one with words of another alphabet."""
    return [
        {},
        {"id": "größer", "number": -(2**62), "verified": False, "clearance": float("inf"), "times": []},
        {"parameters": {}, "counts": {"a": 1, "": 2}, "joint_names": ["", "j"], "positions": np.arange(6.0)},
        {"id": "", "verified": True, "times": (1.0, -0.0), "cpu_seconds": {"total": 1e-300}},
    ]


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
def test_a_table_equals_arrows_own_conversion(count: int) -> None:
    table = table_of(odd()[:count], row_columns())
    table.validate(full=True)
    assert table.equals(pa.Table.from_pylist(odd()[:count], schema=row_columns()))


def test_rows_and_problems_of_a_campaign_are_read_back(planned: CampaignFolder) -> None:
    for columns, rows in (
        (row_columns(), list(planned.rows())),
        (task_columns(), [vars(task) for task in planned.tasks()]),
    ):
        expected = pa.Table.from_pylist([dict(row) for row in rows], schema=columns)
        assert table_of(rows, columns).equals(expected) and expected.num_rows == 12


def test_flipped_bits_of_pages_are_refused(tmp_path: Path) -> None:
    """Each page has a checksum; the headers of pages and the footer, a few percent of a file, have none."""
    drawn = np.random.default_rng(0)
    rows = [{"id": f"{i:04x}", "times": drawn.random(20), "positions": drawn.random(140)} for i in range(40)]
    data, file = encoded(rows), tmp_path / "rows.parquet"
    file.write_bytes(data)
    sound = list(read_rows(file))
    refused = 0
    for at, bit in zip(drawn.integers(100, len(data) // 2, 60), drawn.integers(0, 8, 60), strict=True):
        spoilt = bytearray(data)
        spoilt[at] ^= 1 << int(bit)
        file.write_bytes(spoilt)
        try:
            assert list(read_rows(file)) == sound
        except CampaignError:
            refused += 1
    assert refused > 50


def test_a_column_of_another_kind_is_refused() -> None:
    with pytest.raises(TypeError, match="date"):
        table_of([{"day": None}], pa.schema([("day", pa.date32())]))


def test_writing_rows_does_not_import_pandas() -> None:
    assert subprocess.run([sys.executable, "-c", WITHOUT_PANDAS], check=False, timeout=120).returncode == 0
