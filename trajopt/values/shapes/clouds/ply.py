"""PLY files: the vertices, whatever else there is.

Source: Turk, The PLY polygon file format, Stanford 1994.
"""

from dataclasses import dataclass, field

import numpy as np

from trajopt.values.arrays import Floats

_KINDS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass
class _Element:
    """A table of the file: its label, how many rows, and name and kind of each column; a list has no kind."""

    label: str
    count: int
    columns: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])


def ply_points(data: bytes) -> Floats:
    """Return the vertices of a PLY file, shape (n, 3).

    Raises:
        ValueError: If it is malformed.
        KeyError: If the vertices lack a coordinate.
    """
    mark = data.find(b"end_header")
    if not data.startswith(b"ply") or mark < 0:
        raise ValueError("no PLY header")
    begin = data.index(b"\n", mark) + 1
    form, elements = _header(data[:mark].decode("ascii", errors="replace"))
    if form == "ascii":
        return _ascii(data[begin:], elements)
    if form not in _ORDERS:
        raise ValueError(f"unknown format {form!r}")
    for element in elements:
        if any(not kind for _, kind in element.columns):
            raise ValueError(
                f"the element {element.label!r}, which has lists, comes before or with the vertices"
            )
        row = np.dtype([(name, _ORDERS[form] + kind) for name, kind in element.columns])
        if begin + element.count * row.itemsize > len(data):
            raise ValueError(f"it ends within the element {element.label!r}")
        if element.label == "vertex":
            table = np.frombuffer(data, row, element.count, begin)
            return np.stack([table[axis].astype(np.float64) for axis in "xyz"], axis=1)
        begin += element.count * row.itemsize
    raise ValueError("no element is named 'vertex'")


def _header(text: str) -> tuple[str, list[_Element]]:
    """Return the format, and the elements up to the vertices."""
    form, elements = "", list[_Element]()
    for line in text.splitlines():
        words = line.split()
        match words:
            case ["format", form, _]:
                pass
            case ["element", name, count]:
                if elements and elements[-1].label == "vertex":
                    break
                elements.append(_Element(name, int(count)))
            case ["property", "list", _, _, name] if elements:
                elements[-1].columns.append((name, ""))
            case ["property", kind, name] if elements:
                elements[-1].columns.append((name, _KINDS[kind]))
            case _:
                pass
    if any(element.count < 0 for element in elements):
        raise ValueError("an element has a negative count")
    return form, elements


def _ascii(data: bytes, elements: list[_Element]) -> Floats:
    lines = [line for line in data.decode("ascii", errors="replace").splitlines() if line.strip()]
    begin = 0
    for element in elements:
        if element.label == "vertex":
            rows = lines[begin : begin + element.count]
            if len(rows) < element.count:
                raise ValueError("it ends within the element 'vertex'")
            names = [name for name, _ in element.columns]
            columns = [names.index(axis) for axis in "xyz"]
            table = [[row.split()[column] for column in columns] for row in rows]
            return np.array(table, dtype=np.float64).reshape(-1, 3)
        begin += element.count
    raise ValueError("no element is named 'vertex'")
