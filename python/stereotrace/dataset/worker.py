"""What makes pairs and shards: a renderer and the scenes that were read, kept from shard to shard."""

from __future__ import annotations

import hashlib
import json
import logging
import tempfile
import time
from pathlib import Path
from typing import Any, Callable

import stereotrace
from stereotrace import AdapterError, DeviceLostError, LimitError, Material, Renderer, Scene, StereoPair

from . import encode
from .items import Item
from .spec import Spec
from .store import Store

log = logging.getLogger("stereotrace.dataset")

# What a pair's files in a layout take of ground truth.
LAYOUT_OUTPUTS = ["color", "disparity", "occlusion"]


def open_scene(spec: Spec, scene: int) -> Scene:
    """A scene of a spec as it is before anything is drawn."""
    entry, path = spec["scenes"][scene], spec.scene_path(scene)
    if path is None:
        found = Scene.builtin(entry["builtin"])
    else:
        textures = entry.get("missing_textures", "error")
        outside = entry.get("outside_files", "refuse")
        found = Scene.open(
            path, crease_angle=entry.get("crease_angle"), missing_textures=textures, outside_files=outside
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
    """Of all that pictures of a scene depend on: what it shows, and the camera that it has for the spec."""
    camera = Item.camera_of(spec, scene, found).to_json()
    return hashlib.sha256(f"{found.sha256()} {camera}".encode()).hexdigest()


class SceneChanged(ValueError):
    """A scene file is not what it was when the data set was begun."""


class Stage:
    """A scene that pairs are made of, one after the other."""

    def __init__(self, spec: Spec, scene: int, sha256: str | None) -> None:
        self.scene = open_scene(spec, scene)
        if sha256 is not None and scene_hash(spec, scene, self.scene) != sha256:
            raise SceneChanged(f"{spec.scene_path(scene)}: it shows something else than when the data set was begun")
        self._materials: list[Material] = self.scene.materials
        self._shown = list(self._materials)
        self._lights = self.scene.lights
        self._ambient = self.scene.given_ambient

    def dress(self, item: Item, camera: stereotrace.Camera) -> None:
        """Gives the scene the item's lights and materials, whatever it had before."""
        self.scene.lights = item.lights(self.scene, self._lights, camera)
        ambient = item.ambient()
        self.scene.ambient = self._ambient if ambient is None else ambient
        for place, own in enumerate(self._materials):
            drawn = item.material(place, own)
            if drawn != self._shown[place]:
                self.scene.set_material(place, drawn)
                self._shown[place] = drawn


class Worker:
    """Makes pairs and shards of a spec. ``hashes`` are those of its scenes when the data set was begun; a scene that can't be read has none."""

    def __init__(self, spec: Spec, hashes: list[str | None] | None = None, adapter: str | None = None, kept_scenes: int = 4) -> None:
        self.spec = spec
        self._hashes = hashes or [None] * len(spec["scenes"])
        self._adapter = adapter
        self._kept = kept_scenes
        self._stages: dict[int, Stage] = {}
        self._faults: dict[int, Exception] = {}
        self.renderer = Renderer(adapter, kept_scenes=kept_scenes)

    def _stage(self, scene: int) -> Stage:
        if scene in self._faults:
            raise self._faults[scene].with_traceback(None)
        stage = self._stages.pop(scene, None)
        if stage is None:
            if len(self._stages) >= self._kept:
                self._stages.pop(next(iter(self._stages)))
            try:
                stage = Stage(self.spec, scene, self._hashes[scene])
            except (ValueError, OSError) as error:
                self._faults[scene] = error  # it is not read again for every pair
                raise
        self._stages[scene] = stage
        return stage

    def pair(self, number: int) -> tuple[StereoPair, dict[str, Any]]:
        """A pair, and its record: where its camera stood and what it shows. Raises what rendering raises."""
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
        """What is rendered: arrays' names without eyes, with those that the record needs."""
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
        """A pair; where the device is lost, by a new one."""
        try:
            return self.pair(number)
        except DeviceLostError as error:
            log.warning("item %d: %s; trying it again on a new device", number, error)
            self.renderer = Renderer(self._adapter, kept_scenes=self._kept)
            return self.pair(number)

    def shard(self, number: int, store: Store, done: Callable[[int], None] = lambda item: None) -> dict[str, Any]:
        """Makes a shard and writes it, and then its record, which says that the shard is there. An error of a pair stands in the record, and the others are made; what
        goes wrong with the storage is raised. ``done`` is told of each pair."""
        began = time.monotonic()
        name = self.spec.shard_name(number)
        # While its data is replaced, no record says that it is there.
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
        record["seconds"] = round(time.monotonic() - began, 3)
        store.write(f"{name}.json", (json.dumps(record, sort_keys=True) + "\n").encode())
        return record

    def _each(self, number: int, record: dict[str, Any], done: Callable[[int], None], use: Callable[[int, StereoPair, dict[str, Any]], Any]) -> Any:
        """Each pair of a shard, made and used: yields what its use gives. Errors of either go to the shard's record."""
        for item in self.spec.shard_items(number):
            try:
                pair, of_pair = self._pair_once_more(item)
            except Exception as error:
                # Without a device there is nothing to make the others with.
                if isinstance(error, AdapterError) and not isinstance(error, LimitError):
                    raise
                self._note(record, item, error)
                done(item)
                continue
            try:
                used = use(item, pair, of_pair)
            except OSError:  # the disk's, not the pair's
                raise
            except Exception as error:
                self._note(record, item, error)
            else:
                yield item, used
                record["pairs"].append(of_pair)
            done(item)

    @staticmethod
    def _note(record: dict[str, Any], item: int, error: Exception) -> None:
        """An error of a pair, in its shard's record."""
        text = str(error) or type(error).__name__
        log.warning("item %d: %s", item, text)
        record["errors"].append({"item": item, "error": text, "kind": type(error).__name__})

    def _file_shard(self, number: int, store: Store, record: dict[str, Any], done: Callable[[int], None]) -> dict[str, Any]:
        def use(item: int, pair: StereoPair, of_pair: dict[str, Any]) -> dict[str, bytes]:
            return encode.files(pair, self.spec, of_pair)

        file = self.spec.shard_name(number) + encode.ENDINGS[self.spec["format"]]
        with store.writing(file) as written:
            shard = (encode.Tar if self.spec["format"] == "webdataset" else encode.Parquet)(written)
            for item, files in self._each(number, record, done, use):
                shard.add(f"{item:08d}", item, files)
            shard.close()
        return {"file": file, "bytes": written.bytes, "sha256": written.sha256()}

    def _layout_shard(self, number: int, store: Store, record: dict[str, Any], done: Callable[[int], None]) -> dict[str, Any]:
        name = self.spec.shard_name(number)
        with tempfile.TemporaryDirectory(prefix="stereotrace-") as folder:

            def use(item: int, pair: StereoPair, of_pair: dict[str, Any]) -> None:
                pair.write(folder, self.spec["format"], item)

            for _ in self._each(number, record, done, use):
                pass
            size = store.put_folder(Path(folder), name)
        return {"file": name, "bytes": size}
