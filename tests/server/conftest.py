from collections.abc import Iterator

import pytest

from tests.server.serving import Serving, serving


@pytest.fixture(scope="session")
def server() -> Iterator[Serving]:
    """One server for all tests that do not end it."""
    with serving() as up:
        yield up
