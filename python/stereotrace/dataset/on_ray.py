"""Makes data sets on many machines with Ray: https://docs.ray.io. Ray distributes the shards and replaces workers that
die."""

from __future__ import annotations

import json
import logging
import os
import socket
import time
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from stereotrace import AdapterError, DeviceLostError

from .._needs import needs
from .run import DataSet, Report, failure, peak_memory
from .spec import Spec
from .store import Store
from .worker import SCENE_MEMORY, Worker

log = logging.getLogger("stereotrace.dataset")

MOST_TRIES = 3
"""Maximum number of workers that try a shard. A shard that needs too much memory would kill them all."""


class ShardMaker:
    """An actor of Ray Data, which makes one shard for each call.

    The first call opens its device. The actor keeps the device and the scenes that it has read."""

    def __init__(
        self,
        values: dict[str, Any],
        folder: str,
        hashes: list[str | None],
        out: str,
        storage_options: dict[str, Any],
        adapter: str | None,
        cpus: float,
        run: str,
        scene_memory: int,
    ) -> None:
        # Limits drivers and tree builds to the worker's cores. Mesa's software driver would take all cores otherwise.
        threads = str(max(1, round(cpus)))
        for variable in ("LP_NUM_THREADS", "RAYON_NUM_THREADS"):
            os.environ.setdefault(variable, threads)
        self._spec = Spec(values, Path(folder))
        self._hashes = hashes
        self._store = Store(out, storage_options)
        self._adapter = adapter
        self._run = run
        self._scene_memory = scene_memory
        self._worker: Worker | None = None

    def __call__(self, batch: dict[str, Any]) -> dict[str, list[Any]]:
        rows = [self._row(int(shard)) for shard in batch["shard"]]
        return {"row": [json.dumps(row) for row in rows]}

    def _row(self, shard: int) -> dict[str, Any]:
        name = self._spec.shard_name(shard)
        try:
            tries = self._count_try(name)
            if tries > MOST_TRIES:
                reason = f"given up after {MOST_TRIES} tries: its worker died each time, possibly for lack of memory"
                return {"shard": name, "error": reason, "kind": "WorkerDied"}
            if tries > 1:
                self._store.remove_parts([name])
            if self._worker is None:
                self._worker = Worker(self._spec, self._hashes, self._adapter, self._scene_memory)
            record = self._worker.shard(shard, self._store)
            return {**record, "worker": _here(), "tries": tries, "memory": peak_memory(), "ended": time.time()}
        except DeviceLostError as error:
            self._worker = None  # the next shard opens a new device
            return failure(name, error)
        except AdapterError as error:
            # This worker has no adapter and can make no shard, so the run must stop.
            return {**failure(name, error), "error": f"worker on {socket.gethostname()}: {error}", "stop": True}
        except OSError as error:
            return failure(name, error)

    def _count_try(self, name: str) -> int:
        """Returns the number of workers that began this shard in this run, including this one.

        Each worker writes a mark, which stays if it dies."""
        tries = 1
        # Marks are queried by name. Listing the marks of all shards for each shard would take quadratic time.
        while tries <= MOST_TRIES and self._store.exists(f"{_marks(self._run)}/{name}.{tries}"):
            tries += 1
        self._store.mark(f"{_marks(self._run)}/{name}.{tries}")
        return tries


def _here() -> str:
    """Returns this worker's name: host, Ray's id of the node, and process id."""
    import ray

    return f"{socket.gethostname()}:{ray.get_runtime_context().get_node_id()[:8]}:{os.getpid()}"


def _marks(run: str) -> str:
    return f"tries-{run}"


CLUSTERS = "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"
"""Ray's switch between a node that other machines may join and one that listens on the loopback interface only."""


def _start(ray: Any, address: str | None) -> None:
    """Connects to a cluster, or starts Ray on this machine, listening on the loopback interface only."""
    options = {"include_dashboard": False, "log_to_driver": False, "logging_level": logging.WARNING}
    if address not in (None, "local") or (address is None and "RAY_ADDRESS" in os.environ) or CLUSTERS in os.environ:
        ray.init(address=address, **options)
        return
    # Ray read its switch when it was imported, and its processes read it when they start. So both values are changed.
    constants = ray._private.ray_constants
    before = constants.ENABLE_RAY_CLUSTER
    constants.ENABLE_RAY_CLUSTER, os.environ[CLUSTERS] = False, "0"
    try:
        ray.init(address=address, **options)
    finally:
        constants.ENABLE_RAY_CLUSTER = before
        del os.environ[CLUSTERS]


def make(
    spec: Spec,
    out: str,
    *,
    workers: int = 2,
    num_cpus: float = 1,
    num_gpus: float = 0,
    address: str | None = None,
    adapter: str | None = None,
    retry_errors: bool = False,
    storage_options: dict[str, Any] | None = None,
    progress: bool = False,
    scene_memory: int = SCENE_MEMORY,
) -> Report:
    """Makes a data set on Ray, or resumes it.

    ``workers`` actors with ``num_cpus`` cores and ``num_gpus`` GPUs each make one shard after the other. Without an
    ``address``, and if Ray is not initialised yet, Ray starts on this machine, and other machines can't reach it. All
    machines must reach ``out`` and the spec's scene files. ``scene_memory`` is that of each worker in bytes: see
    ``stereotrace.dataset.make``.

    Raises as ``stereotrace.dataset.make`` does. The report and the manifest contain errors of pairs and shards."""
    ray, _ = needs("ray", "ray"), needs("ray.data", "ray")
    began, clock = time.monotonic(), time.time()
    if "://" not in out:
        out = os.path.abspath(out)
    store = Store(out, storage_options)
    data_set = DataSet(spec, store)
    pending = data_set.pending(range(spec.shards), retry_errors)
    data_set.clear(pending)
    kept, run = spec.shards - len(pending), uuid.uuid4().hex[:12]
    if not pending:
        return data_set.run([], kept, began)
    if not ray.is_initialized():
        _start(ray, address)
    ray.data.DataContext.get_current().enable_progress_bars = progress
    if not progress:
        logging.getLogger("ray.data").setLevel(logging.ERROR)
    workers = min(workers, len(pending))
    shards = ray.data.from_items([{"shard": shard} for shard in pending], override_num_blocks=len(pending))
    records = shards.map_batches(
        ShardMaker,
        fn_constructor_args=(
            spec.values,
            str(spec.folder),
            data_set.hashes,
            out,
            store.options,
            adapter,
            num_cpus,
            run,
            scene_memory,
        ),
        batch_size=1,
        # A worker gets one shard at a time. A queued shard would wait behind a slow one while other workers are idle.
        compute=ray.data.ActorPoolStrategy(size=workers, max_tasks_in_flight_per_actor=1),
        num_cpus=num_cpus,
        num_gpus=num_gpus,
    )
    ended: list[tuple[float, dict[str, Any]]] = []

    def rows() -> Iterator[dict[str, Any]]:
        for found in records.iter_rows():
            row = json.loads(found["row"])
            if row.get("stop"):
                raise AdapterError(row["error"])
            if "error" not in row:
                ended.append((row["ended"], row))
            yield row

    try:
        report = data_set.run(rows(), kept, began)
    finally:
        store.remove(_marks(run))
    if ended:
        at, row = min(ended, key=lambda one: one[0])
        report.first_pair_seconds = at - clock - row["seconds"] * (len(row["pairs"]) - 1) / max(1, len(row["pairs"]))
        report.retried = sum(row["tries"] > 1 for _, row in ended)
        report.workers = {row["worker"]: row["memory"] for _, row in ended}
    return report
