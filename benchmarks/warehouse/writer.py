"""A process that keeps one state after the other and acknowledges each.

python -m benchmarks.warehouse.writer FILE WHO COUNT
"""

import sys

from trajopt.server.warehouse import StoredState, Warehouse


def state(who: str, number: int) -> StoredState:
    """Return an entry of a writer, with enough numbers that a half-written one is noticed."""
    return StoredState(who, {f"joint{place}": number + place / 1000.0 for place in range(200)})


def main() -> None:
    """Keep states until all are kept or the process is killed; print the number of each once it is kept."""
    path, who, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
    kept = Warehouse(path)
    for number in range(count):
        entry = kept.add(f"{who} {number % 7}", state(who, number), note=str(number), tags=(who,))
        sys.stdout.write(f"{number} {entry.name.replace(' ', '_')} {entry.version}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
