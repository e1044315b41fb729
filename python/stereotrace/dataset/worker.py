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

import stereotrace
from stereotrace import AdapterError, DeviceLostError, LimitError, Material, Renderer, Scene, StereoPair

from . import encode
from .items import Item
from .spec import ONE_ROOT, Spec
from .store import Store

log = logging.getLogger("stereotrace.dataset")

# Outputs that the files of a layout need.
LAYOUT_OUTPUTS = ["color", "disparity", "occlusion"]


SCENE_MEMORY = 2**30
"""Default memory in bytes for the scenes that a worker keeps. The current scene is always kept."""
COPIES = 3
"""Memory of a scene on the host and on a software device together, as a multiple of ``Scene.memory``. 1.8 and 2.9 were
measured on a million triangles."""
WAITING_MEMORY = 2**28
"""Size in bytes from which files that wait for their place in a shard go to disk."""
MOST_FILES = 10_000
"""Maximum number of files in a scene's folder. With more, scenes are read again instead of comparing the files."""


def scene_files(spec: Spec, scene: int, leave_out: Path | None = None) -> str | None:
    """Returns a hash of names, sizes and times of a scene's files: those in its folder and below, and its sky.

    Returns ``None`` if a file can't be inspected or there are too many. ``leave_out`` is a folder to skip, such as the
    data set's own."""
    path, sky = spec.scene_path(scene), spec["scenes"][scene].get("sky")
    found: list[tuple[str, int, int]] = []
    try:
        for folder, inner, names in os.walk(path.parent) if path is not None else ():
            inner[:] = sorted(name for name in inner if Path(folder, name).resolve() != leave_out)
            found += [_stamp(Path(folder, name)) for name in sorted(names)]
            if len(found) > MOST_FILES:
                return None
        if isinstance(sky, str) and sky != "procedural":
            found.append(_stamp(spec.folder / sky))
        if path is not None:
            _stamp(path)
    except OSError:
        return None
    return hashlib.sha256(json.dumps(found).encode()).hexdigest()


def _stamp(path: Path) -> tuple[str, int, int]:
    known = path.stat()
    return str(path), known.st_size, known.st_mtime_ns


def open_scene(spec: Spec, scene: int) -> Scene:
    """Opens a scene of a spec, without drawn values."""
    entry, path = spec["scenes"][scene], spec.scene_path(scene)
    if path is None:
        found = Scene.builtin(entry["builtin"])
    else:
        found = Scene.open(
            path,
            crease_angle=entry.get("crease_angle"),
            missing_textures=entry.get("missing_textures", "error"),
            outside_files=entry.get("outside_files", "refuse"),
            origin=entry.get("origin"),
        )
    sky = entry.get("sky")
    if sky == "procedural":
        found.set_sky_map(sky)
    elif isinstance(sky, str):
        found.set_sky_map(spec.folder / sky)
    elif sky is not None:
        found.set_sky(sky)
    return found


def scene_hash(spec: Spec, scene: int, found: Scene) -> str:
    """Returns a hash of everything that pictures of a scene depend on: its content and its camera in the spec."""
    camera = Item.camera_of(spec, scene, found).to_json()
    return hashlib.sha256(f"{found.sha256()} {camera}".encode()).hexdigest()


class SceneChanged(ValueError):
    """A scene file has changed since the data set was begun."""


class Stage:
    """A scene that pairs are rendered from, one after the other."""

    def __init__(self, spec: Spec, scene: int, sha256: str | None, opened: Scene | None) -> None:
        self.scene = open_scene(spec, scene) if opened is None else opened
        if opened is None and sha256 is not None and scene_hash(spec, scene, self.scene) != sha256:
            raise SceneChanged(f"{spec.scene_path(scene)}: it has changed since the data set was begun")
        self._materials: list[Material] = self.scene.materials
        self._shown = list(self._materials)
        self._lights = self.scene.lights
        self._ambient = self.scene.given_ambient

    def dress(self, item: Item, camera: stereotrace.Camera) -> None:
        """Sets the item's lights, ambient light and materials, whatever the previous item set."""
        self.scene.lights = item.lights(self.scene, self._lights, camera)
        ambient = item.ambient()
        self.scene.ambient = self._ambient if ambient is None else ambient
        for place, own in enumerate(self._materials):
            drawn = item.material(place, own)
            if drawn != self._shown[place]:
                self.scene.set_material(place, drawn)
                self._shown[place] = drawn


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
    recently used scenes stay in memory and on the device, up to ``scene_memory`` bytes. ``opened`` are scenes that were
    already read with these hashes, which the worker uses."""

    def __init__(
        self,
        spec: Spec,
        hashes: list[str | None] | None = None,
        adapter: str | None = None,
        scene_memory: int = SCENE_MEMORY,
        opened: dict[int, Scene] | None = None,
    ) -> None:
        self.spec = spec
        self._opened = {} if opened is None else opened
        self._hashes = hashes or [None] * len(spec["scenes"])
        self._adapter = adapter
        self._scene_memory = scene_memory
        self._stages: dict[int, Stage] = {}
        self._faults: dict[int, Exception] = {}
        self.renderer = self._new_renderer()

    def _new_renderer(self) -> Renderer:
        # The renderer keeps every scene; only `_stages` drops some.
        return Renderer(self._adapter, kept_scenes=len(self.spec["scenes"]) + 1)

    def _stage(self, scene: int) -> Stage:
        if scene in self._faults:
            raise self._faults[scene].with_traceback(None)
        stage = self._stages.pop(scene, None)
        if stage is None:
            try:
                stage = Stage(self.spec, scene, self._hashes[scene], self._opened.pop(scene, None))
            except (ValueError, OSError) as error:
                self._faults[scene] = error  # avoids reading it again for every pair
                raise
        self._stages[scene] = stage
        while (
            len(self._stages) > 1
            and COPIES * sum(one.scene.memory for one in self._stages.values()) > self._scene_memory
        ):
            self.renderer.release(self._stages.pop(next(iter(self._stages))).scene)
        return stage

    def pair(self, number: int) -> tuple[StereoPair, dict[str, Any]]:
        """Renders a pair. Returns it with its record: camera, method, disparity range. Raises as rendering does."""
        item = Item(self.spec, number)
        place = item.scene()
        stage = self._stage(place)
        camera, tries = item.camera(self.renderer, stage.scene)
        stage.dress(item, camera)
        options = {**self.spec["render"], "exposure": item.exposure()}
        options.setdefault("seed", (self.spec["seed"] + number) % 2**32)
        pair = self.renderer.render(stage.scene, camera, outputs=self.outputs(), **options)
        return pair, self._record(number, place, pair, tries)

    def outputs(self) -> list[str]:
        """Returns the outputs to render: the spec's arrays without eyes, and those that the record needs."""
        if self.spec.is_layout:
            return LAYOUT_OUTPUTS
        names = [name.rpartition(".")[2] for name in self.spec["outputs"]]
        return sorted({*names, "color", "disparity"}, key=stereotrace.OUTPUTS.index)

    def _record(self, number: int, scene: int, pair: StereoPair, tries: int) -> dict[str, Any]:
        camera, statistics = pair.camera, pair.statistics
        record: dict[str, Any] = {
            "item": number,
            "scene": self.spec.scene_name(scene),
            "eye": camera.eye,
            "forward": camera.forward,
            "up": camera.up,
            "interaxial": camera.interaxial,
            "tries": tries,
            "method": statistics["method"],
            "retraced_share": statistics["retraced_share"],
        }
        arrays = pair.left.arrays()
        disparity = arrays["disparity"]
        record["disparity"] = [float(disparity.min()), float(disparity.max())]
        if "occlusion" in arrays:
            hidden = arrays["occlusion"]
            record["hidden_percent"] = 100.0 * float((hidden == 1).mean())
            record["out_of_frame_percent"] = 100.0 * float((hidden == 2).mean())
        return record

    def _pair_once_more(self, number: int) -> tuple[StereoPair, dict[str, Any]]:
        """Renders a pair. If the device is lost, tries once more on a new one."""
        try:
            return self.pair(number)
        except DeviceLostError as error:
            log.warning("item %d: %s; retrying on a new device", number, error)
            self.renderer = self._new_renderer()
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
        scenes = {item: Item(self.spec, item).scene() for item in items}
        first: dict[int, int] = {}
        for item, scene in scenes.items():
            first.setdefault(scene, item)
        return sorted(scenes, key=lambda item: (scenes[item] not in self._stages, first[scenes[item]], item))

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
            if self.spec["format"] in ONE_ROOT:
                return {"file": self.spec.data_name(number), "bytes": store.put_into_root(Path(folder), name)}
            size = store.put_folder(Path(folder), name)
        return {"file": self.spec.data_name(number), "bytes": size}
