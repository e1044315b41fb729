"""Data sets in a store: finished and pending shards, the manifest, and runs on this machine."""

from __future__ import annotations

import hashlib
import json
import logging
import os
import shutil
import socket
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, Callable

import stereotrace
from stereotrace import DeviceLostError

from .._needs import needs
from .._stereotrace import PairMaker
from .spec import Spec, canonical
from .store import Store
from .worker import SCENE_MEMORY, Worker, scene_files

log = logging.getLogger("stereotrace.dataset")

HEAD = "dataset.json"
MANIFEST = "manifest.jsonl"
ROUNDS = 5
"""Maximum number of times that a manifest is rebuilt because other runs made shards meanwhile. Each run writes it at
its end."""


class OtherDataSet(ValueError):
    """The data set in the folder was made with other files, another spec or another version."""


@dataclass
class Report:
    """Result of a run."""

    made: int = 0
    """Number of shards that were made."""
    kept: int = 0
    """Number of shards that existed already."""
    pairs: int = 0
    """Number of pairs in the shards that were made."""
    errors: list[dict[str, Any]] = field(default_factory=list)
    """Pairs of all shards that could not be made, in this run or before: ``item`` and ``error``."""
    failed: list[dict[str, Any]] = field(default_factory=list)
    """Shards that could not be made or written: ``shard`` and ``error``. The next run tries them again."""
    seconds: float = 0.0
    first_pair_seconds: float | None = None
    """Seconds from the start to the first pair; on Ray to the first shard's end, less the share of its other pairs."""
    retried: int = 0
    """On Ray: number of shards that a second or later worker made, after the first one died."""
    workers: dict[str, int | None] = field(default_factory=dict)
    """Peak memory of each worker in bytes, by its host and process."""

    def summary(self) -> str:
        text = f"{self.pairs} pairs in {self.made} shards: {self.seconds:.1f} s"
        if self.pairs and self.seconds:
            text += f", {60 * self.pairs / self.seconds:.1f} pairs per minute"
        if self.first_pair_seconds is not None:
            text += f", the first after {self.first_pair_seconds:.1f} s"
        if memory := [memory for memory in self.workers.values() if self.pairs and memory]:
            text += f"; workers used up to {max(memory) / 2**20:.0f} MiB"
        if self.kept:
            text += f"; {self.kept} shards already existed"
        if self.retried:
            text += f"; {self.retried} were made again, because their workers died"
        if self.errors:
            first = self.errors[0]
            text += f"; {len(self.errors)} pairs could not be made, the first is item {first['item']}: {first['error']}"
        if self.failed:
            first = self.failed[0]
            text += f"; {len(self.failed)} shards failed, the first is {first['shard']}: {first['error']}"
        return text


class DataSet:
    """A spec and the store of its shards.

    Opening begins or resumes the data set. It reads and hashes the scenes, but for those whose files have not changed
    since the data set was last opened. ``maker`` reads the scenes and may keep them.

    Raises ``OtherDataSet`` if another data set is in the store, and ``OSError`` if the store can't be reached or
    written."""

    def __init__(self, spec: Spec, store: Store, maker: PairMaker | None = None) -> None:
        self.spec = spec
        self.store = store
        store.make_folder()
        there = self._there()
        self.head, self._scene_files = self._head(there, PairMaker(spec.checked, 0) if maker is None else maker)
        self._begin(there)

    def _there(self) -> dict[str, Any] | None:
        """Reads the head of the data set in the store, if there is one."""
        if not self.store.exists(HEAD):
            return None
        try:
            there = json.loads(self.store.read(HEAD))
            fits = there["version"] == stereotrace.__version__ and there["spec_sha256"] == self.spec.sha256()
            hashes = [scene.get("sha256") for scene in there["scenes"]]
            if fits and len(hashes) != len(self.spec["scenes"]):
                raise ValueError(f"it has {len(hashes)} scenes, but its spec has {len(self.spec['scenes'])}")
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise OtherDataSet(f"{self.store.place(HEAD)}: it does not belong to a data set: {error}") from error
        return dict(there)

    def _head(self, there: dict[str, Any] | None, maker: PairMaker) -> tuple[dict[str, Any], list[str | None]]:
        """Returns the data set's head, and for each scene a hash of its files' names, sizes and times.

        A scene that can't be read has its error in place of a hash."""
        scenes: list[dict[str, Any]] = []
        files: list[str | None] = []
        known_files: list[Any] = []
        if (
            there is not None
            and there["version"] == stereotrace.__version__
            and there["spec_sha256"] == self.spec.sha256()
        ):
            known_files = there.get("scene_files") or []
        own = Path(self.store.url).resolve() if self.store.is_local else None
        for index in range(len(self.spec["scenes"])):
            known: dict[str, Any] = {"scene": self.spec.scene_name(index)}
            found = scene_files(self.spec, index, own)
            if there is not None and found is not None and index < len(known_files) and found == known_files[index]:
                scenes.append(there["scenes"][index])
                files.append(found)
                continue
            try:
                known["sha256"] = maker.scene_sha256(index)
            except (ValueError, OSError) as error:
                log.warning("%s", error)
                known["error"] = str(error)
                found = None  # the next run reads it again
            scenes.append(known)
            files.append(found)
        head = {
            "format": "stereotrace data set 1",
            "version": stereotrace.__version__,
            "spec": self.spec.values,
            "spec_sha256": self.spec.sha256(),
            "scenes": scenes,
            "shards": self.spec.shards,
        }
        return head, files

    def _begin(self, there: dict[str, Any] | None) -> None:
        if there is None:
            self._write_head()
            return
        try:
            differing = self._differing(there)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise OtherDataSet(f"{self.store.place(HEAD)}: it does not belong to a data set: {error}") from error
        if differing:
            place = self.store.place(HEAD)
            raise OtherDataSet(f"{place}: the data set there has a different {differing}; use another folder")
        # A scene that can't be read now keeps its old hash. One that could not be read before gets its hash now.
        for then, now in zip(there["scenes"], self.head["scenes"]):
            if "sha256" in then:
                now["sha256"] = then["sha256"]
        if [scene.get("sha256") for scene in there["scenes"]] != self.hashes or there.get(
            "scene_files"
        ) != self._scene_files:
            self._write_head()

    def _write_head(self) -> None:
        head = {**self.head, "scene_files": self._scene_files}
        self.store.write(HEAD, (json.dumps(head, indent=1, sort_keys=True) + "\n").encode())

    def _differing(self, there: dict[str, Any]) -> str | None:
        if there["version"] != self.head["version"]:
            return f"version of stereotrace ({there['version']}, not {self.head['version']})"
        if there["spec_sha256"] != self.head["spec_sha256"]:
            keys = sorted({*there["spec"], *self.spec.values})
            other = [key for key in keys if canonical(there["spec"].get(key)) != canonical(self.spec.values.get(key))]
            return f"spec: {', '.join(other)}"
        for then, now in zip(there["scenes"], self.head["scenes"]):
            if "sha256" in then and "sha256" in now and then["sha256"] != now["sha256"]:
                return f"scene: {now['scene']} has changed"
        return None

    @property
    def hashes(self) -> list[str | None]:
        return [scene.get("sha256") for scene in self.head["scenes"]]

    def record(self, shard: int) -> dict[str, Any] | None:
        """Returns a shard's record, or ``None`` if the shard does not exist."""
        return next(self.records([shard]))

    def records(self, shards: list[int]) -> Iterator[dict[str, Any] | None]:
        """Yields the records of shards, or ``None`` for a missing one. Several are read at once."""
        for data in self.store.read_all([f"{self.spec.shard_name(shard)}.json" for shard in shards]):
            try:
                found = None if data is None else json.loads(data)
            except ValueError:
                found = None
            yield found if isinstance(found, dict) else None

    def pending(self, shards: Iterable[int], retry_errors: bool = False) -> list[int]:
        """Returns those of the shards that are missing or incomplete.

        With ``retry_errors`` this includes shards in which a pair is missing."""
        names, asked = self.store.names(), list(shards)
        there = [
            shard
            for shard in asked
            if self.spec.data_name(shard) in names and f"{self.spec.shard_name(shard)}.json" in names
        ]
        if retry_errors:
            there = [
                shard
                for shard, record in zip(there, self.records(there))
                if record is not None and not record["errors"]
            ]
        kept = set(there)
        return [shard for shard in asked if shard not in kept]

    def clear(self, shards: Iterable[int]) -> None:
        """Removes unfinished files of these shards and of the manifest, which killed processes left."""
        names = [self.spec.shard_name(shard) for shard in shards]
        self.store.remove_parts([*names, HEAD.partition(".")[0], MANIFEST.partition(".")[0]])

    def write_manifest(self, failed: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Builds the manifest from the shards' records, and writes it if it changed.

        It has one line of JSON for the data set, each shard and each pair. Pairs that could not be made and failed
        shards that do not exist yet have a line too. Returns the lines of all pairs that could not be made."""
        missing: list[dict[str, Any]] = []
        before = self._stamps()
        for _ in range(ROUNDS):
            # Built on this machine's disk, since the manifest of a million pairs has 500 MB.
            with tempfile.TemporaryFile(prefix="stereotrace-") as file:
                missing = self._put_together(file, sorted(before), failed)
                if not self._is_written(file):
                    file.seek(0)
                    with self.store.writing(MANIFEST) as written:
                        shutil.copyfileobj(file, written)
            # A concurrent run may have written a manifest that this run has just replaced.
            after = self._stamps()
            if before == after:
                break
            before = after
        return missing

    def _stamps(self) -> dict[int, str]:
        """Returns the shards whose records exist, with a stamp that changes if the record does."""
        found = {}
        for name, stamp in self.store.stamps().items():
            number = name.removesuffix(".json").rpartition("-")[2]
            if (
                number.isdecimal()
                and int(number) < self.spec.shards
                and name == f"{self.spec.shard_name(int(number))}.json"
            ):
                found[int(number)] = stamp
        return found

    def _put_together(self, file: IO[bytes], there: list[int], failed: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Writes the manifest's lines to ``file``. Returns the lines of pairs that could not be made."""
        missing = []

        def add(line: dict[str, Any]) -> None:
            file.write((json.dumps(line, sort_keys=True) + "\n").encode())

        add(self.head)
        for shard, record in zip(there, self.records(there)):
            if record is None:
                continue
            name = self.spec.shard_name(shard)
            pairs, errors = record.pop("pairs"), record.pop("errors")
            record.pop("files", None)  # the hashes of a layout's files stay in the shard's record
            add(record)
            for line in [*pairs, *errors]:
                add({**line, "shard": name})
            missing += [{**error, "shard": name} for error in errors]
        known = {self.spec.shard_name(shard) for shard in there} | {row["shard"] for row in failed}
        for row in [*self._failed_before(known), *failed]:
            add(row)
        return missing

    def _failed_before(self, known: set[str]) -> Iterator[dict[str, Any]]:
        """Yields the rows of shards that failed in other runs and are not in ``known``."""
        for line in self.store.lines(MANIFEST):
            if b'"error"' not in line or b'"item"' in line:
                continue
            try:
                row = json.loads(line)
                failed_before = "error" in row and row["shard"] not in known
            except (ValueError, KeyError, TypeError):
                continue
            if failed_before:
                yield row

    def _is_written(self, file: IO[bytes]) -> bool:
        """Returns whether the store's manifest equals this file."""
        hashes = []
        file.seek(0)
        for lines in (file, self.store.lines(MANIFEST)):
            found = hashlib.sha256()
            for line in lines:
                found.update(line)
            hashes.append(found.digest())
        return hashes[0] == hashes[1]

    def run(self, rows: Iterable[dict[str, Any]], kept: int, began: float) -> Report:
        """Collects records and errors of shards into a report. Writes the manifest at the end, even after an error."""
        report = Report(kept=kept)
        try:
            for row in rows:
                if "error" in row:
                    log.error("%s: %s", row["shard"], row["error"])
                    report.failed.append(row)
                    continue
                report.made += 1
                report.pairs += len(row["pairs"])
                report.errors += row["errors"]  # replaced by those of all shards once the manifest is built
        finally:
            report.seconds = time.monotonic() - began
            try:
                report.errors = self.write_manifest(report.failed)
            except OSError as error:  # such as a full disk; an earlier error is the one to raise
                log.error("%s: %s", self.store.place(MANIFEST), error)
        return report


def peak_memory() -> int | None:
    """Returns the peak memory of this process in bytes, or ``None`` if that is unknown."""
    if sys.platform == "win32":
        return None
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


def failure(shard: str, error: BaseException) -> dict[str, Any]:
    """Returns the row of a failed shard."""
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
    scene_memory: int = SCENE_MEMORY,
) -> Report:
    """Makes a data set in this process, or resumes it.

    ``shards`` limits the run to some shards; other runs may make the others. ``scene_memory`` limits the scenes that
    are kept, in bytes, here and on the device together. The current scene is always kept.

    Raises ``OtherDataSet`` if another data set is in the folder, and ``OSError`` if the folder can't be written. Raises
    ``AdapterError`` if there is no adapter, and ``ValueError`` for shards out of range. The report and the manifest
    contain errors of pairs and shards."""
    began = time.monotonic()
    asked = list(range(spec.shards) if shards is None else shards)
    if wrong := [shard for shard in asked if not 0 <= shard < spec.shards]:
        raise ValueError(f"shard {wrong[0]}: the data set has {spec.shards}, counted from 0")
    maker = PairMaker(spec.checked, scene_memory)
    data_set = DataSet(spec, Store(out, storage_options), maker)
    pending = data_set.pending(asked, retry_errors)
    data_set.clear(pending)
    first: list[float] = []

    def rows(tell: Callable[[int], None]) -> Iterator[dict[str, Any]]:
        worker = Worker(spec, data_set.hashes, adapter, scene_memory, maker) if pending else None
        for shard in pending:
            try:
                assert worker is not None
                yield worker.shard(shard, data_set.store, tell)
            except (OSError, DeviceLostError) as error:
                # Another process may have made the shard meanwhile, and replaced the files of this one.
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
    """A progress bar on the terminal, if ``shown``."""

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
