"""Files written as a whole: a reader finds the old content or the new, never half of it."""

from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex

from trajopt.errors import FileFormatError, TrajoptError


@contextmanager
def written_whole(path: Path | str) -> Generator[Path]:
    """Yield the name of a draft beside a file, which takes the file's place when the block ends well.

    Each call has a draft of its own, so that processes and threads may write one file at once: the last one
    that ends counts. Missing folders are created; of a block that fails nothing is left.

    Args:
        path: The file.

    Raises:
        FileFormatError: If the file cannot be written.
    """
    try:
        target = Path(path)
        draft = target.with_name(f".trajopt-{token_hex(8)}")
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield draft
            draft.replace(target)
        finally:
            with suppress(OSError):
                draft.unlink()
    except TrajoptError:
        raise
    except (OSError, ValueError) as error:
        raise FileFormatError(str(path), f"cannot be written: {error}") from error
