"""Sessions on disk, as workers write and read them: each a scene and a state in a warehouse, under its id.

Only the server itself asks for these: no face passes on the names of these operations.
"""

from collections.abc import Mapping
from dataclasses import replace
from tempfile import TemporaryDirectory

from trajopt.files.bundle.fingerprint import fingerprint
from trajopt.files.bundle.message import message_of, value_of_message
from trajopt.scene.scene import Scene
from trajopt.server.operation import Answer, Lane, Operation
from trajopt.server.state import SessionState
from trajopt.server.warehouse import Kind, State, Warehouse
from trajopt.server.watch import Watch
from trajopt.values.documents.document import Node
from trajopt.values.errors import ModelError

SESSION = "session"
"""Marks what a server keeps, among whatever else there is in the file."""
KINDS = (Kind.SCENE, Kind.STATE)


def keep(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Keep what a session holds, or as much of it as has changed; what was kept of it before goes.

    It is there as a whole: a scene is never found beside the positions of another time.
    """
    name, face = arguments["session"].text(), arguments["face"].text("")
    tags = (SESSION, face) if face else (SESSION,)
    with _warehouse(arguments) as kept, kept.together():
        if arguments["scene"].value:
            kept.add(name, state.scene, tags=tags)
        if arguments["positions"].value:
            kept.add(name, State(state.robot, state.named_positions), tags=tags)
        for kind in KINDS:
            # By version: a clock that was set back has what was kept last be older than what was before.
            versions = sorted(entry.version for entry in kept.find(kind=kind, name=name))
            for version in versions[:-1]:
                kept.remove(name, kind=kind, version=version)
    return Answer({})


def forget(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Remove a session from the disk."""
    name = arguments["session"].text()
    with _warehouse(arguments) as kept, kept.together():
        for kind in KINDS:
            if kept.find(kind=kind, name=name):
                kept.remove(name, kind=kind)
    return Answer({})


def restore(state: SessionState, arguments: Node, watch: Watch) -> Answer:
    """Return the scene and the positions of a session, with this server's robot in the scene.

    Raises:
        ModelError: If the robot has changed: names and allowed collisions are of the robot as it was.
    """
    robot, name = state.scene.robot, arguments["session"].text()
    with _warehouse(arguments) as kept, TemporaryDirectory() as folder:
        entry = kept.entry(name, kind=Kind.SCENE)
        scene: Scene = kept.load(entry, meshes=folder)
        positions = kept.state(name).positions
        same = fingerprint(scene.robot) == fingerprint(robot)
    if not same:
        raise ModelError(f"robot {state.robot!r} has changed since the session was kept")
    message = Node(message_of(scene, {"robot": scene.robot}), name)
    held = value_of_message(message, {"robot": robot}, Scene)
    return Answer(
        {"revision": entry.version}, replace(state, scene=held, positions=robot.positions(positions))
    )


def _warehouse(arguments: Node) -> Warehouse:
    return Warehouse(arguments["warehouse"].text(), create=False)


OPERATIONS: Mapping[str, Operation] = {
    "keeping/keep": Operation(keep, Lane.KEEPING),
    "keeping/forget": Operation(forget, Lane.KEEPING),
    "keeping/restore": Operation(restore, Lane.KEEPING),
}
"""What the server asks a worker that keeps sessions."""
