"""Messages of `object_recognition_msgs`: the type of an object in a database."""

from dataclasses import dataclass


@dataclass(slots=True)
class ObjectType:
    """The key of an object type in a database; ignored."""

    key: str = ""
    db: str = ""
