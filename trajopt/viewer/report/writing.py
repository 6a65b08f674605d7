"""Reports written."""

from pathlib import Path

from trajopt.values.documents.document import write_text
from trajopt.values.errors import RenderingUnavailable
from trajopt.values.errors.arguments import checked
from trajopt.viewer.report.page import page
from trajopt.viewer.report.scenery import in_space, scenery, stills
from trajopt.viewer.report.subject import Reported, subject_of


@checked
def write_report(what: Reported, path: Path | str, *, moving: bool = True, pictures: bool = True) -> Path:
    """Write a report: one page of HTML, to be read in a browser or printed, that needs nothing beside itself.

    It shows the motion in 3-D, what was proven, where limits bind, curves over time, what the constraints
    cost and what was tried; of a failure what stands in the way, and the nearest that is free. A motion of
    a bundle is judged anew.

    Args:
        what: A result, whatever became of it; a plan; a problem that nobody planned yet; or a bundle, which
            is drawn as it would be in `trajopt view` if its meshes were unpacked (`read_bundle`).
        path: The file.
        moving: Whether there is a motion in 3-D, which takes about a megabyte and the extra `view`.
        pictures: Whether there are still pictures, for paper. Where no OpenGL works there are none, and the
            page says so.

    Returns:
        The path.

    Raises:
        MissingExtra: If there is to be a motion in 3-D, and viser is not installed.
        FileFormatError: If the file cannot be written, or a bundle does not say what it must.
    """
    subject = subject_of(what)
    shown = scenery(subject)
    remark, drawn = "", ()
    if pictures:
        try:
            drawn = stills(subject, shown)
        except RenderingUnavailable as missing:
            remark = f"There are no still pictures: {missing}"
    write_text(path, page(subject, shown, in_space(subject, shown) if moving else "", drawn, remark))
    return Path(path)
