"""Tests data sets on Ray: a worker that is killed, and shards that kill their workers."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

ray = pytest.importorskip("ray")

from stereotrace import AdapterError, dataset
from stereotrace.dataset import Spec, on_ray

SPEC = {
    "name": "killed",
    "seed": 3,
    "pairs": 64,
    "shard_pairs": 8,
    "size": [96, 64],
    "scenes": [{"builtin": "hall"}, {"builtin": "spheres"}],
    "outputs": ["color", "disparity", "occlusion", "normal", "object", "source"],
}


@pytest.fixture(scope="module", autouse=True)
def cluster():
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    yield
    ray.shutdown()


def workers() -> list[int]:
    """Returns the processes of this machine's actors."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            title = (entry / "cmdline").read_bytes()
        except OSError:
            continue
        if title.startswith(b"ray::") and b"MapWorker" in title:
            found.append(int(entry.name))
    return found


def is_writing(process: int) -> bool:
    """Returns whether a process has an unfinished shard open. Another worker may be idle, whose death costs nothing."""
    try:
        return any(".tar.part-" in os.readlink(file) for file in Path(f"/proc/{process}/fd").iterdir())
    except OSError:
        return False


def test_a_killed_worker_loses_nothing(tmp_path, capsys):
    """Two workers make 64 pairs, and one is killed in the middle of a shard. All pairs equal those of one process."""
    spec, out = Spec.load(SPEC), tmp_path / "ray"
    killed: list[int] = []

    def kill() -> None:
        # A worker is killed once the first shard is complete and others are being written.
        deadline = time.monotonic() + 300
        while time.monotonic() < deadline:
            if list(out.glob("killed-*.json")) and (found := list(filter(is_writing, workers()))):
                os.kill(found[0], signal.SIGKILL)
                killed.append(found[0])
                return
            time.sleep(0.002)

    killer = threading.Thread(target=kill)
    killer.start()
    report = dataset.make_on_ray(spec, str(out), workers=2)
    killer.join()
    with capsys.disabled():
        print(f"\nkilled worker {killed}: {report.summary()}; workers {sorted(report.workers)}")
    assert killed
    assert (report.made, report.pairs, report.errors, report.failed) == (8, 64, [], [])
    assert report.retried == 1 and len(report.workers) >= 2
    alone = tmp_path / "alone"
    dataset.make(spec, str(alone))
    for shard in range(8):
        name = f"killed-{shard:06d}.tar"
        assert (out / name).read_bytes() == (alone / name).read_bytes(), name
    lines = [json.loads(line) for line in (out / "manifest.jsonl").read_text().splitlines()]
    assert [line["item"] for line in lines if "item" in line] == list(range(64))
    assert not [path.name for path in out.iterdir() if "part-" in path.name or path.name.startswith("tries")]
    again = dataset.make_on_ray(spec, str(out), workers=2)
    assert (again.made, again.kept) == (0, 8)


class Doomed(on_ray.ShardMaker):
    """The worker dies when it makes shard 1, like a worker that is out of memory."""

    def _row(self, shard: int):
        made = super()._count_try
        if shard == 1:

            def dies(name: str) -> int:
                tries = made(name)
                if tries <= on_ray.MOST_TRIES:
                    os.kill(os.getpid(), signal.SIGKILL)
                return tries

            self._count_try = dies
        return super()._row(shard)


def test_a_shard_that_kills_its_workers_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(on_ray, "ShardMaker", Doomed)
    ray.shutdown()
    # Workers must find the class in this file.
    ray.init(
        num_cpus=2,
        include_dashboard=False,
        log_to_driver=False,
        runtime_env={"env_vars": {"PYTHONPATH": str(Path(__file__).parent)}},
    )
    spec = Spec.load({**SPEC, "pairs": 6, "shard_pairs": 2, "size": [32, 24]})
    report = dataset.make_on_ray(spec, str(tmp_path / "out"), workers=2)
    assert report.made == 2 and [row["shard"] for row in report.failed] == ["killed-000001"]
    assert "given up after 3 tries" in report.failed[0]["error"]
    lines = [json.loads(line) for line in (tmp_path / "out" / "manifest.jsonl").read_text().splitlines()]
    assert lines[-1]["shard"] == "killed-000001" and "given up" in lines[-1]["error"]


def test_no_adapter_stops_the_run(tmp_path):
    spec = Spec.load({**SPEC, "pairs": 2, "shard_pairs": 1, "size": [32, 24]})
    with pytest.raises(AdapterError, match="worker on .*no graphics adapter found for the name 'Voodoo2'"):
        dataset.make_on_ray(spec, str(tmp_path / "out"), workers=1, adapter="Voodoo2")


LISTENING = """if 1:
    import os, pathlib, ray
    from stereotrace.dataset import on_ray
    on_ray._start(ray, None)

    @ray.remote
    def one():
        return 1

    assert ray.get(one.remote()) == 1
    parents = {}
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            pass
    own, grown = {os.getpid()}, True
    while grown:
        more = {child for child, parent in parents.items() if parent in own} - own
        own, grown = own | more, bool(more)
    sockets = set()
    for process in own:
        for file in pathlib.Path(f"/proc/{process}/fd").glob("*"):
            try:
                sockets.add(os.readlink(file))
            except OSError:
                pass
    for family in ("tcp", "tcp6"):
        for line in pathlib.Path(f"/proc/net/{family}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A" and f"socket:[{fields[9]}]" in sockets:
                print(fields[1].partition(":")[0])
    print(os.environ.get("RAY_AUTH_MODE"), on_ray.CLUSTERS in os.environ)
    ray.shutdown()
"""


def test_a_ray_of_this_machine_listens_on_the_loopback_interface_alone(tmp_path):
    env = {
        key: value for key, value in os.environ.items() if key not in ("RAY_ADDRESS", "RAY_AUTH_MODE", on_ray.CLUSTERS)
    }
    found = subprocess.run(
        [sys.executable, "-c", LISTENING],
        env={**env, "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert found.returncode == 0, found.stderr
    *places, last = found.stdout.split("\n")[:-1]
    loopback = {"0100007F", "0000000000000000FFFF00000100007F", "00000000000000000000000001000000"}
    assert len(places) >= 4 and set(places) <= loopback, places
    # Ray requests a token by itself, and other Ray sessions of this process are unchanged.
    assert last == "token False"
