"""Picture files: a PNG of one or several pictures, an animated GIF, an MP4 film."""

from collections.abc import Callable, Iterable
from fractions import Fraction
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow
from PIL import ImageDraw, ImageFont

from trajopt.values.errors import FileFormatError, MissingExtra

Image = NDArray[np.uint8]
"""A picture, shape (height, width, 3), first row on top."""
SUFFIXES = (".png", ".gif", ".mp4")
ENCODER = "av"
"""Package that encodes films: PyAV, of the extra `film`."""
DITHER = Pillow.Dither.NONE
QUALITY = "20"
"""Constant rate factor of films: between the default of x264, 23, and visually lossless, 18."""
FINEST_RATE = 1000
"""Largest denominator of the frame rate."""
GAP = 6
"""White between the pictures of a film strip [pixels]."""


def check_path(path: Path) -> str:
    """Return the lower-case suffix of a picture file that can be written."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise FileFormatError(str(path), f"is not a picture file; use a suffix of {', '.join(SUFFIXES)}")
    if not path.parent.is_dir():
        raise FileFormatError(str(path), "its folder does not exist")
    if suffix == ".mp4" and find_spec(ENCODER) is None:
        raise MissingExtra(ENCODER, "film")
    return suffix


def write_strip(path: Path, pictures: list[Image]) -> None:
    columns = int(np.ceil(np.sqrt(len(pictures))))
    rows = -(-len(pictures) // columns)
    height, width = pictures[0].shape[:2]
    sheet = np.full((rows * (height + GAP) - GAP, columns * (width + GAP) - GAP, 3), 255, np.uint8)
    for place, picture in enumerate(pictures):
        top, left = place // columns * (height + GAP), place % columns * (width + GAP)
        sheet[top : top + height, left : left + width] = picture
    Pillow.fromarray(sheet).save(path, optimize=True)


def write_gif(path: Path, pictures: Iterable[Image], fps: float) -> None:
    images = [Pillow.fromarray(picture) for picture in pictures]
    # Colours by octree, since selection by frequency would drop the colours of thin objects.
    palette = images[0].quantize(256, method=Pillow.Quantize.FASTOCTREE)
    frames = [image.quantize(palette=palette, dither=DITHER) for image in images]
    # The format has times in hundredths of a second.
    duration = 10 * max(2, round(100.0 / fps))
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=duration, loop=0, optimize=False)


def write_mp4(path: Path, pictures: Iterable[Image], fps: float) -> None:
    """Write an H.264 film, picture by picture."""
    av: Any = import_module(ENCODER)  # slow import, for films only
    with av.open(str(path), "w") as film:
        stream: Any = None
        for picture in pictures:
            if stream is None:
                rate = Fraction(fps).limit_denominator(FINEST_RATE)
                stream = film.add_stream("libx264", rate=rate, options={"crf": QUALITY})
                stream.height, stream.width = picture.shape[:2]
                stream.pix_fmt = "yuv420p"  # supported by all players
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            film.mux(stream.encode(frame))
        film.mux(stream.encode())  # flush the encoder


def labelled(picture: Image, text: str) -> Image:
    """Write a line of text into the lower left corner."""
    image = Pillow.fromarray(np.ascontiguousarray(picture))
    size = max(12, picture.shape[0] // 28)
    margin = size // 2
    ImageDraw.Draw(image).text(
        (margin, picture.shape[0] - margin),
        text,
        fill=(70, 76, 84),
        font=ImageFont.load_default(size),
        anchor="lb",
    )
    return np.asarray(image)


WRITERS: dict[str, Callable[[Path, Iterable[Image], float], None]] = {
    ".gif": write_gif,
    ".mp4": write_mp4,
}
"""Suffix -> writer of films."""
