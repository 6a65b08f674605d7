"""A stand-in for the controller of a UR: dashboard, port for scripts, and RTDE, in a process of its own.

The packages are those of Universal Robots' guide to RTDE:
https://www.universal-robots.com/articles/ur/interface-communication/real-time-data-exchange-rtde-guide/.
The program is the script that ur_rtde sends: it reads a command and its arguments from the input registers,
and answers in the first output register.
"""

import os
import socket
import struct
import threading
import time
from collections.abc import Callable
from itertools import count
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

DASHBOARD, SCRIPTS, RTDE = 29999, 30003, 30004
FREQUENCY, FASTEST = 500.0, 3.0
"""Cycles of the controller per second; largest speed of a joint [rad/s]."""
READY, DONE = 1, 2
SERVO_JOINTS, SERVO_STOP, STOP_SCRIPT = 11, 16, 255
"""Commands of ur_rtde's script."""
ANSWERS = {
    "polyscopeversion": "URSoftware 5.12.0.1101319 (Mar 22 2022)",
    "get serial number": "20195500001",
    "is in remote control": "true",
}
FORMATS = {
    "VECTOR6D": "6d", "VECTOR3D": "3d", "VECTOR6INT32": "6i", "DOUBLE": "d", "INT32": "i", "UINT32": "I",
    "UINT64": "Q", "BOOL": "?", "UINT8": "B",
}  # fmt: skip
TYPES = {
    "VECTOR6D": (
        *(f"{kind}_{what}" for kind in ("target", "actual") for what in ("q", "qd", "current")),
        *(f"{kind}_TCP_{what}" for kind in ("target", "actual") for what in ("pose", "speed", "force")),
        *("target_qdd", "target_moment", "joint_control_output", "joint_temperatures"),
        *("actual_joint_voltage", "ft_raw_wrench", "payload_inertia", "external_force_torque"),
    ),
    "VECTOR3D": ("actual_tool_accelerometer", "payload_cog"),
    "VECTOR6INT32": ("joint_mode",),
    "INT32": (
        *("robot_mode", "safety_mode"),
        *(f"{way}_int_register_{i}" for way in ("input", "output") for i in range(48)),
    ),
    "UINT32": ("robot_status_bits", "safety_status_bits", "runtime_state"),
    "UINT64": ("actual_digital_input_bits", "actual_digital_output_bits"),
    "DOUBLE": (
        *("timestamp", "actual_execution_time", "speed_scaling", "target_speed_fraction", "actual_momentum"),
        *("actual_main_voltage", "actual_robot_voltage", "actual_robot_current", "payload"),
        *(f"standard_analog_{way}{i}" for way in ("input", "output") for i in range(2)),
        *(f"{way}_double_register_{i}" for way in ("input", "output") for i in range(48)),
    ),
}  # fmt: skip
TYPE_OF = {name: kind for kind, names in TYPES.items() for name in names}


class Controller:
    """Arm, program and registers; other processes set and read its attributes through a pipe."""

    def __init__(self, host: str) -> None:
        self.lock = threading.RLock()
        self.q, self.qd, self.target = [0.0] * 6, [0.0] * 6, [0.0] * 6
        self.protective = self.emergency = self.running = False
        self.answer, self.script, self.servoed, self.stops = 0, b"", 0, list[float]()
        self.timing = list[float]()
        for port, serve in ((DASHBOARD, self.dashboard), (SCRIPTS, self.scripts), (RTDE, self.rtde)):
            listening = socket.create_server((host, port))
            threading.Thread(target=accept, args=(listening, serve), daemon=True).start()
        threading.Thread(target=self.cycle, daemon=True).start()

    def cycle(self) -> None:
        """Move the arm to its target, in each cycle by the largest speed at most."""
        farthest = FASTEST / FREQUENCY
        while True:
            with self.lock:
                if self.protective or self.emergency:
                    self.running, self.target = False, list(self.q)
                for i, (here, there) in enumerate(zip(self.q, self.target, strict=True)):
                    step = min(max(there - here, -farthest), farthest)
                    self.q[i], self.qd[i] = here + step, step * FREQUENCY
            time.sleep(1.0 / FREQUENCY)

    def value(self, name: str) -> list[Any]:
        known: dict[str, list[Any]] = {
            "timestamp": [time.monotonic()],
            "actual_q": self.q,
            "actual_qd": self.qd,
            "target_q": self.target,
            "robot_mode": [7],
            "safety_mode": [1],
            "robot_status_bits": [1 | self.running << 1],
            "safety_status_bits": [(not self.protective) | self.protective << 2 | self.emergency << 7],
            "runtime_state": [2 if self.running else 1],
            "output_int_register_0": [self.answer],
        }
        return known.get(name, [0] * len(struct.unpack(f">{form(name)}", bytes(struct.calcsize(form(name))))))

    def outputs(self, names: list[str]) -> bytes:
        with self.lock:
            return b"".join(struct.pack(f">{form(name)}", *self.value(name)) for name in names)

    def command(self, kind: int, arguments: tuple[float, ...]) -> None:
        """Do the command of the program, which is done or ready for the next."""
        with self.lock:
            if not self.running:
                return
            if kind == SERVO_JOINTS:
                self.target, self.timing = list(arguments[:6]), list(arguments[6:])
                self.servoed += 1
            elif kind == SERVO_STOP:
                self.target = list(self.q)
                self.stops.append(arguments[0])
            elif kind == STOP_SCRIPT:
                self.running = False
            self.answer = READY if kind in (0, SERVO_JOINTS) else DONE

    def dashboard(self, client: socket.socket) -> None:
        client.sendall(b"Connected: Universal Robots Dashboard Server\n")
        for line in client.makefile():
            client.sendall(ANSWERS.get(line.strip().lower(), "unknown").encode() + b"\n")

    def scripts(self, client: socket.socket) -> None:
        text = b""
        while received := client.recv(65536):
            text += received
            if text.endswith(b"\nend\n"):
                with self.lock:
                    self.script, text = text, b""
                    if not (self.protective or self.emergency):
                        self.running, self.answer = True, READY

    def rtde(self, client: socket.socket) -> None:
        session = Session(self, client)
        while True:
            size, kind = struct.unpack(">HB", exactly(client, 3))
            session.take(chr(kind), exactly(client, size - 3))


class Session:
    """A client of RTDE, with its recipes."""

    def __init__(self, controller: Controller, client: socket.socket) -> None:
        self.controller, self.client = controller, client
        self.inputs, self.outputs, self.frequency = list[list[str]](), list[str](), 125.0
        self.started, self.sending = threading.Event(), threading.Lock()

    def take(self, kind: str, body: bytes) -> None:
        match kind:
            case "V":
                self.send(kind, bytes((body == b"\x00\x02",)))
            case "v":
                self.send(kind, struct.pack(">4I", 5, 12, 0, 1101319))
            case "O":
                (self.frequency,), self.outputs = struct.unpack(">d", body[:8]), names_of(body[8:])
                self.send(kind, b"\x01" + types_of(self.outputs))
            case "I":
                self.inputs.append(names_of(body))
                self.send(kind, bytes((len(self.inputs),)) + types_of(self.inputs[-1]))
            case "S":
                self.send(kind, b"\x01")
                self.started.set()
                threading.Thread(target=self.stream, daemon=True).start()
            case "P":
                self.started.clear()
                self.send(kind, b"\x01")
            case "U":
                names = self.inputs[body[0] - 1]
                values = struct.unpack(">" + "".join(map(form, names)), body[1:])
                self.controller.command(int(values[0]), values[1:])
            case _:
                raise ValueError(f"no package is of type {kind!r}")

    def stream(self) -> None:
        try:
            while self.started.is_set():
                self.send("U", b"\x01" + self.controller.outputs(self.outputs))
                time.sleep(1.0 / self.frequency)
        except OSError:
            pass

    def send(self, kind: str, body: bytes) -> None:
        with self.sending:
            self.client.sendall(struct.pack(">HB", 3 + len(body), ord(kind)) + body)


def form(name: str) -> str:
    return FORMATS[TYPE_OF[name]]


def names_of(body: bytes) -> list[str]:
    return [name for name in body.decode().split(",") if name]


def types_of(names: list[str]) -> bytes:
    return ",".join(TYPE_OF.get(name, "NOT_FOUND") for name in names).encode()


def exactly(client: socket.socket, size: int) -> bytes:
    found = b""
    while len(found) < size:
        if not (received := client.recv(size - len(found))):
            raise ConnectionError("the client has gone")
        found += received
    return found


def accept(listening: socket.socket, serve: Callable[[socket.socket], None]) -> None:
    def attend(client: socket.socket) -> None:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            serve(client)
        except OSError:
            client.close()

    while True:
        threading.Thread(target=attend, args=(listening.accept()[0],), daemon=True).start()


def run(host: str, pipe: Connection) -> None:
    """Serve until the pipe is closed."""
    controller = Controller(host)
    pipe.send(None)
    try:
        while True:
            name, value = pipe.recv()
            with controller.lock:
                if value is not None:
                    setattr(controller, name, value)
                pipe.send(getattr(controller, name))
    except EOFError:
        pass


class StandIn:
    """The process of a controller, at an address of its own."""

    made = count(1)

    def __init__(self) -> None:
        process, number = os.getpid(), next(StandIn.made)
        self.host = f"127.{1 + process % 250}.{1 + process // 250 % 250}.{number}"
        self.pipe, other = get_context("spawn").Pipe()
        self.process = get_context("spawn").Process(target=run, args=(self.host, other), daemon=True)
        self.process.start()
        other.close()
        self.pipe.recv()

    def __enter__(self) -> "StandIn":
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def read(self, name: str) -> Any:
        return self.set(name, None)

    def set(self, name: str, value: Any) -> Any:
        self.pipe.send((name, value))
        return self.pipe.recv()

    def end(self) -> None:
        """End the process, which closes its connections."""
        self.process.kill()
        self.process.join()
