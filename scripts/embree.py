#!/usr/bin/env python3
"""Traces with Embree the rays that the benchmark of rays traces, as a yardstick. Linux, Python 3, embreex and numpy.

    cargo bench --bench rays -- --dump DIR
    python3 scripts/embree.py DIR

DIR/SCENE/triangles.f32 has nine numbers a triangle, DIR/SCENE/KIND.QUERY.f32 eight a ray: origin, direction, t_min,
t_max. Kinds of QUERY `closest` are traced with embreex's query INTERSECT (hits are found in full, with normal and
barycentrics), those of `any` with OCCLUDED; both end at t_max. The scene is built once, not robust, in Embree's
default quality. Then one process a core, two in all, traces half of the rays each, in one call from a common barrier.
A round takes as long as the slower one; there is one round more, to warm up.

What to know before comparing:
- embreex (4.4.0) traces single rays, by rtcIntersect1 and rtcOccluded1. Embree's packets are not reached from it.
- It fixes the near end of rays at 0, so rays with t_min > 0 start at origin + t_min * direction and end at
  t_max - t_min. That is rounded to f32, so hits within about an ulp of either end may differ.
- embreex does not turn on the flushing of denormals, which Embree advises.
- Reading, moving and copying the rays and counting the hits is not timed. What remains in the time beside Embree: the
  one call from Python, the filling of Embree's ray from the arrays, and an array of four bytes a ray for the results.
"""

import argparse
import multiprocessing
import multiprocessing.connection
import os
import platform
import statistics
import sys
import time
from pathlib import Path

try:
    import numpy as np
    from embreex import __version__ as embreex_version
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore import EmbreeDevice
    from embreex.rtcore_scene import EmbreeScene
except ImportError as error:
    sys.exit(f"{error}: pip install embreex numpy")

QUERIES = {"closest": "INTERSECT", "any": "OCCLUDED"}
# As the benchmark has them; others follow by name.
KINDS = ["primary", "shadow", "length-limited", "interval", "scattered-10-"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, metavar="DIR", help="what the benchmark wrote with --dump")
    parser.add_argument("--rounds", type=int, default=5, help="timed rounds (default 5)")
    parser.add_argument("--cores", default="", help="numbers of the cores, as 0,2 (default: the first two allowed)")
    options = parser.parse_args()
    if options.rounds < 1:
        parser.error("--rounds must be 1 or more")
    try:
        allowed = sorted(os.sched_getaffinity(0))
        cores = [int(core) for core in options.cores.split(",")] if options.cores else allowed[:2]
        if not set(cores) <= set(allowed):
            raise ValueError(f"--cores {options.cores}: only {', '.join(map(str, allowed))} are allowed here")
        # Embree starts no threads of its own then, so processes can be forked after the scene is built, and share it.
        os.sched_setaffinity(0, cores[:1])
        scenes = [(folder, ray_files(folder)) for folder in scene_folders(options.folder)]
        device = EmbreeDevice()
        print(f"Embree {str(device).split()[-1]}, embreex {embreex_version}, numpy {np.__version__}")
        print(f"{cpu_model()}, cores {', '.join(map(str, cores))}, {options.rounds} rounds after one to warm up\n")
        print("| scene | rays | millions | Embree Mrays/s | min..max | hits % |\n|---|---|---|---|---|---|")
        for folder, files in scenes:
            scene = build(device, folder / "triangles.f32")
            for path in files:
                name, query, _ = path.name.rsplit(".", 2)
                rays = prepared(path)
                count = len(rays[0])
                seconds, hits = measure(scene, rays, QUERIES[query], cores, options.rounds)
                speeds = [count / 1e6 / second for second in seconds]
                print(
                    f"| {folder.name} | {name} | {count / 1e6:.2f} | {statistics.median(speeds):.2f} "
                    f"| {min(speeds):.2f}..{max(speeds):.2f} | {100 * hits / count:.3f} |",
                    flush=True,
                )
    except (OSError, ValueError, RuntimeError) as error:
        sys.exit(f"error: {error}")


def scene_folders(folder):
    folders = sorted(path for path in folder.iterdir() if path.is_dir())
    if not folders:
        raise ValueError(f"{folder}: no folders of scenes in it")
    return folders


def ray_files(folder):
    """The files of rays of a scene. All sizes are checked before anything is traced."""
    files = [path for path in folder.glob("*.f32") if path.name != "triangles.f32"]
    check_size(folder / "triangles.f32", 36)
    if not files:
        raise ValueError(f"{folder}: no files KIND.QUERY.f32 in it")
    for path in files:
        if path.name.split(".")[-2] not in QUERIES:
            raise ValueError(f"{path}: the name must end in .closest.f32 or .any.f32")
        check_size(path, 32)
    order = {kind: place for place, kind in enumerate(KINDS)}
    return sorted(files, key=lambda path: (order.get(path.name.rsplit(".", 2)[0], len(order)), path.name))


def check_size(path, item):
    size = path.stat().st_size
    if size == 0 or size % item:
        raise ValueError(f"{path}: {size} bytes, which is not a multiple of {item} above 0")


def build(device, path):
    scene = EmbreeScene(device, robust=False)
    TriangleMesh(scene, np.fromfile(path, "<f4").astype(np.float32, copy=False).reshape(-1, 3, 3))
    # The first call builds the tree.
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))
    return scene


def prepared(path):
    """Origins, directions and limits as embreex takes them, with t_min moved into the origins."""
    rays = np.fromfile(path, "<f4").astype(np.float32, copy=False).reshape(-1, 8)
    origins, directions = rays[:, 0:3].copy(), rays[:, 3:6].copy()
    t_min, t_max = rays[:, 6].astype(np.float64), rays[:, 7].astype(np.float64)
    moved = t_min != 0
    starts = origins[moved] + t_min[moved, None] * directions[moved]
    # Embree takes coordinates of up to 1.8e18; a ray that starts so far out misses everything.
    origins[moved] = np.clip(starts, -1e18, 1e18)
    # A limit below 0 would read as occluded.
    limits = np.maximum(t_max - t_min, 0).astype(np.float32)
    return origins, directions, limits


def measure(scene, rays, query, cores, rounds):
    """Seconds of the slowest process in each round, and how many rays hit."""
    context = multiprocessing.get_context("fork")
    barrier = context.Barrier(len(cores))
    ends = [len(rays[0]) * place // len(cores) for place in range(len(cores) + 1)]
    receivers, results = [], []
    for place, core in enumerate(cores):
        part = [array[ends[place] : ends[place + 1]] for array in rays]
        receiver, sender = context.Pipe(duplex=False)
        arguments = (scene, part, query, core, rounds, barrier, sender)
        context.Process(target=trace, args=arguments, daemon=True).start()
        sender.close()
        receivers.append(receiver)
    while receivers:
        for receiver in multiprocessing.connection.wait(receivers):
            receivers.remove(receiver)
            try:
                results.append(receiver.recv())
            except EOFError:
                raise RuntimeError("a process that traced rays ended early") from None
    return [max(times) for times in zip(*(times for times, _ in results))], sum(hits for _, hits in results)


def trace(scene, rays, query, core, rounds, barrier, sender):
    os.sched_setaffinity(0, [core])
    origins, directions, limits = rays
    times = []
    for _ in range(rounds + 1):
        barrier.wait()
        start = time.perf_counter()
        found = scene.run(origins, directions, dists=limits, query=query)
        times.append(time.perf_counter() - start)
    sender.send((times[1:], int(np.count_nonzero(found != -1))))


def cpu_model():
    for line in Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


if __name__ == "__main__":
    main()
