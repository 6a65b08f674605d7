"""docs/architecture.md says what is so."""

from benchmarks.house import PAGE, layers


def test_its_layers_are_those_of_the_test() -> None:
    assert layers() in PAGE.read_text(), "run: python -m benchmarks.house"
