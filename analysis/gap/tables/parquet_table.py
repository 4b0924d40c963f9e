"""Apache Parquet, by pyarrow."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .base import BLOCK, Array, Signals, broken, no_column, optional

SUFFIXES = (".parquet", ".pq")
FORMAT = "Parquet"
WANTED = "a Parquet table"


def read(path: Path) -> list[Signals]:
    """Numeric and time columns of the table; the others are named in the remarks."""
    file = _open(path)
    wanted = [f.name for f in file.schema_arrow if _usable(f.type, path)]
    dropped = [f.name for f in file.schema_arrow if f.name not in wanted]
    if not wanted:
        raise broken(path, "columns of numbers", "no numeric column")
    columns = np.concatenate([np.empty((0, len(wanted))), *blocks(path, wanted)])
    remarks = (f"left out, not numbers: {', '.join(dropped)}",) if dropped else ()
    return [
        Signals(
            name="",
            columns={n: np.ascontiguousarray(columns[:, i]) for i, n in enumerate(wanted)},
            remarks=remarks,
        )
    ]


def blocks(path: Path, names: Sequence[str]) -> Iterator[Array]:
    """Blocks of the columns ``names``, in that order, row group by row group."""
    file = _open(path)
    known = list(file.schema_arrow.names)
    missing = [name for name in names if name not in known]
    if missing:
        raise no_column(path, missing[0], names, known)
    arrow = optional("pyarrow", "parquet", path)
    try:
        # One row group at a time: a reader of them all keeps what it has read.
        for group in range(file.num_row_groups):
            for batch in file.iter_batches(BLOCK, row_groups=[group], columns=list(names)):
                columns = [batch.column(batch.schema.get_field_index(name)) for name in names]
                yield np.column_stack([_floats(arrow, column) for column in columns])
    except (arrow.ArrowException, OSError, ValueError, TypeError) as error:
        raise broken(path, "columns of numbers", error) from None


def _open(path: Path) -> Any:
    arrow = optional("pyarrow", "parquet", path)
    parquet = optional("pyarrow.parquet", "parquet", path)
    try:
        return parquet.ParquetFile(path)
    except (arrow.ArrowException, OSError, ValueError) as error:
        raise broken(path, WANTED, error) from None


def _usable(kind: Any, path: Path) -> bool:
    types = optional("pyarrow.types", "parquet", path)
    return bool(
        types.is_integer(kind)
        or types.is_floating(kind)
        or types.is_boolean(kind)
        or types.is_timestamp(kind)
        or types.is_decimal(kind)
    )


def _floats(arrow: Any, column: Any) -> Array:
    """A column as float64; time stamps become seconds, missing values NaN."""
    if arrow.types.is_timestamp(column.type):
        per_second = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}[column.type.unit]
        ticks = column.cast(arrow.int64()).to_numpy(zero_copy_only=False)
        return np.asarray(ticks, dtype=np.float64) / per_second
    if arrow.types.is_boolean(column.type):
        column = column.cast(arrow.uint8())
    return np.asarray(column.cast(arrow.float64()).to_numpy(zero_copy_only=False))
