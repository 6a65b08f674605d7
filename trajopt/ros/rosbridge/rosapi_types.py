"""What messages consist of, as `/rosapi/message_details` tells it."""

from dataclasses import fields
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from trajopt.files.messages.builtin_interfaces import Stamp
from trajopt.files.messages.names import name_of
from trajopt.files.messages.primitives import PLAIN, Bytes, Primitive


def typedefs(kind: type[Any]) -> list[dict[str, object]]:
    """Return the definition of a message, and those of all messages in it.

    Args:
        kind: The message's class.
    """
    found: dict[type, dict[str, object]] = {}
    _collect(kind, found)
    return list(found.values())


def _collect(kind: type[Any], found: dict[type, dict[str, object]]) -> None:
    if kind in found or issubclass(kind, Stamp):
        return
    hints = get_type_hints(kind, include_extras=True)
    names, types, lengths, examples = list[str](), list[str](), list[int](), list[str]()
    found[kind] = {
        "type": name_of(kind),
        "fieldnames": names,
        "fieldtypes": types,
        "fieldarraylen": lengths,
        "examples": examples,
        "constnames": [name for name in vars(kind) if name.isupper()],
        "constvalues": [str(value) for name, value in vars(kind).items() if name.isupper()],
    }
    for each in fields(kind):
        hint = hints[each.name]
        several = get_origin(hint) is list or hint == Bytes
        inner = get_args(hint)[0] if get_origin(hint) is list else hint
        names.append(each.name)
        types.append(_name(inner))
        lengths.append(0 if several else -1)
        examples.append("[]" if several else _example(inner))
        if _is_message(inner):
            _collect(inner, found)


def _is_message(kind: Any) -> bool:
    return get_origin(kind) is not Annotated and kind not in PLAIN


def _name(kind: Any) -> str:
    if get_origin(kind) is Annotated:
        primitive: Primitive = get_args(kind)[1]
        return primitive.name
    return PLAIN[kind].name if kind in PLAIN else name_of(kind)


def _example(kind: Any) -> str:
    plain = get_args(kind)[0] if get_origin(kind) is Annotated else kind
    return {bool: "false", int: "0", float: "0.0", str: ""}.get(plain, "{}")
