"""A data set from its beginning to its manifest: what has been made, what is to be made, and the run on this machine."""

from __future__ import annotations

import json
import logging
import os
import socket
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any, Callable

import stereotrace
from stereotrace import DeviceLostError

from .._needs import needs
from .encode import ENDINGS
from .spec import Spec, canonical
from .store import Store
from .worker import Worker, open_scene, scene_hash

log = logging.getLogger("stereotrace.dataset")

HEAD = "dataset.json"
MANIFEST = "manifest.jsonl"


class OtherDataSet(ValueError):
    """What lies in the folder was made with other files, another spec or another version."""


@dataclass
class Report:
    """What a run did."""

    made: int = 0
    """Shards that were made."""
    kept: int = 0
    """Shards that were there already."""
    pairs: int = 0
    """Pairs in the shards that were made."""
    errors: list[dict[str, Any]] = field(default_factory=list)
    """Pairs of all shards that could not be made, now or before: ``item`` and ``error``."""
    failed: list[dict[str, Any]] = field(default_factory=list)
    """Shards that could not be made or written: ``shard`` and ``error``. A run that goes on makes them."""
    seconds: float = 0.0
    first_pair_seconds: float | None = None
    """From the start of the run to its first pair; on Ray to the first shard's end, less its other pairs' share."""
    retried: int = 0
    """On Ray: shards that were made by another worker than the first one that began them."""
    workers: dict[str, int | None] = field(default_factory=dict)
    """The most memory that each worker took, in bytes, by its host and process."""

    def summary(self) -> str:
        text = f"{self.pairs} pairs in {self.made} shards: {self.seconds:.1f} s"
        if self.pairs and self.seconds:
            text += f", {60 * self.pairs / self.seconds:.1f} pairs a minute"
        if self.first_pair_seconds is not None:
            text += f", the first after {self.first_pair_seconds:.1f} s"
        if memory := [memory for memory in self.workers.values() if self.pairs and memory]:
            text += f"; workers took up to {max(memory) / 2**20:.0f} MiB"
        if self.kept:
            text += f"; {self.kept} shards were there already"
        if self.retried:
            text += f"; {self.retried} were made again, their workers having died"
        if self.errors:
            text += f"; {len(self.errors)} pairs are missing that could not be made, the first is item {self.errors[0]['item']}: {self.errors[0]['error']}"
        if self.failed:
            text += f"; {len(self.failed)} shards failed, the first is {self.failed[0]['shard']}: {self.failed[0]['error']}"
        return text


class DataSet:
    """A spec and the place where its shards lie. Opening one reads the scenes, to know them by their hashes, and begins the data set or goes on with it.

    Raises ``OtherDataSet`` where another one lies there, and ``OSError`` where the place can't be reached or written."""

    def __init__(self, spec: Spec, store: Store) -> None:
        self.spec = spec
        self.store = store
        store.make_folder()
        self.head = self._head()
        self._begin()

    def _head(self) -> dict[str, Any]:
        """What the data set is made with. A scene that can't be read has its error in place of a hash."""
        scenes = []
        for index in range(len(self.spec["scenes"])):
            known: dict[str, Any] = {"scene": self.spec.scene_name(index)}
            try:
                known["sha256"] = scene_hash(self.spec, index, open_scene(self.spec, index))
            except (ValueError, OSError) as error:
                log.warning("%s", error)
                known["error"] = str(error)
            scenes.append(known)
        return {
            "format": "stereotrace data set 1",
            "version": stereotrace.__version__,
            "spec": self.spec.values,
            "spec_sha256": self.spec.sha256(),
            "scenes": scenes,
            "shards": self.spec.shards,
        }

    def _begin(self) -> None:
        if not self.store.exists(HEAD):
            self._write_head()
            return
        try:
            there = json.loads(self.store.read(HEAD))
            differing = self._differing(there)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise OtherDataSet(f"{self.store.place(HEAD)}: it is no data set's: {error}") from error
        if differing:
            raise OtherDataSet(f"{self.store.place(HEAD)}: the data set there has another {differing}; take another folder")
        # A scene that can't be read now is still the one that it was; one that could not be read then is known from now on.
        for then, now in zip(there["scenes"], self.head["scenes"]):
            if "sha256" in then:
                now["sha256"] = then["sha256"]
        if [scene.get("sha256") for scene in there["scenes"]] != self.hashes:
            self._write_head()

    def _write_head(self) -> None:
        self.store.write(HEAD, (json.dumps(self.head, indent=1, sort_keys=True) + "\n").encode())

    def _differing(self, there: dict[str, Any]) -> str | None:
        if there["version"] != self.head["version"]:
            return f"version of stereotrace ({there['version']}, not {self.head['version']})"
        if there["spec_sha256"] != self.head["spec_sha256"]:
            keys = sorted({*there["spec"], *self.spec.values})
            other = [key for key in keys if canonical(there["spec"].get(key)) != canonical(self.spec.values.get(key))]
            return f"spec: {', '.join(other)}"
        for then, now in zip(there["scenes"], self.head["scenes"]):
            if "sha256" in then and "sha256" in now and then["sha256"] != now["sha256"]:
                return f"scene: {now['scene']} shows something else now"
        return None

    @property
    def hashes(self) -> list[str | None]:
        return [scene.get("sha256") for scene in self.head["scenes"]]

    def data_name(self, shard: int) -> str:
        """A shard's file, or its folder."""
        name = self.spec.shard_name(shard)
        return name if self.spec.is_layout else name + ENDINGS[self.spec["format"]]

    def record(self, shard: int) -> dict[str, Any] | None:
        """A shard's record, if the shard is there."""
        try:
            found: dict[str, Any] = json.loads(self.store.read(f"{self.spec.shard_name(shard)}.json"))
        except (FileNotFoundError, ValueError):
            return None
        return found

    def pending(self, shards: Iterable[int], retry_errors: bool = False) -> list[int]:
        """The shards of these that are not there, or not whole; with ``retry_errors`` those too in which a pair is missing."""
        there, pending = self.store.names(), []
        for shard in shards:
            is_there = self.data_name(shard) in there and f"{self.spec.shard_name(shard)}.json" in there
            if is_there and retry_errors:
                record = self.record(shard)
                is_there = record is not None and not record["errors"]
            if not is_there:
                pending.append(shard)
        return pending

    def clear(self, shards: Iterable[int]) -> None:
        """Removes what processes that were killed left of these shards, and of the manifest."""
        names = [self.spec.shard_name(shard) for shard in shards]
        self.store.remove_parts([*names, HEAD.partition(".")[0], MANIFEST.partition(".")[0]])

    def write_manifest(self, failed: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Puts the manifest together from the shards' records: a line of JSON for the data set, one for each shard, each pair, each pair that
        could not be made, and each shard that failed in this run. Returns the lines of all pairs that could not be made."""
        there, missing = self.store.names(), []
        with self.store.writing(MANIFEST) as file:
            for line in self._manifest(there, failed):
                file.write((json.dumps(line, sort_keys=True) + "\n").encode())
                if "error" in line and "item" in line:
                    missing.append(line)
        return missing

    def _manifest(self, there: set[str], failed: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
        yield self.head
        for shard in range(self.spec.shards):
            name = self.spec.shard_name(shard)
            record = self.record(shard) if f"{name}.json" in there else None
            if record is None:
                continue
            pairs, errors = record.pop("pairs"), record.pop("errors")
            yield record
            yield from ({**pair, "shard": name} for pair in pairs)
            yield from ({**error, "shard": name} for error in errors)
        yield from failed

    def run(self, rows: Iterable[dict[str, Any]], kept: int, began: float) -> Report:
        """Takes shards' records, or their errors, as they come; the manifest is written at the end, however that comes."""
        report = Report(kept=kept)
        try:
            for row in rows:
                if "error" in row:
                    log.error("%s: %s", row["shard"], row["error"])
                    report.failed.append(row)
                    continue
                report.made += 1
                report.pairs += len(row["pairs"])
                report.errors += row["errors"]  # until the manifest tells of all shards
        finally:
            report.seconds = time.monotonic() - began
            try:
                report.errors = self.write_manifest(report.failed)
            except OSError as error:  # a full disk; what led here is the error to tell
                log.error("%s: %s", self.store.place(MANIFEST), error)
        return report


def peak_memory() -> int | None:
    """The most memory that this process has taken so far, in bytes; ``None`` where that is not known."""
    if sys.platform == "win32":
        return None
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


def failure(shard: str, error: BaseException) -> dict[str, Any]:
    """The row of a shard that failed."""
    return {"shard": shard, "error": str(error) or type(error).__name__, "kind": type(error).__name__}


def make(
    spec: Spec,
    out: str,
    *,
    shards: Iterable[int] | None = None,
    adapter: str | None = None,
    retry_errors: bool = False,
    storage_options: dict[str, Any] | None = None,
    progress: bool = False,
) -> Report:
    """Makes a data set on this machine, in this process, or goes on with it. ``shards`` takes some of them alone; the others may be made elsewhere.

    Raises ``OtherDataSet`` where another data set lies there, ``OSError`` where nothing can be written there, and ``AdapterError`` where there is nothing to render with. What is wrong with a
    pair or a shard is in the report, and in the manifest."""
    began = time.monotonic()
    asked = list(range(spec.shards) if shards is None else shards)
    if wrong := [shard for shard in asked if not 0 <= shard < spec.shards]:
        raise ValueError(f"shard {wrong[0]}: the data set has {spec.shards}, counted from 0")
    data_set = DataSet(spec, Store(out, storage_options))
    pending = data_set.pending(asked, retry_errors)
    data_set.clear(pending)
    first: list[float] = []

    def rows(tell: Callable[[int], None]) -> Iterator[dict[str, Any]]:
        worker = Worker(spec, data_set.hashes, adapter) if pending else None
        for shard in pending:
            try:
                assert worker is not None
                yield worker.shard(shard, data_set.store, tell)
            except (OSError, DeviceLostError) as error:
                # Another process may have made it meanwhile, and renamed or removed what this one wrote.
                yield data_set.record(shard) or failure(spec.shard_name(shard), error)

    count = sum(len(spec.shard_items(shard)) for shard in pending)
    with closing(_Bar(count, progress)) as bar:

        def tell(item: int) -> None:
            first or first.append(time.monotonic() - began)  # type: ignore[func-returns-value]
            bar.next()

        report = data_set.run(rows(tell), len(asked) - len(pending), began)
    report.first_pair_seconds = first[0] if first else None
    report.workers = {f"{socket.gethostname()}:{os.getpid()}": peak_memory()}
    return report


class _Bar:
    """A progress bar at the terminal, or nothing."""

    def __init__(self, count: int, shown: bool) -> None:
        self._bar: Any = None
        if shown:
            self._bar = needs("tqdm", "dataset").tqdm(total=count, unit="pair", smoothing=0.1)

    def next(self, count: int = 1) -> None:
        if self._bar is not None:
            self._bar.update(count)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
