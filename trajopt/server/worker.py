"""A worker: a process that handles requests in sequence, with progress.

It reads messages from the socket whose number is its argument, and ends when that is closed.
"""

import os
import pickle
import socket
import sys
import time
import traceback
from collections.abc import Mapping
from functools import partial
from queue import SimpleQueue
from threading import Thread
from typing import cast

import msgspec
import numpy as np

from trajopt.robot.robot import Robot
from trajopt.scene.scene import Scene
from trajopt.server import messages
from trajopt.server.limits import RequestRefused, Why, check_sizes, limit_memory, memory_used
from trajopt.server.operation import Answer, PackedScene, SessionState, Watch, operations_of, packed, unpacked
from trajopt.values.cached import LruCache
from trajopt.values.documents.document import Node
from trajopt.values.documents.files import parse_json
from trajopt.values.errors import TrajoptError
from trajopt.values.processes import die_with_parent

SCENES = 8
"""Number of scenes kept unpacked, with their derived data."""
REQUEST = "request"
"""Name of a request in error messages instead of a file name."""
_JSON = msgspec.json.Encoder()


class Channel:
    """The socket to the server, message by message."""

    def __init__(self, connected: socket.socket) -> None:
        self._socket, self._stream = connected, connected.makefile("rb")

    def receive(self) -> messages.ToWorker | None:
        head = self._stream.read(messages.LENGTH.size)
        if len(head) < messages.LENGTH.size:
            return None
        return messages.TO_WORKER.decode(self._stream.read(messages.LENGTH.unpack(head)[0]))

    def send(self, message: messages.FromWorker) -> None:
        self._socket.sendall(messages.framed(message))


class Worker:
    """Handles the server's requests in sequence."""

    def __init__(self, channel: Channel, hello: messages.Hello) -> None:
        self._channel, self._hello = channel, hello
        self._robots = {name: cast(Robot, pickle.loads(data)) for name, data in hello.robots.items()}
        self._operations = operations_of(hello.modules)
        self._scenes: LruCache[bytes, Scene] = LruCache(SCENES)
        self._waiting: SimpleQueue[tuple[messages.Request, Watch]] = SimpleQueue()
        self._watches: dict[int, Watch] = {}

    def serve(self) -> None:
        """Do requests until the server closes the socket."""
        Thread(target=self._listen, name="listen", daemon=True).start()
        self._channel.send(messages.WorkerReady(memory_used()))
        while True:
            request, watch = self._waiting.get()
            begin = time.process_time()
            limit_memory(self._hello.memory)
            try:
                said = self._answered(request, watch)
            except RequestRefused as refusal:
                said = messages.Rejected(request.number, refusal.why.value, refusal.reason, 0.0, 0)
            self._watches.pop(request.number, None)
            used = time.process_time() - begin
            self._channel.send(msgspec.structs.replace(said, cpu=used, memory=memory_used()))

    def _answered(self, request: messages.Request, watch: Watch) -> messages.Answered | messages.Rejected:
        try:
            answer = self._run(request, watch)
            body = _JSON.encode(answer.document)
            state = answer.state
            if state is None:
                return messages.Answered(request.number, body, None, None, {}, 0.0, 0)
            scene = packed(state, self._robots)
        except RequestRefused:
            raise
        except TrajoptError as error:
            raise RequestRefused(Why.MALFORMED, str(error)) from error
        except MemoryError as error:
            raise RequestRefused(Why.OUT_OF_MEMORY, "it took more memory than one request may") from error
        except Exception as error:
            # The reason is for who runs the server, not for who asked: it may tell of the server's files.
            traceback.print_exc()
            raise RequestRefused(Why.FAILED, f"a fault of the server ({type(error).__name__})") from error
        self._scenes.get(scene.key, lambda: state.scene)
        places, stamps = state.positions.tolist(), dict(state.stamps)
        return messages.Answered(request.number, body, scene.data, places, stamps, 0.0, 0)

    def _run(self, request: messages.Request, watch: Watch) -> Answer:
        try:
            text = request.body.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise RequestRefused(Why.MALFORMED, f"{REQUEST}: is not UTF-8 text: {error}") from error
        document: object = parse_json(text, REQUEST) if text else {}
        arguments = Node(document, REQUEST)
        if not isinstance(document, dict):
            raise arguments.error("must be a mapping")
        scene = self._scene(request)
        check_sizes(cast(object, document), watch)
        positions = np.array(request.positions)
        state = SessionState(request.robot, scene, positions, request.stamps)
        return self._operations[request.operation].run(state, arguments, watch)

    def _scene(self, request: messages.Request | messages.Changed) -> Scene:
        scene = PackedScene(request.robot, request.scene, request.key)
        return self._scenes.get(scene.key, lambda: unpacked(scene, self._robots))

    def _listen(self) -> None:
        try:
            while (message := self._channel.receive()) is not None:
                self._hear(message)
        except Exception:
            traceback.print_exc()
            os._exit(1)  # the server starts another
        os._exit(0)  # in the midst of a request nobody waits for

    def _hear(self, message: messages.ToWorker) -> None:
        match message:
            case messages.Request():
                watch = self._watch(message)
                self._watches[message.number] = watch
                self._waiting.put((message, watch))
            case messages.Cancel():
                if (watch := self._watches.get(message.number)) is not None:
                    watch.cancel.set()
            case messages.Changed():
                if (watch := self._watches.get(message.number)) is not None:
                    watch.change(partial(self._scene, message))
            case _:
                pass

    def _watch(self, request: messages.Request) -> Watch:
        def tell(document: Mapping[str, object], positions: list[float] | None) -> None:
            self._channel.send(messages.Feedback(request.number, _JSON.encode(document), positions))

        listener = tell if request.feedback else None
        return Watch(
            request.seconds,
            listener,
            triangles=self._hello.triangles,
            points=self._hello.points,
            cloud=self._hello.cloud,
            attachment=request.attachment,
            driven=request.driven,
        )


def main() -> None:
    """Serve the socket whose number is the argument."""
    die_with_parent()
    channel = Channel(socket.socket(fileno=int(sys.argv[1])))
    hello = channel.receive()
    if isinstance(hello, messages.Hello):
        Worker(channel, hello).serve()


if __name__ == "__main__":
    main()
