"""Files written as a whole: a reader finds the old content or the new, never half of it."""

import os
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

from trajopt.values.errors import FileFormatError, TrajoptError


@contextmanager
def written_whole(path: Path | str, *, durable: bool = False) -> Generator[Path]:
    """Yield the name of a draft beside a file, which takes the file's place when the block ends well.

    Each call has a draft of its own, so that processes and threads may write one file at once: the last one
    that ends counts. Missing folders are created; of a block that fails nothing is left.

    Args:
        path: The file.
        durable: Whether the file is on the disk when the block is over, even if the machine goes down then;
            that takes some milliseconds.

    Raises:
        FileFormatError: If the file cannot be written.
    """
    try:
        target = Path(path)
        draft = target.with_name(f".trajopt-{token_hex(8)}")
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield draft
            if durable:
                _to_disk(draft)
            draft.replace(target)
            if durable:
                _to_disk(target.parent)  # which has the name
        finally:
            with suppress(OSError):
                draft.unlink()
    except TrajoptError:
        raise
    except (OSError, ValueError) as error:
        raise FileFormatError(str(path), f"cannot be written: {error}") from error


def _to_disk(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk."""
    opened = os.open(path, os.O_RDONLY)
    try:
        os.fsync(opened)
    finally:
        os.close(opened)
