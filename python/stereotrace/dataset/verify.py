"""``python -m stereotrace.dataset.verify FOLDER``: reads a data set back and says what is broken."""

from __future__ import annotations

import argparse
import gzip
import hashlib
import io
import json
import sys
import tarfile
from collections.abc import Iterator
from typing import Any

import numpy as np

from stereotrace import decode_png

from .._needs import needs
from .run import HEAD, DataSet
from .spec import Spec
from .store import Store


def verify(url: str, storage_options: dict[str, Any] | None = None) -> Iterator[str]:
    """Reads a whole data set, and yields a line for each fault: the shard, the file or the pair, and what is wrong.

    Shards must have the bytes and the SHA-256 of their records. Each pair must have all files of its spec, and each
    file must be readable, with the spec's size. Disparities, depths and colours must be numbers. Shards that have not
    been made yet are faults too. Raises ``ValueError`` if the folder has no data set, and ``OSError`` if it can't be
    read."""
    store = Store(url, storage_options)
    spec = spec_of(store)
    for shard in range(spec.shards):
        name = spec.shard_name(shard)
        try:
            record = json.loads(store.read(f"{name}.json"))
            yield from (f"{name}: {fault}" for fault in _shard(spec, store, shard, record))
        except FileNotFoundError:
            yield f"{name}: it has not been made"
        except (ValueError, KeyError, TypeError) as error:
            yield f"{name}.json: it is no record: {error}"


def spec_of(store: Store) -> Spec:
    """Returns the spec of the data set in a store. Raises ``ValueError`` if there is none."""
    if not store.exists(HEAD):
        raise ValueError(f"{store.place(HEAD)}: no such file, so this is no data set")
    try:
        return Spec.load(json.loads(store.read(HEAD))["spec"])
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{store.place(HEAD)}: it does not belong to a data set: {error}") from error


def pairs(spec: Spec, data: bytes) -> Iterator[tuple[str, dict[str, bytes]]]:
    """Yields the key of each pair of a shard, and its files by the part of their names after the key.

    Raises ``ValueError`` for a broken shard."""
    if spec["format"] == "parquet":
        try:
            rows = needs("pyarrow.parquet", "parquet").read_table(io.BytesIO(data)).to_pylist()
        except Exception as error:  # pyarrow's errors have no common class
            raise ValueError(str(error)) from error
        for row in rows:
            item, key = row.pop("item"), row.pop("key")
            if f"{item:08d}" != key:
                raise ValueError(f"item {item} has the key {key}")
            yield key, row
        return
    found: dict[str, dict[str, bytes]] = {}
    try:
        with tarfile.open(fileobj=io.BytesIO(data)) as tar:
            for entry in tar:
                key, _, name = entry.name.partition(".")
                file = tar.extractfile(entry)
                found.setdefault(key, {})[name] = b"" if file is None else file.read()
    except (tarfile.TarError, EOFError) as error:
        raise ValueError(str(error)) from error
    yield from found.items()


def _shard(spec: Spec, store: Store, shard: int, record: dict[str, Any]) -> Iterator[str]:
    for error in record["errors"]:
        yield f"item {error['item']} could not be made: {error['error']}"
    if spec.is_layout:
        yield from _folder(spec, store, shard, record)
        return
    try:
        data = store.read(record["file"])
    except FileNotFoundError:
        yield f"{record['file']}: no such file"
        return
    if len(data) != record["bytes"]:
        yield f"{record['file']}: it has {len(data)} bytes, not {record['bytes']}"
    elif hashlib.sha256(data).hexdigest() != record["sha256"]:
        yield f"{record['file']}: its SHA-256 is not that of its record"
    wanted = {f"{pair['item']:08d}" for pair in record["pairs"]}
    try:
        for key, files in pairs(spec, data):
            if key not in wanted:
                yield f"pair {key}: it is not in the record"
            wanted.discard(key)
            yield from (f"pair {key}: {fault}" for fault in _pair(spec, files))
    except ValueError as error:
        yield f"{record['file']}: it can't be read: {error}"
    for key in sorted(wanted):
        yield f"pair {key}: it is missing"


def _folder(spec: Spec, store: Store, shard: int, record: dict[str, Any]) -> Iterator[str]:
    """Checks the files of a layout's shard against its record."""
    folder = "" if spec.data_name(shard) != spec.shard_name(shard) else f"{spec.shard_name(shard)}/"
    for name, expected in record["files"].items():
        try:
            data = store.read(folder + name)
        except FileNotFoundError:
            yield f"{folder}{name}: no such file"
            continue
        if hashlib.sha256(data).hexdigest() != expected:
            yield f"{folder}{name}: its SHA-256 is not that of its record"


def _pair(spec: Spec, files: dict[str, bytes]) -> Iterator[str]:
    expected = {"json": "json"}
    for view, output in spec.checked.arrays:
        name = view if output == "color" else f"{view}.{output}"
        found = [name + ending for ending in (".png", ".npy", ".npy.gz") if name + ending in files]
        if not found:
            yield f"{name}: no such array"
        expected |= dict.fromkeys(found, output)
    for name in sorted(files.keys() - expected.keys()):
        yield f"{name}: it is not in the spec"
    for name, output in expected.items():
        if name not in files:
            yield f"{name}: no such file"
            continue
        try:
            fault = _array(spec, read(name, files[name]), output)
        except (ValueError, EOFError, OSError) as error:
            fault = f"it can't be read: {error}"
        if fault:
            yield f"{name}: {fault}"


def read(name: str, data: bytes) -> Any:
    """Reads a file of a pair: an array, or the values of a JSON file. Raises ``ValueError`` for a broken one."""
    if name == "json":
        return json.loads(data)
    if name.endswith(".png"):
        return decode_png(data)
    return np.load(io.BytesIO(gzip.decompress(data) if name.endswith(".gz") else data), allow_pickle=False)


def _array(spec: Spec, array: Any, output: str) -> str | None:
    """Returns what is wrong with an array."""
    if output == "json":
        return None if isinstance(array, dict) and "camera" in array else "it has no camera"
    sizes = spec["size"]["choice"] if isinstance(spec["size"], dict) else [spec["size"]]
    start = 1 if output.startswith("layer_") and output != "layer_count" else 0
    if list(array.shape[start : start + 2]) not in [[height, width] for width, height in sizes]:
        names = " or ".join(f"{width}x{height}" for width, height in sizes)
        return f"its shape is {array.shape}, but pictures have {names} pixels"
    # Flow behind the eye, layers that are not known, and directions that a lens does not show are NaN.
    may_be_nan = output in ("flow", "disparity_change", "layer_disparity", "layer_vertical_disparity", "match")
    if array.dtype.kind == "f" and not may_be_nan and (wrong := np.isnan(array).sum()):
        return f"{wrong} values are NaN"
    if output == "color" and array.max() == 0:
        return "it is black"
    return None


def main(arguments: list[str] | None = None) -> int:
    """Returns the exit status: 0 for a whole data set, 1 if a part is missing or broken."""
    parser = argparse.ArgumentParser(
        prog="python -m stereotrace.dataset.verify",
        description="Reads a data set back: shards, checksums, and every array of every pair. Prints what is broken.",
    )
    parser.add_argument("folder", help="folder of the data set, or its URL")
    given = parser.parse_args(arguments)
    faults = 0
    try:
        for fault in verify(given.folder):
            print(fault)
            faults += 1
    except (ImportError, ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(f"{given.folder}: {'no fault' if not faults else f'{faults} faults' if faults > 1 else '1 fault'}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
