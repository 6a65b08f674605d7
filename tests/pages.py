"""Pages of the documentation whose blocks are run."""

import re
import subprocess
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
SECTION = re.compile(r"^##+ ([^\n]+)\n(.*?)(?=^##|\Z)", re.DOTALL | re.MULTILINE)
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE)


class Page:
    """The blocks of a page by section, run in one folder."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name, self.sections = name, dict(SECTION.findall((DOCS / name).read_text()))
        self.folder, self.names = folder, {"__name__": "page"}

    def run(self, *sections: str) -> None:
        """Run the blocks of sections, which may use what earlier ones made.

        A block of YAML becomes the file that the comment at its top names.
        """
        for section in sections:
            for kind, text in BLOCK.findall(self.sections[section]):
                if kind == "bash":
                    subprocess.run(["bash", "-euc", text], cwd=self.folder, check=True, timeout=240)
                elif kind == "yaml":
                    (self.folder / text.split()[1]).write_text(text)
                else:
                    exec(compile(text, f"{self.name}, {section}", "exec"), self.names)

    @property
    def with_blocks(self) -> list[str]:
        """The sections that have blocks."""
        return [name for name, body in self.sections.items() if BLOCK.search(body)]
