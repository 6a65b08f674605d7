"""Fingerprints: digests of the content of values, independent of file names and locations."""

import json
from functools import cache
from hashlib import file_digest, sha256
from pathlib import Path

from trajopt.files.bundle.codec import BundleWriter


def _digest(path: Path) -> str:
    # The document contains the model of the description; only meshes are files.
    if path.suffix.lower() == ".urdf" or not path.is_file():
        return path.suffix.lower()
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()


def fingerprint(value: object) -> str:
    """Return a digest; values with equal numbers, names and mesh contents have equal digests.

    Args:
        value: A robot, a scene, a problem or a part of one.

    Raises:
        ModelError: If it contains an object that cannot be stored, such as code of the caller.
    """
    return digest_as_written(BundleWriter(file_name=cache(_digest)), value)


def digest_as_written(writer: BundleWriter, value: object) -> str:
    """Return a digest of a value's document and arrays, as written by a new writer.

    Raises:
        ModelError: If the value contains an object that cannot be stored.
    """
    whole = sha256(json.dumps(writer.document(value, type(value).__name__)).encode())
    for array in writer.arrays.values():
        whole.update(f"{array.dtype} {array.shape}".encode() + array.tobytes())
    return whole.hexdigest()
