"""Reads a sweep's rows with the program named, and prints rows, types and units as JSON."""

import json
import math
import sys
from pathlib import Path

path, program = Path(sys.argv[1]), sys.argv[2]
files = sorted(path.glob("rows-*.parquet")) if path.is_dir() else [path]


def plain(value):
    """A value that JSON has."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return None
    return value.item() if hasattr(value, "item") else value


if program == "pandas":
    import pandas
    import pyarrow.parquet

    table = pandas.concat([pandas.read_parquet(file) for file in files])
    types = {name: str(kind) for name, kind in table.dtypes.items()}
    schema = pyarrow.parquet.read_schema(files[0])
    units = {f.name: f.metadata[b"unit"].decode() for f in schema if f.metadata and b"unit" in f.metadata}
    rows = table.to_dict("records")
elif program == "polars":
    import polars

    table = polars.concat([polars.read_parquet(file) for file in files])
    types = {name: str(kind) for name, kind in table.schema.items()}
    units = json.loads(polars.read_parquet_metadata(files[0])["trackwright.units"])
    rows = table.to_dicts()
else:
    import duckdb

    names = [str(file) for file in files]
    relation = duckdb.sql("select * from read_parquet(?) order by row", params=[names])
    types = {name: str(kind) for name, kind in zip(relation.columns, relation.types)}
    rows = [dict(zip(relation.columns, row)) for row in relation.fetchall()]
    entries = duckdb.sql("select key, value from parquet_kv_metadata(?)", params=[names[0]]).fetchall()
    units = json.loads(dict(entries)[b"trackwright.units"])

rows = [{name: plain(value) for name, value in row.items()} for row in rows]
print(json.dumps({"rows": rows, "types": types, "units": units}))
