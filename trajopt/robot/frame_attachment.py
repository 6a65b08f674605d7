"""Frames fixed to links: tool centre points and cameras."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from trajopt.values.arrays import one_of
from trajopt.values.errors import FrameNotFound, ModelError, ShapeError, shown
from trajopt.values.placement import WORLD, Placement, PlacementLike, as_placement


@dataclass(frozen=True)
class FrameAttachment:
    """A frame fixed to a link, such as the tool centre point.

    Attributes:
        link: Name of the link.
        placement: Of the frame in the link's frame.
    """

    link: str
    placement: Placement

    def __post_init__(self) -> None:
        """Take the placement in any of its forms."""
        object.__setattr__(self, "placement", as_placement("placement", self.placement))


def frame_attachment(name: str, value: FrameAttachment | tuple[str, PlacementLike]) -> FrameAttachment:
    """Return a frame fixed to a link, from a pair (link, placement) too.

    Raises:
        ShapeError: If it is neither.
    """
    if isinstance(value, FrameAttachment):
        return value
    if not isinstance(value, tuple) or len(value) != 2:  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ShapeError(name, f"is a link and a placement in it, is {shown(value)}")
    return FrameAttachment(one_of(name, value[0], str), as_placement(name, value[1]))


def tool_frames(
    frames: Mapping[str, FrameAttachment | tuple[str, PlacementLike]], links: Sequence[str]
) -> Mapping[str, FrameAttachment]:
    """Return the tool frames of a robot, checked against its links.

    Raises:
        ShapeError: If one is no link with a placement in it.
        FrameNotFound: If its link is unknown.
        ModelError: If it has the name of a link or of the world.
    """
    tools = {tool: frame_attachment(f"frame {shown(tool)}", at) for tool, at in frames.items()}
    for tool, frame in tools.items():
        if frame.link not in links:
            raise FrameNotFound("link", frame.link, links)
        if tool in links or tool == WORLD:
            raise ModelError(f"tool frame {shown(tool)} has the name of a link or of the world: rename it")
    return tools
