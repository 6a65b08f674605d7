"""Where the optional package ``example-robot-data`` keeps its URDFs and meshes."""

import sysconfig
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

import trajopt as to

_PACKAGE = "example-robot-data"


def share_folder() -> Path:
    """Folder against which ``package://example-robot-data/...`` is resolved.

    Returns:
        The folder that holds ``example-robot-data/robots``.

    Raises:
        MissingExtra: if the package is not installed; the message names the command
            that installs it.
    """
    for folder in _candidates():
        if (folder / _PACKAGE / "robots").is_dir():
            return folder
    raise to.MissingExtra(package=_PACKAGE, extra="robots")


def _candidates() -> Iterator[Path]:
    """Places to look: the wheel's own prefix, then ``share`` of the environment."""
    try:
        distribution = metadata.distribution(_PACKAGE)
    except metadata.PackageNotFoundError:
        pass
    else:
        yield Path(str(distribution.locate_file("cmeel.prefix/share")))
    yield Path(sysconfig.get_path("data")) / "share"
