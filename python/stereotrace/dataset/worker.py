"""Makes pairs and shards, with a renderer and scenes that are kept from shard to shard."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import pickle
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Callable, Iterator

from stereotrace import AdapterError, DeviceLostError, LimitError, Renderer, StereoPair

from .._stereotrace import PairMaker
from . import encode
from .spec import ONE_ROOT, Spec
from .store import Store

log = logging.getLogger("stereotrace.dataset")

SCENE_MEMORY = 2**30
"""Default memory in bytes for the scenes that a worker keeps. The current scene is always kept."""
WAITING_MEMORY = 2**28
"""Size in bytes from which files that wait for their place in a shard go to disk."""
MOST_FILES = 10_000
"""Maximum number of files in a scene's folder. With more, scenes are read again instead of comparing the files."""


def scene_files(spec: Spec, scene: int, leave_out: Path | None = None) -> str | None:
    """Returns a hash of names, sizes and times of a scene's files: those in its folders and below, its sky, and the
    picture of the rig's projector.

    Returns ``None`` if a file can't be inspected or there are too many. ``leave_out`` is a folder to skip, such as the
    data set's own."""
    path, sky = spec.scene_path(scene), spec["scenes"][scene].get("sky")
    found: list[tuple[str, int, int]] = []
    try:
        for root in spec.scene_folders(scene):
            for folder, inner, names in os.walk(root):
                inner[:] = sorted(name for name in inner if Path(folder, name).resolve() != leave_out)
                found += [_stamp(Path(folder, name)) for name in sorted(names)]
                if len(found) > MOST_FILES:
                    return None
        if isinstance(sky, str) and sky != "procedural":
            found.append(_stamp(spec.folder / sky))
        if "picture" in (projector := spec["rig"].get("projector", {})):
            found.append(_stamp(spec.folder / projector["picture"]))
        if path is not None:
            _stamp(path)
    except OSError:
        return None
    return hashlib.sha256(json.dumps(found).encode()).hexdigest()


def _stamp(path: Path) -> tuple[str, int, int]:
    known = path.stat()
    return str(path), known.st_size, known.st_mtime_ns


class Waiting:
    """Files of pairs that wait for their place in a shard."""

    def __init__(self) -> None:
        self._file = tempfile.SpooledTemporaryFile(max_size=WAITING_MEMORY, prefix="stereotrace-")
        self._places: dict[int, int] = {}

    def __enter__(self) -> Waiting:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __contains__(self, item: int) -> bool:
        return item in self._places

    def put(self, item: int, files: dict[str, bytes]) -> None:
        self._places[item] = self._file.seek(0, os.SEEK_END)
        pickle.dump(files, self._file, protocol=pickle.HIGHEST_PROTOCOL)

    def take(self, item: int) -> dict[str, bytes]:
        self._file.seek(self._places.pop(item))
        files: dict[str, bytes] = pickle.load(self._file)  # trusted: this process wrote it
        return files


class Worker:
    """Makes pairs and shards of a spec.

    ``hashes`` are those of the scenes when the data set was begun, ``None`` for one that could not be read. The most
    recently used scenes stay in memory and on the device, up to ``scene_memory`` bytes. ``maker`` may have read some
    scenes already."""

    def __init__(
        self,
        spec: Spec,
        hashes: list[str | None] | None = None,
        adapter: str | None = None,
        scene_memory: int = SCENE_MEMORY,
        maker: PairMaker | None = None,
    ) -> None:
        self.spec = spec
        self.maker = PairMaker(spec.checked, scene_memory) if maker is None else maker
        self.maker.expect_hashes(hashes or [])
        self._adapter = adapter
        self.renderer = Renderer(adapter)

    def pair(self, number: int) -> tuple[StereoPair, dict[str, Any]]:
        """Renders a pair. Returns it with its record: camera, method, disparity range. Raises as rendering does."""
        pair, record = self.maker.pair(self.renderer, number)
        return pair, json.loads(record)

    def _pair_once_more(self, number: int) -> tuple[StereoPair, dict[str, Any]]:
        """Renders a pair. If the device is lost, tries once more on a new one."""
        try:
            return self.pair(number)
        except DeviceLostError as error:
            log.warning("item %d: %s; retrying on a new device", number, error)
            self.renderer = Renderer(self._adapter)
            return self.pair(number)

    def shard(self, number: int, store: Store, done: Callable[[int], None] = lambda item: None) -> dict[str, Any]:
        """Makes and writes a shard, and then its record, which marks the shard as complete.

        Errors of pairs go to the record, and the other pairs are made. Errors of the store are raised. ``done`` is
        called with the number of each pair."""
        began = time.monotonic()
        name = self.spec.shard_name(number)
        # No record may mark the shard as complete while its data is replaced.
        store.remove(f"{name}.json")
        record: dict[str, Any] = {
            "shard": name,
            "items": [self.spec.shard_items(number).start, self.spec.shard_items(number).stop],
            "adapter": self.renderer.adapter,
            "driver": self.renderer.driver,
            "pairs": [],
            "errors": [],
        }
        make = self._layout_shard if self.spec.is_layout else self._file_shard
        record |= make(number, store, record, done)
        for lines in (record["pairs"], record["errors"]):
            lines.sort(key=lambda line: line["item"])
        record["seconds"] = round(time.monotonic() - began, 3)
        store.write(f"{name}.json", (json.dumps(record, sort_keys=True) + "\n").encode())
        return record

    def _by_scene(self, items: Iterable[int]) -> list[int]:
        """Returns the items sorted by scene, so that no scene is read twice. Kept scenes come first."""
        scenes = {item: self.maker.scene_of(item) for item in items}
        first: dict[int, int] = {}
        for item, scene in scenes.items():
            first.setdefault(scene, item)
        return sorted(scenes, key=lambda item: (not self.maker.has_scene(scenes[item]), first[scenes[item]], item))

    def _each(
        self,
        number: int,
        record: dict[str, Any],
        done: Callable[[int], None],
        use: Callable[[int, StereoPair, dict[str, Any]], Any],
    ) -> Iterator[tuple[int, Any]]:
        """Makes each pair of a shard, scene by scene, and yields the result of ``use``.

        Errors of making or using a pair go to the shard's record, and yield ``None``."""
        for item in self._by_scene(self.spec.shard_items(number)):
            try:
                pair, of_pair = self._pair_once_more(item)
            except Exception as error:
                # Without a device the other pairs can't be made either.
                if isinstance(error, AdapterError) and not isinstance(error, LimitError):
                    raise
                self._note(record, item, error)
                yield item, None
                done(item)
                continue
            try:
                used = use(item, pair, of_pair)
            except OSError:  # an error of the disk, not of the pair
                raise
            except Exception as error:
                self._note(record, item, error)
                yield item, None
            else:
                yield item, used
                record["pairs"].append(of_pair)
            done(item)

    @staticmethod
    def _note(record: dict[str, Any], item: int, error: Exception) -> None:
        """Adds a pair's error to its shard's record."""
        text = str(error) or type(error).__name__
        log.warning("item %d: %s", item, text)
        record["errors"].append({"item": item, "error": text, "kind": type(error).__name__})

    def _file_shard(
        self, number: int, store: Store, record: dict[str, Any], done: Callable[[int], None]
    ) -> dict[str, Any]:
        def use(item: int, pair: StereoPair, of_pair: dict[str, Any]) -> dict[str, bytes]:
            return encode.files(pair, self.spec, of_pair)

        file = self.spec.data_name(number)
        with store.writing(file) as written, Waiting() as waiting:
            shard = (encode.Tar if self.spec["format"] == "webdataset" else encode.Parquet)(written)
            order, missing = list(self.spec.shard_items(number)), set()
            for item, files in self._each(number, record, done, use):
                if files is None:
                    missing.add(item)
                elif item == order[0]:
                    shard.add(f"{order.pop(0):08d}", item, files)
                else:
                    waiting.put(item, files)
                while order and (order[0] in missing or order[0] in waiting):
                    next_item = order.pop(0)
                    if next_item in waiting:
                        shard.add(f"{next_item:08d}", next_item, waiting.take(next_item))
            shard.close()
        return {"file": file, "bytes": written.bytes, "sha256": written.sha256()}

    def _layout_shard(
        self, number: int, store: Store, record: dict[str, Any], done: Callable[[int], None]
    ) -> dict[str, Any]:
        name = self.spec.shard_name(number)
        with tempfile.TemporaryDirectory(prefix="stereotrace-") as folder:

            def use(item: int, pair: StereoPair, of_pair: dict[str, Any]) -> None:
                pair.write(folder, self.spec["format"], item)

            for _ in self._each(number, record, done, use):
                pass
            hashes = _hashes(Path(folder))
            if self.spec["format"] in ONE_ROOT:
                size = store.put_into_root(Path(folder), name)
            else:
                size = store.put_folder(Path(folder), name)
        return {"file": self.spec.data_name(number), "bytes": size, "files": hashes}


def _hashes(folder: Path) -> dict[str, str]:
    """Returns the SHA-256 of all files of a folder, by their relative paths."""
    files = sorted(file for file in folder.rglob("*") if file.is_file())
    return {file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
