"""Hints for attributes that users of other libraries look for under another name."""

from collections.abc import Mapping


def unknown_attribute(owner: object, name: str, other_names: Mapping[str, str]) -> AttributeError:
    """Return the error of an attribute that does not exist, with the name that is meant if it is known.

    Args:
        owner: The object.
        name: The attribute.
        other_names: Name in another library -> the expression to use here.
    """
    words = f"{type(owner).__name__!r} object has no attribute {name!r}"
    hint = other_names.get(name)
    return AttributeError(f"{words}: use {hint}" if hint else words, name=name, obj=owner)
