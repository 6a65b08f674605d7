"""Messages of `object_recognition_msgs`: which thing of a database an object is."""

from dataclasses import dataclass


@dataclass(slots=True)
class ObjectType:
    """A thing of a database, by its key there; nothing here looks at it."""

    key: str = ""
    db: str = ""
