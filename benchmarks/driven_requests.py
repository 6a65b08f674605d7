"""`trajopt run` on MotionBenchMaker's requests: reached goals and contacts.

python -m benchmarks.driven_requests DATA/panda [--robot panda] [--sets box,cage,bookshelf_tall,table_pick]
  [--page FILE]

Each request is planned and driven in the simulated world as by the command, in one process. Those without a
plan are listed with the reason.
"""

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from benchmarks.page import table, write_section
from trajopt.cli import app_for

SETS = "box,cage,bookshelf_tall,table_pick"


@dataclass(frozen=True)
class Driven:
    """A request after `trajopt run`.

    Attributes:
        name: Its set and number.
        status: Exit status of the command.
        document: What it printed; empty if that is not JSON.
    """

    name: str
    status: int
    document: dict[str, Any]

    @property
    def reached(self) -> bool:
        return self.status == 0 and self.document["reached"]

    @property
    def reason(self) -> str:
        """Short reason of a failure; empty if there is a plan."""
        events = self.document.get("events", ())
        return next((each["words"].split(":")[0] for each in events if each["kind"] == "no plan"), "")


def driven(robot: str, scene: Path) -> Driven:
    """Drive the request of a scene."""
    request = scene.with_name(scene.name.replace("scene", "request"))
    words = ["run", "--robot", robot, "--scene", str(scene), "--request", str(request), "--json"]
    result = CliRunner().invoke(app_for(words), words)
    return Driven(
        f"{scene.parent.name}/{scene.stem[-4:]}",
        result.exit_code,
        json.loads(result.stdout) if result.stdout.startswith("{") else {},
    )


def main(words: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--sets", default=SETS)
    parser.add_argument("--page", type=Path)
    given = parser.parse_args(words)
    rows = [row(name, given.data / name, given.robot) for name in given.sets.split(",")]
    text = table(
        ["set", "requests", "reached", "touched anything", "without a plan", "failed otherwise"], rows
    )
    print(text)
    if given.page is not None:
        write_section(given.page, "driven_requests", text)


def row(name: str, folder: Path, robot: str) -> list[str]:
    """Return the row of a set."""
    found = [driven(robot, scene) for scene in sorted(folder.glob("scene*.yaml"))]
    touched = [each for each in found if each.document.get("contacts")]
    unplanned = [f"{each.name} {each.reason}" for each in found if each.reason]
    others = [each.name for each in found if not each.reached and not each.reason]
    return [
        name,
        str(len(found)),
        str(sum(each.reached for each in found)),
        str(len(touched)),
        f"{len(unplanned)} {', '.join(unplanned)}".strip(),
        f"{len(others)} {', '.join(others)}".strip(),
    ]


if __name__ == "__main__":
    main()
