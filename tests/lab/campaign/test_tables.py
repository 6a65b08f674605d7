"""Rows of a campaign in tables, and the tables as files."""

from pathlib import Path

import numpy as np

from trajopt.lab.campaign.columns import encoded, read_rows, row_columns
from trajopt.values.errors import CampaignError


def odd() -> list[dict[str, object]]:
    """Return rows that have hardly anything, and one with words of another alphabet."""
    return [
        {},
        {"id": "größer", "number": -(2**62), "verified": False, "clearance": float("inf"), "times": []},
        {"parameters": {}, "counts": {"a": 1, "": 2}, "joint_names": ["", "j"], "positions": np.arange(6.0)},
        {"id": "", "verified": True, "times": (1.0, -0.0), "cpu_seconds": {"total": 1e-300}},
    ]


def test_missing_values_are_null_and_all_others_are_read_back(tmp_path: Path) -> None:
    file = tmp_path / "rows.parquet"
    file.write_bytes(encoded(odd()))
    read = list(read_rows(file))
    assert all(read[0][name] is None for name in row_columns().names)
    for before, after in zip(odd(), read, strict=True):
        stated = {name: after[name] for name in before}
        assert stated == {
            name: list(each) if isinstance(each, tuple | np.ndarray) else each
            for name, each in before.items()
        }


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
