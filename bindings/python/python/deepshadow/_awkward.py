"""Columns as Awkward Arrays, without a copy."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def image(shape: tuple[int, int], offsets: Any, fields: dict[str, Any]) -> Any:
    """Rows of pixels of lists of records; a field of more than one number is a regular list."""
    ak: Any = import_module("awkward")

    contents = [ak.contents.NumpyArray(column) for column in fields.values()]
    records = ak.contents.RecordArray(contents, list(fields))
    lists = ak.contents.ListOffsetArray(ak.index.IndexU32(offsets), records)
    return ak.Array(ak.contents.RegularArray(lists, shape[1], zeros_length=shape[0]))
