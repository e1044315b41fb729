"""The spec of a data set: its source in Python, and names of its shards and files. Rust code checks its keys."""

from __future__ import annotations

import hashlib
import json
import math
import numbers
import operator
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import stereotrace

from .._stereotrace import DataSetSpec
from .file import MOST_LEVELS, SpecError, read, shown

ENDINGS = {"webdataset": ".tar", "parquet": ".parquet"}
"""File endings of shards, by format."""
ONE_ROOT = {"kitti": "training", "sintel": "training"}
"""Layouts that put the pairs of all shards into one folder, and its name."""
MOST_VALUES = 1_000_000
"""Maximum number of values of a spec. Each use of an alias counts."""


@dataclass(frozen=True)
class Spec:
    """The checked spec of a data set.

    ``values`` are its keys and values in plain JSON types, with defaults filled in. Paths of scene files are relative
    to ``folder``, which is not part of the data set's identity."""

    values: dict[str, Any]
    folder: Path = field(compare=False)

    @staticmethod
    def load(source: str | Path | Mapping[str, Any]) -> Spec:
        """Reads a spec from a YAML or JSON file, or takes a dict.

        Raises ``SpecError``, which names the key, for an invalid spec, and ``OSError`` if the file can't be read."""
        if isinstance(source, Mapping):
            return _checked(source, Path.cwd())
        path = Path(source)
        try:
            values = read(path)
            if not isinstance(values, Mapping):
                raise SpecError("it must be a mapping of keys to values")
            return _checked(values, path.resolve().parent)
        except SpecError as error:
            raise SpecError(f"{path}: {error}") from None

    def __getitem__(self, key: str) -> Any:
        return self.values[key]

    def __reduce__(self) -> tuple[Any, ...]:
        return Spec, (self.values, self.folder)

    @cached_property
    def checked(self) -> DataSetSpec:
        """The spec as Rust code uses it."""
        return DataSetSpec(json.dumps(self.values), self.folder)

    @property
    def shards(self) -> int:
        """Number of shards."""
        return -(-int(self["pairs"]) // int(self["shard_pairs"]))

    def shard_name(self, shard: int) -> str:
        """Returns the name of a shard, without its ending."""
        return f"{self['name']}-{shard:06d}"

    def data_name(self, shard: int) -> str:
        """Returns the name of a shard's file or folder, or of the folder that all shards share."""
        if self["format"] in ONE_ROOT:
            return ONE_ROOT[self["format"]]
        return self.shard_name(shard) + ENDINGS.get(self["format"], "")

    def shard_items(self, shard: int) -> range:
        """Returns the numbers of a shard's pairs."""
        begin = shard * int(self["shard_pairs"])
        return range(begin, min(begin + int(self["shard_pairs"]), int(self["pairs"])))

    def scene_name(self, scene: int) -> str:
        """Returns a scene's name in records."""
        entry = self["scenes"][scene]
        if "generate" in entry:
            return f"generate:{entry['generate']['kind']}"
        return str(entry.get("file") or f"builtin:{entry['builtin']}")

    def scene_path(self, scene: int) -> Path | None:
        """Returns a scene's file, or ``None`` for a built-in or generated scene."""
        file = self["scenes"][scene].get("file")
        return None if file is None else self.folder / file

    def scene_folders(self, scene: int) -> list[Path]:
        """Returns the folders whose files a scene depends on: a file's own folder, or those of a generated scene."""
        path = self.scene_path(scene)
        if path is not None:
            return [path.parent]
        options = self["scenes"][scene].get("generate", {})
        return [self.folder / options[key] for key in ("textures", "skies", "meshes") if key in options]

    @property
    def is_layout(self) -> bool:
        """Whether a shard is a folder of files rather than one file."""
        return self["format"] in stereotrace.LAYOUTS

    def sha256(self) -> str:
        """Returns a hash of all values of the spec."""
        return hashlib.sha256(canonical(self.values).encode()).hexdigest()


def canonical(value: Any) -> str:
    """Returns canonical JSON."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def _checked(source: Mapping[str, Any], folder: Path) -> Spec:
    _check_extent(source)
    try:
        checked = DataSetSpec(json.dumps(_plain(source)), folder)
    except ValueError as error:
        raise SpecError(str(error)) from None
    return Spec(json.loads(checked.to_json()), folder)


def _check_extent(value: Any) -> None:
    """Refuses specs with too deep nesting or too many values, before anything else walks through them."""
    waiting, count = [(value, 1)], 0
    while waiting:
        part, level = waiting.pop()
        count += 1
        if count > MOST_VALUES:
            raise SpecError(f"it has over {MOST_VALUES} values")
        if not _has_parts(part):
            continue
        if level > MOST_LEVELS:
            raise SpecError(f"its lists and mappings are nested more than {MOST_LEVELS} levels deep")
        if len(part) > MOST_VALUES - count - len(waiting):
            raise SpecError(f"it has over {MOST_VALUES} values")
        waiting += [(inner, level + 1) for inner in (part.values() if isinstance(part, Mapping) else part)]


def _has_parts(value: Any) -> bool:
    return isinstance(value, (Mapping, Sequence)) and not isinstance(value, (str, bytes))


def _plain(value: Any, at: str = "") -> Any:
    """Converts a value to JSON types, or raises ``SpecError``. Infinity becomes text, as specs have it."""
    if isinstance(value, Mapping):
        dot = f"{at}." if at else ""
        return {str(key): _plain(inner, f"{dot}{key}") for key, inner in value.items()}
    if _has_parts(value):
        return [_plain(inner, f"{at}[{index}]") for index, inner in enumerate(value)]
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, numbers.Integral) and abs(whole := operator.index(value)) < 2**63:  # NumPy's too
        return whole
    if isinstance(value, numbers.Real) and not isinstance(value, numbers.Integral) and not math.isnan(value):
        number = float(value)
        return number if math.isfinite(number) else str(number)
    kind = "a number that f64 can hold" if isinstance(value, numbers.Number) else "text, a number, a list or a mapping"
    raise SpecError(f"{at}: {shown(value)} must be {kind}")
