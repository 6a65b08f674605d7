"""Small pictures of motions, for pages that show many."""

from io import BytesIO

import numpy as np
from PIL import Image

from trajopt.scene.reduced import ReducedModel
from trajopt.values.trajectory import Trajectory

WIDTH, HEIGHT = 320, 240
"""Of a thumbnail [pixels]."""
SHADOW = 1024
"""Edge of the square that its shadows are computed on [pixels]."""
QUALITY = 80
"""Of its JPEG: artefacts are not seen, and a hundred of them make a page of one or two megabytes."""
TYPE = "image/jpeg"
"""Its media type."""


def thumbnail(reduced: ReducedModel, trajectory: Trajectory | None) -> bytes:
    """Draw a motion, its end solid and the way there translucent; or where it would start.

    Args:
        reduced: Robot and scene.
        trajectory: The motion; None for the start alone.

    Returns:
        A JPEG.

    Raises:
        RenderingUnavailable: If no OpenGL works here; says what to install.
    """
    from trajopt.simulation.motion import held_start, moments_of, motion_of  # MuJoCo takes a second to import
    from trajopt.simulation.studio import Canvas, Studio

    if trajectory is None:
        motion, moments = held_start(reduced), np.zeros(1)
    else:
        motion = motion_of(reduced, trajectory)
        moments = moments_of(motion, None)
    with Studio(reduced, motion, Canvas(WIDTH, HEIGHT, SHADOW), pictures=len(moments), camera=None) as studio:
        picture = studio.superposed(moments)
    written = BytesIO()
    Image.fromarray(picture).save(written, "JPEG", quality=QUALITY, optimize=True)
    return written.getvalue()
