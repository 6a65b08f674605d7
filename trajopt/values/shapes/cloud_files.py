"""Files of points (numpy, PLY, PCD) and octrees (OctoMap)."""

import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trajopt.values.arrays import Floats, Ints
from trajopt.values.arrays import path as path_of
from trajopt.values.documents.files import is_file, read_bytes
from trajopt.values.errors import FileFormatError, MissingExtra

_LARGEST = 2**31  # bytes that a compressed cloud may unfold to
_LENGTH_BITS, _LONG = 5, 7


def pcd_points(data: bytes) -> Floats:
    """Return the points of a PCD file, shape (n, 3)."""
    mark = data.find(b"\nDATA ") + 1
    if mark < 1:
        raise ValueError("no PCD header")
    end = data.index(b"\n", mark)
    text = data[:end].decode("ascii", errors="replace")
    lines = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
    header = {words[0]: words[1:] for words in lines if words}
    fields, count = header["FIELDS"], int(header["POINTS"][0])
    kinds = [f"<{kind.lower()}{size}" for kind, size in zip(header["TYPE"], header["SIZE"], strict=True)]
    repeats = [int(number) for number in header.get("COUNT", ["1"] * len(fields))]
    if count < 0 or any(number < 0 for number in repeats):
        raise ValueError("a count is negative")
    body, form = data[end + 1 :], header["DATA"][0]
    if form == "ascii":
        return _pcd_ascii(body, fields, repeats, count)
    names = [f"{name}#{place}" if fields.index(name) < place else name for place, name in enumerate(fields)]
    row = np.dtype([(name, kind, (many,)) for name, kind, many in zip(names, kinds, repeats, strict=True)])
    if form == "binary":
        if count * row.itemsize > len(body):
            raise ValueError("it ends within the points")
        table = np.frombuffer(body, row, count)
        return np.stack([table[axis][:, 0].astype(np.float64) for axis in "xyz"], axis=1)
    if form != "binary_compressed":
        raise ValueError(f"unknown kind of data {form!r}")
    return _pcd_columns(_unfolded(body, count * row.itemsize), row, count)


def _pcd_ascii(body: bytes, fields: Sequence[str], repeats: Sequence[int], count: int) -> Floats:
    rows = [line.split() for line in body.decode("ascii", errors="replace").splitlines() if line.strip()][
        :count
    ]
    if len(rows) < count:
        raise ValueError("it ends within the points")
    begins = np.cumsum([0, *repeats])
    columns = [int(begins[fields.index(axis)]) for axis in "xyz"]
    return np.array([[row[column] for column in columns] for row in rows], dtype=np.float64).reshape(-1, 3)


def _pcd_columns(unfolded: bytes, row: np.dtype[np.void], count: int) -> Floats:
    found: dict[str, Floats] = {}
    begin = 0
    for name in row.names or ():
        kind = row[name]
        if name in ("x", "y", "z"):
            values = np.frombuffer(unfolded, kind.base, count * (kind.itemsize // kind.base.itemsize), begin)
            found[name] = values.reshape(count, -1)[:, 0].astype(np.float64)
        begin += kind.itemsize * count
    return np.stack([found[axis] for axis in "xyz"], axis=1)


def _unfolded(body: bytes, expected: int) -> bytes:
    folded, size = (int(number) for number in np.frombuffer(body, "<u4", 2))
    if size != expected or size > _LARGEST or folded > len(body) - 8:
        raise ValueError("the sizes of the compressed points contradict the header")
    data, found, at = memoryview(body)[8 : 8 + folded], bytearray(), 0
    while at < folded:
        control = data[at]
        at += 1
        if control < 1 << _LENGTH_BITS:
            found += data[at : at + control + 1]
            at += control + 1
            continue
        length = control >> _LENGTH_BITS
        if length == _LONG:
            length += data[at]
            at += 1
        begin = len(found) - ((control & 31) << 8) - data[at] - 1
        at += 1
        length += 2
        if begin < 0 or len(found) + length > expected:
            raise ValueError("the compressed points are damaged")
        while length > 0:  # the copy may run into what it writes
            piece = found[begin : begin + length]
            found += piece
            begin, length = begin + len(piece), length - len(piece)
    if len(found) != expected:
        raise ValueError("the compressed points are damaged")
    return bytes(found)


_KINDS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass
class _Element:
    label: str
    count: int
    columns: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])


def ply_points(data: bytes) -> Floats:
    """Return the vertices of a PLY file, shape (n, 3)."""
    mark = data.find(b"end_header")
    if not data.startswith(b"ply") or mark < 0:
        raise ValueError("no PLY header")
    begin = data.index(b"\n", mark) + 1
    form, elements = _ply_header(data[:mark].decode("ascii", errors="replace"))
    if form == "ascii":
        return _ply_ascii(data[begin:], elements)
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


def _ply_header(text: str) -> tuple[str, list[_Element]]:
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


def _ply_ascii(data: bytes, elements: list[_Element]) -> Floats:
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


NAMED = "points"
"""Name of the points in an .npz file with several arrays."""


def read_points(path: Path | str) -> Floats:
    """Return the finite points of a file, shape (n, 3) [m]."""
    path = path_of("path", path)
    read = _READERS.get(path.suffix.lower())
    if read is None:
        raise FileFormatError(str(path), f"is not a cloud: {', '.join(_READERS)} files are read")
    if not is_file(path):
        raise FileFormatError(str(path), "no such file")
    try:
        points = read(read_bytes(path))
    except (
        ValueError,
        TypeError,
        SyntaxError,
        TokenError,
        RecursionError,
        KeyError,
        IndexError,
        OverflowError,
        EOFError,
        OSError,
        MemoryError,
    ) as error:
        raise FileFormatError(str(path), f"cannot be read as a cloud: {error}") from error
    points = points[np.isfinite(points).all(axis=1)]
    if not len(points):
        raise FileFormatError(str(path), "holds no point of which all coordinates are finite")
    return points


def _npy(data: bytes) -> Floats:
    return _columns(np.load(io.BytesIO(data), allow_pickle=False))


def _npz(data: bytes) -> Floats:
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        names = list(arrays.files)
        if NAMED not in names and len(names) != 1:
            raise ValueError(f"no array is named {NAMED!r}, and there are {len(names)}")
        return _columns(arrays[NAMED if NAMED in names else names[0]])


def _columns(array: NDArray[Any]) -> Floats:
    if array.ndim == 3:
        array = array.reshape(-1, array.shape[2])
    if array.ndim != 2 or array.shape[1] < 3 or array.dtype.kind not in "fiu":
        raise ValueError(f"needs numbers of shape (any, 3), has {array.dtype} of shape {array.shape}")
    return array[:, :3].astype(np.float64)


_READERS: Mapping[str, Callable[[bytes], Floats]] = {
    ".ply": ply_points,
    ".pcd": pcd_points,
    ".npy": _npy,
    ".npz": _npz,
}


MOST_CELLS = 8_000_000
"""Most cells after subdivision: a wall of 50 m by 10 m by 1 m, in 4 cm."""
_HEADER = 4096  # bytes at the beginning in which the header is


def read_octree(path: Path | str) -> tuple[Ints, float]:
    """Return the keys of the occupied cells at the smallest size, shape (n, 3), and that size [m].

    Raises:
        MissingExtra: Without octomap-python.
        FileFormatError: If the file is missing or malformed, or has no or too many occupied cells.
    """
    path = path_of("path", path)
    if path.suffix not in (".bt", ".ot"):
        raise FileFormatError(str(path), "is not an octree: .bt and .ot files are read")
    if not is_file(path):
        raise FileFormatError(str(path), "no such file")
    tree = _tree(path, read_bytes(path))
    size, depth = float(tree.getResolution()), int(tree.getTreeDepth())
    found: list[Ints] = []
    count = 0
    for leaf in tree.begin_leafs():
        if not tree.isNodeOccupied(leaf):
            continue
        edge = 1 << (depth - int(leaf.getDepth()))
        count += edge**3
        if count > MOST_CELLS:
            raise FileFormatError(str(path), f"has more than {MOST_CELLS} occupied cells")
        lowest = np.rint(np.asarray(leaf.getCoordinate()) / size - edge / 2.0).astype(np.int64)
        within = np.arange(edge)
        found.append(lowest + np.stack(np.meshgrid(within, within, within), axis=-1).reshape(-1, 3))
    if not found:
        raise FileFormatError(str(path), "has no occupied cell")
    return np.concatenate(found), size


def _tree(path: Path, data: bytes) -> Any:
    try:
        import octomap
    except ImportError as error:
        raise MissingExtra("octomap-python", "octomap") from error
    stated = re.search(rb"^size (\d+)\s*$", data[:_HEADER], re.MULTILINE)
    name = str(path).encode()
    try:
        if path.suffix == ".bt":
            tree: Any = octomap.OcTree(0.1)
            read = bool(tree.readBinary(name))
        else:
            tree, read = octomap.OcTree.read(name), True
    except (OSError, ValueError, RuntimeError) as error:
        raise FileFormatError(str(path), f"cannot be read as an octree: {error}") from error
    if not read or stated is None or int(stated[1]) != tree.size():
        raise FileFormatError(str(path), "cannot be read as an octree: it is damaged, or of another kind")
    return tree
