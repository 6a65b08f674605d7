"""The folder of a campaign: problems, shared values and results."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from trajopt.files.bundle.bundle import versions
from trajopt.lab.campaign.campaign import SYSTEM, Campaign, CampaignTask, Options
from trajopt.lab.campaign.columns import Row, need_parquet, read_rows, write_tasks
from trajopt.lab.campaign.recipes import Packer
from trajopt.values.documents.document import write_json
from trajopt.values.documents.files import read_json, written_whole
from trajopt.values.errors import CampaignError, FileFormatError, shown
from trajopt.values.errors.arguments import checked_class

FORMAT = "trajopt campaign"
VERSION = 1
DESCRIPTION, PROBLEMS, DOCUMENTS, RESULTS = "campaign.json", "problems.parquet", "documents", "results"
"""Names in the folder; the description is written last and marks a complete campaign."""
Ids = NDArray[np.bytes_]
"""Ids of rows, in order, each once."""


@checked_class
@dataclass(frozen=True)
class CampaignFolder:
    """A campaign on disk."""

    path: Path
    name: str
    options: tuple[Options, ...]
    most_seconds: float
    total: int
    versions: Mapping[str, str]

    @staticmethod
    def begin(campaign: Campaign, path: Path | str) -> "CampaignFolder":
        """Write the problems of a campaign into a folder.

        Raises:
            MissingExtra: Without pyarrow.
            CampaignError: If the folder has a campaign already, or cannot be written.
            ModelError: If a problem contains code of the caller, which cannot be stored.
        """
        need_parquet()
        target = Path(path)
        if (target / DESCRIPTION).exists():
            raise CampaignError(
                f"{path} holds a campaign already: resume it (trajopt campaign resume {path}), or name "
                "another folder"
            )
        try:
            (target / DOCUMENTS).mkdir(parents=True, exist_ok=True)
            (target / RESULTS).mkdir(exist_ok=True)
        except OSError as error:
            raise CampaignError(f"{path} cannot be written: {error}") from error
        packer = Packer()
        total = write_tasks(target / PROBLEMS, map(asdict, campaign.tasks(packer)))
        packer.write(target / DOCUMENTS)
        about = {"format": FORMAT, "version": VERSION, **campaign.as_dict(), "total": total}
        write_json(target / DESCRIPTION, about)
        return CampaignFolder.open(target)

    @staticmethod
    def open(path: Path | str) -> "CampaignFolder":
        """Open the campaign of a folder."""
        need_parquet()
        try:
            about = cast("dict[str, Any]", read_json(Path(path) / DESCRIPTION))
        except FileFormatError as error:
            raise CampaignError(f"{path} holds no campaign: {error.reason}") from error
        if about.get("format") != FORMAT or about.get("version") != VERSION:
            raise CampaignError(f"{path}: this trajopt reads version {VERSION} of campaigns")
        try:
            ways = tuple(Options(**each) for each in about["options"])
            return CampaignFolder(
                Path(path),
                about["name"],
                ways,
                float(about["most_seconds"]),
                int(about["total"]),
                about["versions"],
            )
        except (KeyError, TypeError, ValueError) as error:
            raise CampaignError(f"{path} is damaged: {DESCRIPTION}: {error}") from error

    @property
    def documents(self) -> Path:
        """The folder of shared values."""
        return self.path / DOCUMENTS

    @property
    def shards(self) -> list[Path]:
        """The files of the present results."""
        return sorted((self.path / RESULTS).glob("[!.]*.parquet"))

    def tasks(self) -> Iterator[CampaignTask]:
        """Yield every row to be, in order."""
        for row in read_rows(self.path / PROBLEMS):
            yield CampaignTask(**row)

    def task(self, row_id: str) -> CampaignTask:
        """Return a task by its id or an unambiguous prefix of it."""
        found = [task for task in self.tasks() if task.id.startswith(row_id)]
        if len(found) != 1:
            raise CampaignError(
                f"{len(found) or 'no'} rows of {self.path} have an id that begins with {shown(row_id)}"
            )
        return found[0]

    def done(self) -> Ids:
        ids = [row["id"] for shard in self.shards for row in read_rows(shard, ("id",))]
        return np.unique(np.array(ids, dtype="S32"))

    def missing(self) -> Iterator[CampaignTask]:
        """Yield the rows without a result, in order."""
        done = self.done()
        for task in self.tasks():
            place = int(np.searchsorted(done, task.id.encode()))
            if place == len(done) or done[place] != task.id.encode():
                yield task

    def rows(self, columns: Sequence[str] | None = None) -> Iterator[Row]:
        seen: set[bytes] = set()
        wanted = None if columns is None else list(dict.fromkeys(("id", *columns)))
        for shard in self.shards:
            for row in read_rows(shard, wanted):
                key = bytes.fromhex(row["id"])
                if key not in seen:
                    seen.add(key)
                    yield row

    def statuses(self) -> Counter[str]:
        """Return the number of results of each status."""
        return Counter(str(row["status"]) for row in self.rows(("status",)))

    def write(self, shard: bytes) -> None:
        name = f"{sha256(shard).hexdigest()[:32]}.parquet"
        with written_whole(self.path / RESULTS / name, durable=True) as draft:
            draft.write_bytes(shard)

    def check_versions(self) -> None:
        """Check that the package versions equal those in the rows; raise a CampaignError if not."""
        check_versions(self.versions, str(self.path))


def check_versions(begun: Mapping[str, str], what: str) -> None:
    """Check that a campaign continues with the versions of its start."""
    now = versions()
    changed = [
        f"{name} {then} then, {now.get(name, 'unknown')} now"
        for name, then in begun.items()
        if name not in SYSTEM and now.get(name) != then
    ]
    if changed:
        raise CampaignError(
            f"{what} was begun with other versions ({'; '.join(changed)}): run it again in another folder, "
            "and compare the two"
        )
