"""Encodes pairs as files, and shards as tar or Parquet files."""

from __future__ import annotations

import gzip
import io
import json
import tarfile
from typing import Any

import numpy as np

from stereotrace import StereoPair, encode_png

from .._needs import needs
from .spec import Spec
from .store import Written


# Outputs of motion, and the attributes of ``EyeFlow`` that hold them.
FLOW = {
    "flow": "flow",
    "flow_visibility": "visibility",
    "disparity_change": "disparity_change",
    "scene_flow": "displacement",
}


# Outputs of matches, and the attributes of ``EyeMatches`` that hold them.
MATCH = {"match": "place", "match_visibility": "visibility"}


def files(pair: StereoPair, spec: Spec, record: dict[str, Any]) -> dict[str, bytes]:
    """Returns a pair's files: bytes by the part of the name after the pair's key.

    Colours and uint8 maps are PNG. All other arrays are NPY, or NPY with gzip. JSON has the camera and the record."""
    found = {}
    for view, output in spec.checked.arrays:
        array = _of_array(pair, spec, view, output) if pair.array else _array(pair, view, output)
        if output == "color":
            found[f"{view}.png"] = encode_png(array)
        elif array.dtype == np.uint8 and array.ndim == 2:
            found[f"{view}.{output}.png"] = encode_png(array)
        elif spec["compress"]:
            # The fastest level saves nearly as much as the others.
            found[f"{view}.{output}.npy.gz"] = gzip.compress(_npy(array), compresslevel=1, mtime=0)
        else:
            found[f"{view}.{output}.npy"] = _npy(array)
    cameras: dict[str, Any] = {"camera": json.loads(pair.camera.to_json())}
    if pair.array:
        each = sorted(pair.array.items())
        cameras["pairs"] = {f"{one:02}-{other:02}": json.loads(two.camera.to_json()) for (one, other), two in each}
    if pair.motion is not None:
        cameras["next_camera"] = json.loads(pair.motion[0].camera.to_json())
    found["json"] = json.dumps({**record, **cameras}, sort_keys=True).encode()
    return found


def _array(pair: StereoPair, view: str, output: str) -> Any:
    """Returns the array of a view: ``left``, ``right``, ``next.left`` or ``next.right``."""
    of_next, eye = view.startswith("next."), view.removeprefix("next.")
    if pair.motion is None:
        return _of_eye(pair, eye, output)
    following, forward, backward = pair.motion
    if output in FLOW:
        return getattr(getattr(backward if of_next else forward, eye), FLOW[output])
    return _of_eye(following if of_next else pair, eye, output)


def _of_array(pair: StereoPair, spec: Spec, view: str, output: str) -> Any:
    """Returns the array of a view: ``camera00``, or ``pair00-01.left``. Arrays of pairs of an upper and a lower camera
    are turned to be as the cameras' pictures."""
    columns = spec["rig"]["array"]["columns"]
    columns = len(columns) if isinstance(columns, list) else columns
    name, _, eye = view.partition(".")
    if eye:
        one, other = (int(number) for number in name.removeprefix("pair").split("-"))
    else:
        camera = int(name.removeprefix("camera"))
        # A pair in a row is not turned.
        pairs = [two for two in pair.array if camera in two]
        one, other = min(pairs, key=lambda two: (two[0] // columns != two[1] // columns, two))
        eye = "left" if camera == one else "right"
    found = _of_eye(pair.array[one, other], eye, output)
    is_turned = one // columns != other // columns
    axis = 1 if output.startswith("layer_") and output != "layer_count" else 0
    return np.ascontiguousarray(np.rot90(found, -1, (axis, axis + 1))) if is_turned else found


def _of_eye(pair: StereoPair, eye: str, output: str) -> Any:
    if output in MATCH:
        return getattr(getattr(pair.matches, eye), MATCH[output])
    if output.startswith("layer_"):
        return getattr(getattr(pair.layers, eye), output.removeprefix("layer_"))
    return getattr(getattr(pair, eye), output)


def _npy(array: Any) -> bytes:
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return file.getvalue()


class Tar:
    """A shard as a tar file for ``webdataset``, where files with the same name up to the first dot are one sample.

    The same pairs make the same bytes."""

    def __init__(self, file: Written) -> None:
        self._tar = tarfile.open(fileobj=file, mode="w|", format=tarfile.USTAR_FORMAT)

    def add(self, key: str, item: int, files: dict[str, bytes]) -> None:
        for name, data in files.items():
            entry = tarfile.TarInfo(f"{key}.{name}")
            entry.size = len(data)
            entry.mode = 0o644
            self._tar.addfile(entry, io.BytesIO(data))

    def close(self) -> None:
        self._tar.close()


class Parquet:
    """A shard as a Parquet file: one row for each pair, one column of bytes for each file, named as in a tar file."""

    def __init__(self, file: Written) -> None:
        self._parquet = needs("pyarrow.parquet", "parquet")
        self._file = file
        self._writer: Any = None

    def add(self, key: str, item: int, files: dict[str, bytes]) -> None:
        self._write({"item": [item], "key": [key]}, {name: [data] for name, data in files.items()})

    def _write(self, named: dict[str, list[Any]], files: dict[str, list[bytes]]) -> None:
        import pyarrow

        columns = {
            "item": pyarrow.array(named["item"], pyarrow.int64()),
            "key": pyarrow.array(named["key"], pyarrow.string()),
        }
        columns |= {name: pyarrow.array(data, pyarrow.binary()) for name, data in files.items()}
        table = pyarrow.table(columns)
        if self._writer is None:
            # Compression would not shrink PNG data, and NPY data hardly.
            file = pyarrow.PythonFile(self._file, "w")
            self._writer = self._parquet.ParquetWriter(file, table.schema, compression="none")
        self._writer.write_table(table)

    def close(self) -> None:
        if self._writer is None:  # no pair could be made
            self._write({"item": [], "key": []}, {})
        self._writer.close()
