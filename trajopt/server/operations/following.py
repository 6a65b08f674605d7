"""Cartesian paths: a frame along a curve."""

from trajopt.planning.budget import Budget
from trajopt.server.operation import Answer
from trajopt.server.operations.asking import changed
from trajopt.server.operations.words import called, value_of
from trajopt.server.state import SessionState
from trajopt.server.watch import Watch
from trajopt.tasks.cartesian import FollowOptions, follow, follows_curve
from trajopt.values.documents.document import Node


def follow_curve(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Follow a curve with a frame as far as it goes: `{"follows_curve": {...}, "options": {...}}`."""
    arguments.only(("edits", "follows_curve", "group", "start", "options", "seconds"))
    state = changed(state, arguments)
    seconds = arguments["seconds"].number(0.0)
    found = follow(
        state.scene,
        called(follows_curve, arguments["follows_curve"]),
        start=value_of(arguments["start"]) if arguments.has("start") else state.positions,
        group=arguments["group"].text(""),
        options=called(FollowOptions, arguments["options"]),
        budget=Budget(seconds or None),
        cancel=watch.cancel,
        progress=watch.progress if watch.heard else None,
    )
    return Answer(found.as_dict())
