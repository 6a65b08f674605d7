"""Walls without a way past them, as planning meets them where no proof of that is found."""

import pytest


@pytest.fixture
def unproven(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look for no proof that there is no way, so that all seeds are tried."""
    monkeypatch.setattr("trajopt.planning.search.closed_cut", lambda problem: None)
