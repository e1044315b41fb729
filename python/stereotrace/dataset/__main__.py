"""``python -m stereotrace.dataset``: makes a data set, on this machine or on Ray."""

from __future__ import annotations

import argparse
import json
import logging
import signal
import sys
import tempfile
from pathlib import Path
from typing import Any

from stereotrace import AdapterError

from . import Spec, make, make_on_ray
from .encode import files
from .store import Store
from .worker import SCENE_MEMORY, Worker


def parser() -> argparse.ArgumentParser:
    found = argparse.ArgumentParser(
        prog="python -m stereotrace.dataset",
        description="Makes a data set of stereo pairs from a spec, or resumes one. "
        "Shards are written whole or not at all.",
    )
    found.add_argument("spec", help="YAML file; docs/DATA-SETS.md lists its keys")
    found.add_argument("out", help="folder, or any URL that fsspec supports, such as s3://bucket/folder")
    found.add_argument(
        "--shards", metavar="FROM..TO", type=_range, help="make only these shards, such as 0..4 for the first four"
    )
    found.add_argument(
        "--item", metavar="N", type=int, help="make only this pair; its files go to OUT as they would go into a shard"
    )
    found.add_argument("--retry-errors", action="store_true", help="make shards with missing pairs again")
    found.add_argument(
        "--adapter",
        metavar="NAME",
        help="graphics adapter: software, fastest, or a part of its name "
        "[default: STEREOTRACE_ADAPTER, else the fastest]",
    )
    found.add_argument(
        "--storage-option",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        type=_pair,
        help="option of the fsspec file system; can be repeated",
    )
    found.add_argument(
        "--scene-memory",
        metavar="MIB",
        type=_memory,
        default=SCENE_MEMORY,
        help=f"memory for the scenes that each worker keeps [default: {SCENE_MEMORY >> 20}]",
    )
    found.add_argument("--quiet", action="store_true", help="show no progress bar")
    ray = found.add_argument_group("on Ray")
    ray.add_argument("--ray", action="store_true", help="make shards with Ray workers, on this machine or on a cluster")
    ray.add_argument(
        "--address", metavar="ADDRESS", help="address of the cluster; auto for the cluster that includes this machine"
    )
    ray.add_argument("--workers", type=int, default=2, metavar="N", help="number of workers [default: 2]")
    ray.add_argument("--cpus", type=float, default=1, metavar="N", help="CPU cores per worker [default: 1]")
    ray.add_argument("--gpus", type=float, default=0, metavar="N", help="GPUs per worker [default: 0]")
    return found


def _range(text: str) -> range:
    first, dots, last = text.partition("..")
    if not dots or not first.isdigit() or not last.isdigit() or int(first) >= int(last):
        raise argparse.ArgumentTypeError("it must be a range like 0..4")
    return range(int(first), int(last))


def _memory(text: str) -> int:
    if not text.isdigit():
        raise argparse.ArgumentTypeError("it must be a number of MiB")
    return int(text) << 20


def _pair(text: str) -> tuple[str, Any]:
    key, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError("it must be KEY=VALUE")
    try:
        return key, json.loads(value)
    except ValueError:
        return key, value


def _interrupted(*_: object) -> None:
    raise KeyboardInterrupt


def main(arguments: list[str] | None = None) -> int:
    """Returns the exit status: 0 if the data set is complete, 1 if a part is missing or wrong, 130 if interrupted."""
    given = parser().parse_args(arguments)
    # SIGTERM raises an exception, so that unfinished files are removed.
    signal.signal(signal.SIGTERM, _interrupted)
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    try:
        spec = Spec.load(given.spec)
        storage = dict(given.storage_option)
        if given.item is not None:
            return _one_item(spec, given, storage)
        common = {
            "adapter": given.adapter,
            "retry_errors": given.retry_errors,
            "storage_options": storage,
            "progress": not given.quiet,
            "scene_memory": given.scene_memory,
        }
        if not given.ray:
            if given.address is not None:
                raise ValueError("--address: it is the address of a Ray cluster; give --ray too")
            report = make(spec, given.out, shards=given.shards, **common)
        else:
            if given.shards is not None:
                raise ValueError("--shards: with --ray, all missing shards are made")
            report = make_on_ray(
                spec,
                given.out,
                address=given.address,
                workers=given.workers,
                num_cpus=given.cpus,
                num_gpus=given.gpus,
                **common,
            )
    except KeyboardInterrupt:
        print("interrupted; run the same command again to resume", file=sys.stderr)
        return 130
    except (ImportError, ValueError, OSError, AdapterError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(f"{given.out}: {report.summary()}")
    return 1 if report.errors or report.failed else 0


def _one_item(spec: Spec, given: argparse.Namespace, storage: dict[str, Any]) -> int:
    if not 0 <= given.item < spec["pairs"]:
        raise ValueError(f"--item {given.item}: the data set has the items 0 to {spec['pairs'] - 1}")
    worker = Worker(spec, adapter=given.adapter)
    pair, record = worker.pair(given.item)
    store = Store(given.out, storage)
    store.make_folder()
    if spec.is_layout:
        with tempfile.TemporaryDirectory(prefix="stereotrace-") as folder:
            written = pair.write(folder, spec["format"], given.item)
            store.put_files(Path(folder))
            print("\n".join(store.place(Path(path).relative_to(folder).as_posix()) for path in written))
        return 0
    for name, data in files(pair, spec, record).items():
        store.write(f"{given.item:08d}.{name}", data)
        print(store.place(f"{given.item:08d}.{name}"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
