"""Facts about the sources, written into docs/architecture.md: the layers of the package.

python -m benchmarks.house
"""

from pathlib import Path

from benchmarks.page import table, write_section
from tests.architecture.test_layers import ORDER

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "architecture.md"


def layers() -> str:
    """Return the layers of the package as a table, the highest first."""
    rows = [(str(number), " ".join(f"`{room}`" for room in rooms)) for number, rooms in enumerate(ORDER)]
    return table(("layer", "rooms"), rows[::-1])


def main() -> None:
    """Write the sections."""
    write_section(PAGE, "layers", layers())


if __name__ == "__main__":
    main()
