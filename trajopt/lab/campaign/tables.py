"""Rows as a table of Arrow, put together from arrays of numpy.

Arrow's own way from Python's objects imports pandas where that is installed, to see whether they are any of
its: a third of a second of each process that writes rows, and tens of megabytes, for nothing.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyarrow as pa


def table_of(rows: Sequence[Mapping[str, Any]], columns: "pa.Schema") -> "pa.Table":
    """Return rows as a table; what a row does not have is null there.

    Args:
        rows: Values by the name of their column: text, whole numbers, reals, truth values, sequences and
            mappings of these, or None.
        columns: The names and kinds of all columns.

    Raises:
        TypeError: If a column is of another kind.
    """
    import pyarrow as pa

    arrays = [_array([row.get(column.name) for row in rows], column.type) for column in columns]
    return pa.Table.from_arrays(arrays, schema=columns)


def _array(values: Sequence[Any], kind: "pa.DataType") -> "pa.Array":
    """Return values of one kind, of which any may be None.

    Raises:
        TypeError: If that kind is none that tables of campaigns have.
    """
    import pyarrow as pa

    known = pa.py_buffer(_bits([each is not None for each in values]))
    if kind == pa.string():
        texts = [b"" if each is None else each.encode() for each in values]
        return _built(kind, len(values), known, _ends(texts), b"".join(texts))
    if isinstance(kind, pa.ListType | pa.MapType):
        ends = pa.py_buffer(_ends(() if each is None else each for each in values))
        there = [each for each in values if each is not None]
        inner = _pairs(there, kind) if isinstance(kind, pa.MapType) else _items(there, kind)
        return pa.Array.from_buffers(kind, len(values), [known, ends], children=[inner])
    if kind == pa.bool_():
        return _built(kind, len(values), known, _bits([bool(each) for each in values]))
    for number, dtype in ((pa.int64(), np.int64), (pa.float64(), np.float64)):
        if kind == number:
            data = np.array([0 if each is None else each for each in values], dtype=dtype)
            return _built(kind, len(values), known, data)
    raise TypeError(f"no column of a campaign is of the kind {kind}")


def _items(values: Sequence[Sequence[Any]], kind: "pa.ListType") -> "pa.Array":
    """Return what sequences hold, one after the other."""
    import pyarrow as pa

    if kind.value_type == pa.float64() and values:
        data = np.concatenate([np.asarray(each, dtype=np.float64) for each in values])
        return _built(kind.value_type, len(data), None, data)
    return _array(list(chain.from_iterable(values)), kind.value_type)


def _pairs(values: Sequence[Mapping[str, Any]], kind: "pa.MapType") -> "pa.Array":
    """Return the keys of mappings with what they stand for, one after the other."""
    import pyarrow as pa

    keys = _array(list(chain.from_iterable(values)), kind.key_field.type)
    items = _array([item for each in values for item in each.values()], kind.item_field.type)
    pair = pa.struct([kind.key_field, kind.item_field])
    return pa.Array.from_buffers(pair, len(keys), [None], children=[keys, items])


def _built(
    kind: "pa.DataType", length: int, known: "pa.Buffer | None", *data: NDArray[np.generic] | bytes
) -> "pa.Array":
    import pyarrow as pa

    return pa.Array.from_buffers(kind, length, [known, *map(pa.py_buffer, data)])


def _ends(values: Iterable[Sequence[Any]]) -> NDArray[np.int32]:
    """Return where values that are laid one after the other begin, and where the last one ends."""
    return np.cumsum([0, *map(len, values)], dtype=np.int32)


def _bits(truth: Sequence[bool]) -> NDArray[np.uint8]:
    return np.packbits(np.array(truth, dtype=bool), bitorder="little")
