"""PCD files of the Point Cloud Library: ascii, binary and binary_compressed.

The viewpoint of the header, where the sensor was, moves no point: it does not in that library either.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from trajopt.values.arrays import Floats

_LARGEST = 2**31  # bytes that a compressed cloud may unfold to
_LENGTH_BITS, _LONG = 5, 7


def pcd_points(data: bytes) -> Floats:
    """Return the points of a PCD file, shape (n, 3).

    Raises:
        ValueError: If it is malformed.
        KeyError: If the points lack a coordinate, or the header a line.
    """
    mark = data.find(b"\nDATA ") + 1
    if mark < 1:
        raise ValueError("no PCD header")
    end = data.index(b"\n", mark)
    header = _header(data[:end].decode("ascii", errors="replace"))
    fields, count = header["FIELDS"], int(header["POINTS"][0])
    kinds = [f"<{kind.lower()}{size}" for kind, size in zip(header["TYPE"], header["SIZE"], strict=True)]
    repeats = [int(number) for number in header.get("COUNT", ["1"] * len(fields))]
    if count < 0 or any(number < 0 for number in repeats):
        raise ValueError("a count is negative")
    body, form = data[end + 1 :], header["DATA"][0]
    if form == "ascii":
        return _ascii(body, fields, repeats, count)
    names = [f"{name}#{place}" if fields.index(name) < place else name for place, name in enumerate(fields)]
    row = np.dtype([(name, kind, (many,)) for name, kind, many in zip(names, kinds, repeats, strict=True)])
    if form == "binary":
        if count * row.itemsize > len(body):
            raise ValueError("it ends within the points")
        table = np.frombuffer(body, row, count)
        return np.stack([table[axis][:, 0].astype(np.float64) for axis in "xyz"], axis=1)
    if form != "binary_compressed":
        raise ValueError(f"unknown kind of data {form!r}")
    return _columns(_unfolded(body, count * row.itemsize), row, count)


def _header(text: str) -> Mapping[str, Sequence[str]]:
    lines = [line.split() for line in text.splitlines() if line and not line.startswith("#")]
    return {words[0]: words[1:] for words in lines if words}


def _ascii(body: bytes, fields: Sequence[str], repeats: Sequence[int], count: int) -> Floats:
    rows = [line.split() for line in body.decode("ascii", errors="replace").splitlines() if line.strip()][
        :count
    ]
    if len(rows) < count:
        raise ValueError("it ends within the points")
    begins = np.cumsum([0, *repeats])
    columns = [int(begins[fields.index(axis)]) for axis in "xyz"]
    return np.array([[row[column] for column in columns] for row in rows], dtype=np.float64).reshape(-1, 3)


def _columns(unfolded: bytes, row: np.dtype[np.void], count: int) -> Floats:
    """Return the points of compressed data, which holds all values of a field before those of the next."""
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
    """Undo the compression; source: Lehmann, LibLZF."""
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
