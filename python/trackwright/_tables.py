"""Tables of any kind as columns: what the library reads of a table that is in memory."""

from __future__ import annotations

import ctypes
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from trackwright._core import TrackwrightError

Columns = dict[str, npt.NDArray[Any]]

# Kinds of data in the DataFrame interchange protocol, and what NumPy calls each.
_INT, _UINT, _FLOAT, _BOOL, _STRING, _CATEGORICAL = 0, 1, 2, 20, 21, 23
_NUMPY_KIND = {_INT: "i", _UINT: "u", _FLOAT: "f"}
# How a column marks cells that are not there: not at all, and by what is not a number.
_NON_NULLABLE, _NAN = 0, 1
_CPU = 1


def columns(table: object) -> Columns:
    """The columns of a table by their names, each an array of one dimension.

    A table is a NumPy structured or record array, a mapping from names to columns, or anything with
    the DataFrame interchange protocol (``__dataframe__``: pandas, polars, pyarrow and others).
    Columns that are arrays already are not copied.
    """
    if isinstance(table, np.ndarray):
        return _of_records(table)
    if isinstance(table, Mapping):
        found = {str(name): _plain(str(name), column) for name, column in table.items()}
    elif hasattr(table, "__dataframe__"):
        # Some libraries announce that they will give the protocol up; others go on with it.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)
            frame = table.__dataframe__()
        found = {
            str(name): _of_column(str(name), frame.get_column_by_name(name))
            for name in frame.column_names()
        }
    else:
        raise TrackwrightError(
            f"table: found {type(table).__name__}, expected a file, a record array, "
            "a mapping of columns, or a data frame"
        )
    _check(found)
    return found


def _of_records(table: npt.NDArray[Any]) -> Columns:
    names = table.dtype.names
    if names is None:
        raise TrackwrightError(
            f"table: found an array of {table.dtype} without names of columns, "
            "expected a structured array"
        )
    found = {name: _plain(name, table[name]) for name in names}
    _check(found)
    return found


def _plain(name: str, column: Any) -> npt.NDArray[Any]:
    """A column as a plain array, which would have some number in the place of what is masked."""
    if np.ma.is_masked(column):
        raise TrackwrightError(f"table, column {name}: found masked cells, expected none")
    return np.asarray(column)


def _check(found: Columns) -> None:
    """Refuses what is no table: columns of several dimensions or of different lengths."""
    first: tuple[str, int] | None = None
    for name, column in found.items():
        if column.ndim != 1:
            raise TrackwrightError(
                f"table, column {name}: found the shape {column.shape}, expected one dimension"
            )
        if first is None:
            first = (name, len(column))
        elif len(column) != first[1]:
            raise TrackwrightError(
                f"table, column {name}: found {len(column)} rows, "
                f"expected {first[1]}, as in column {first[0]}"
            )


def _of_column(name: str, column: Any) -> npt.NDArray[Any]:
    """A column of the interchange protocol, its chunks one after the other."""
    chunks = [_of_chunk(name, chunk) for chunk in column.get_chunks()]
    return chunks[0] if len(chunks) == 1 else np.concatenate(chunks)


def _of_chunk(name: str, column: Any) -> npt.NDArray[Any]:
    kind = column.dtype[0]
    nullness = column.describe_null[0]
    if nullness not in (_NON_NULLABLE, _NAN) and (column.null_count or 0) > 0:
        raise TrackwrightError(f"table, column {name}: found empty cells, expected none")
    buffers = column.get_buffers()
    if kind in _NUMPY_KIND:
        return _of_buffer(buffers["data"], _NUMPY_KIND[kind], column.offset, column.size())
    if kind == _STRING:
        return _of_strings(buffers, column.offset, column.size())
    if kind == _CATEGORICAL:
        codes = _of_buffer(buffers["data"], "i", column.offset, column.size())
        names = _of_column(name, column.describe_categorical["categories"])
        chosen: npt.NDArray[Any] = names[codes]
        return chosen
    # A column that nothing reads is no reason to refuse its table.
    return np.full(column.size(), np.nan)


def _of_buffer(
    described: tuple[Any, tuple[int, int, str, str]], kind: str, offset: int, size: int
) -> npt.NDArray[Any]:
    """A part of a buffer, without a copy; the array keeps the buffer alive."""
    buffer, (_, bits, _, order) = described
    if buffer.__dlpack_device__()[0] != _CPU:
        raise TrackwrightError("table: found a column in a device's memory, expected one in the machine's")
    dtype = np.dtype(f"{order if order in '<>' else '='}{kind}{bits // 8}")
    if size == 0:
        return np.empty(0, dtype)
    memory = (ctypes.c_char * buffer.bufsize).from_address(buffer.ptr)
    # A view keeps `memory` alive, and that the buffer.
    memory.owner = buffer
    return np.frombuffer(memory, dtype, size, offset * dtype.itemsize)


def _of_strings(buffers: Any, offset: int, size: int) -> npt.NDArray[Any]:
    """Text, which is kept as bytes and the places where each begins."""
    data, _ = buffers["data"]
    begins = _of_buffer(buffers["offsets"], "i", offset, size + 1)
    text = bytes(_of_buffer((data, (_UINT, 8, "C", "=")), "u", 0, data.bufsize))
    pairs = zip(begins[:-1].tolist(), begins[1:].tolist())
    return np.array([text[begin:end].decode() for begin, end in pairs], dtype=object)
