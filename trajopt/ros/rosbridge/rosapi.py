"""`/rosapi/*`: queries about the server itself, in the formats of ROS 1 and ROS 2."""

import asyncio
import base64
import json
import time
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias, cast

from trajopt.files.messages import Generation, Time, definitions, encode, message_named, plain_name
from trajopt.files.messages.definitions import INITIAL
from trajopt.ros.rosbridge.actions import ACTIONS, SERVICES
from trajopt.ros.rosbridge.description import RobotDescription
from trajopt.ros.rosbridge.offered import OfferedActions, OfferedServices
from trajopt.ros.rosbridge.options import RosbridgeOptions
from trajopt.ros.rosbridge.topics import Topics
from trajopt.ros.rosbridge.wire import Unusable
from trajopt.values.errors import MessageNotFound

Reply: TypeAlias = Mapping[str, object]
NODE = "/trajopt"
PARAMETERS = 1000
LARGEST = 100_000
"""Most characters of a parameter set by a client."""


class RosApi:
    """Answers queries about topics, services, types and parameters."""

    def __init__(
        self,
        topics: Topics,
        offered: OfferedServices,
        actions: OfferedActions,
        description: RobotDescription,
        options: RosbridgeOptions,
    ) -> None:
        self._topics_known, self._offered = topics, offered
        self._description, self._options = description, options
        self.parameters: dict[str, str] = {
            "/robot_description": json.dumps(description.urdf),
            "/robot_description_semantic": json.dumps(description.srdf),
            "/rosdistro": json.dumps(f"{options.distro.title}\n"),
        }
        self.services: Mapping[str, Callable[[Mapping[str, Any]], Reply]] = {
            "get_ros_version": self._version,
            "get_time": self._time,
            "topics": self._topics,
            "topic_type": lambda asked: {"type": self._long(topics.kind(_text(asked, "topic")))},
            "topics_for_type": self._topics_for_type,
            "services": lambda _: {"services": sorted(self._services())},
            "service_type": self._service_type,
            "services_for_type": self._services_for_type,
            "service_request_details": lambda asked: self._details(asked, "Request"),
            "service_response_details": lambda asked: self._details(asked, "Response"),
            "message_details": lambda asked: self._details(asked, ""),
            "get_param": self._get_param,
            "set_param": self._set_param,
            "has_param": lambda asked: {"exists": _parameter(asked) in self.parameters},
            "delete_param": self._delete_param,
            "get_param_names": lambda _: {"names": sorted(self.parameters)},
            "search_param": self._search_param,
            "nodes": lambda _: {"nodes": [NODE]},
            "node_details": self._node_details,
            "service_node": lambda _: {"node": NODE},
            "service_host": lambda _: {"host": options.host},
            "service_providers": lambda _: {"providers": [NODE]},
            "publishers": lambda _: {"publishers": [NODE]},
            "subscribers": lambda _: {"subscribers": [NODE]},
            "action_servers": lambda _: {"action_servers": sorted({*ACTIONS, *actions.kinds()})},
        }

    def answer(self, name: str, arguments: object) -> Reply:
        service = self.services.get(name)
        if service is None:
            raise Unusable(f"there is no service /rosapi/{name}; known: {', '.join(sorted(self.services))}")
        if not isinstance(arguments, dict):
            raise Unusable(f"/rosapi/{name}: the arguments are a mapping")
        return service(cast("Mapping[str, Any]", arguments))

    async def file(self, arguments: object) -> Reply:
        name = _text(cast("Mapping[str, Any]", arguments if isinstance(arguments, dict) else {}), "name")
        found = await asyncio.to_thread(self._description.file, name.removeprefix("package://"))
        if found is None:
            raise Unusable("no file of the robot's packages has that name")
        return {"value": base64.b64encode(await asyncio.to_thread(found.read_bytes)).decode()}

    def _long(self, kind: str, between: str = "msg") -> str:
        if self._options.distro.generation is Generation.ROS1 or "/" not in kind:
            return kind
        package, _, name = kind.partition("/")
        return f"{package}/{between}/{name}"

    def _version(self, _: Mapping[str, Any]) -> Reply:
        distro = self._options.distro
        return {"version": distro.version, "distro": distro.title}

    def _time(self, _: Mapping[str, Any]) -> Reply:
        return {"time": encode(Time(*divmod(time.time_ns(), 10**9)), self._options.distro.generation)}

    def _topics(self, _: Mapping[str, Any]) -> Reply:
        names = self._topics_known.names()
        return {"topics": names, "types": [self._long(self._topics_known.kind(name)) for name in names]}

    def _topics_for_type(self, asked: Mapping[str, Any]) -> Reply:
        topics, kind = self._topics_known, plain_name(_text(asked, "type"))
        return {"topics": [name for name in topics.names() if topics.kind(name) == kind]}

    def _services(self) -> dict[str, str]:
        own = {name: service.kind for name, service in SERVICES.items()}
        return {**{f"/rosapi/{name}": "" for name in self.services}, **own, **self._offered.kinds()}

    def _service_type(self, asked: Mapping[str, Any]) -> Reply:
        return {"type": self._long(self._services().get(_text(asked, "service"), ""), "srv")}

    def _services_for_type(self, asked: Mapping[str, Any]) -> Reply:
        kind = plain_name(_text(asked, "type"))
        return {"services": sorted(name for name, each in self._services().items() if each == kind)}

    def _details(self, asked: Mapping[str, Any], behind: str) -> Reply:
        try:
            return {"typedefs": typedefs(message_named(_text(asked, "type") + behind))}
        except MessageNotFound as error:
            raise Unusable(str(error)) from error

    def _get_param(self, asked: Mapping[str, Any]) -> Reply:
        default = asked.get("default", asked.get("default_value", ""))
        value = self.parameters.get(_parameter(asked), default or '""')
        return {"value": value, "successful": _parameter(asked) in self.parameters, "reason": ""}

    def _set_param(self, asked: Mapping[str, Any]) -> Reply:
        value = _text(asked, "value")
        if len(value) > LARGEST or len(self.parameters) >= PARAMETERS:
            raise Unusable(f"there are {PARAMETERS} parameters of {LARGEST} characters at most")
        self.parameters[_parameter(asked)] = value
        return {"successful": True, "reason": ""}

    def _delete_param(self, asked: Mapping[str, Any]) -> Reply:
        self.parameters.pop(_parameter(asked), None)
        return {"successful": True, "reason": ""}

    def _search_param(self, asked: Mapping[str, Any]) -> Reply:
        name = _parameter(asked)
        return {"global_name": name if name in self.parameters else ""}

    def _node_details(self, _: Mapping[str, Any]) -> Reply:
        names = self._topics_known.names()
        return {"subscribing": names, "publishing": names, "services": sorted(self._services())}


def _text(asked: Mapping[str, Any], key: str) -> str:
    value = asked.get(key)
    if not isinstance(value, str):
        raise Unusable(f"{key} must be text")
    return value


def _parameter(asked: Mapping[str, Any]) -> str:
    name = _text(asked, "name").rpartition(":")[2]
    return name if name.startswith("/") else f"/{name}"


def typedefs(kind: type[Any]) -> list[dict[str, object]]:
    found: dict[str, dict[str, object]] = {}
    _collect(kind.definition.name, found)
    return list(found.values())


def _collect(name: str, found: dict[str, dict[str, object]]) -> None:
    if name in found or name.startswith("builtin_interfaces/"):
        return
    definition = definitions()[name]
    elements = [each.kind.removesuffix("[]") for each in definition.fields]
    found[name] = {
        "type": name,
        "fieldnames": [each.name for each in definition.fields],
        "fieldtypes": elements,
        "fieldarraylen": [0 if each.kind.endswith("[]") else -1 for each in definition.fields],
        "examples": ["[]" if each.kind.endswith("[]") else _example(each.kind) for each in definition.fields],
        "constnames": list(definition.constants),
        "constvalues": [str(value) for value in definition.constants.values()],
    }
    for element in elements:
        if element in definitions():
            _collect(element, found)


def _example(kind: str) -> str:
    initial = INITIAL.get(kind, "{}")
    return "false" if initial is False else str(initial)
