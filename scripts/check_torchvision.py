#!/usr/bin/env python3
"""Makes a small data set in each layout, loads it by torchvision's own classes, and compares what they return with the
truth.

    scripts/check_torchvision.py [--command target/release/stereotrace]

Needs the packages stereotrace[dataset], torch and torchvision, some GB: it is no part of CI. The truth is worked out
here in double precision, from depths and the camera: fx * baseline / Z - doffs. With --command, data sets of the Rust
command are loaded too. Ends with status 1 where anything differs.

Optical flow of KITTI's and Sintel's layouts is compared with Renderer.flow, in the same way.

torchvision wants its own folders' names, which links give. Of KITTI it wants disp_occ_1 for the right view's
disparities; in KITTI's own files that is the second frame's disparity, and the layout has none, so that the link leads
to disp_occ_0 and is not compared.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import torchvision
from torchvision.datasets import (
    Kitti2015Stereo,
    KittiFlow,
    Middlebury2014Stereo,
    SceneFlowStereo,
    Sintel,
    SintelStereo,
)

import stereotrace
from stereotrace import dataset

SIZE = (160, 120)
PAIRS = 3
FAULTS: list[str] = []
COUNT = 0


def check(what: str, good: object, found: object = "") -> None:
    global COUNT
    COUNT += 1
    if not good:
        FAULTS.append(f"{what}: {found}")


def truth(pair: stereotrace.StereoPair, eye: str) -> tuple[np.ndarray, np.ndarray]:
    """Disparities in double precision, and where there are surfaces."""
    camera = pair.camera
    lens, depth = camera.intrinsics, getattr(pair, eye).depth.astype(np.float64)
    disparity = lens["fx"] * camera.interaxial / depth - (lens["cx1"] - lens["cx0"])
    return disparity, np.isfinite(depth)


class Keep:
    """A transform that changes nothing, and keeps what the loader read of both views: a sample has the left one's
    disparity alone."""

    def __call__(self, *read: tuple) -> tuple:
        self.read = read
        return read


def loaded(layout: str, root: Path, folders: list[Path], keep: Keep) -> object:
    """torchvision's data set of these folders of ours."""
    if layout == "middlebury":
        # Its folders begin with the names of Middlebury's scenes, and are sorted.
        train = root / "Middlebury2014" / "train"
        train.mkdir(parents=True)
        for number, pair in enumerate(sorted(pair for folder in folders for pair in folder.glob("[0-9]*"))):
            (train / f"Adirondack{number:06d}-perfect").symlink_to(pair)
        return Middlebury2014Stereo(str(root), transforms=keep)
    (folder,) = folders
    if layout == "kitti":
        (root / "Kitti2015").mkdir()
        (root / "Kitti2015" / "training").mkdir()
        for inner in (folder / "training").iterdir():
            (root / "Kitti2015" / "training" / inner.name).symlink_to(inner)
        (root / "Kitti2015" / "training" / "disp_occ_1").symlink_to(folder / "training" / "disp_occ_0")
        return Kitti2015Stereo(str(root), transforms=keep)
    if layout == "sintel":
        (root / "Sintel").symlink_to(folder)
        return SintelStereo(str(root), pass_name="final", transforms=keep)
    (root / "SceneFlow").mkdir()
    (root / "SceneFlow" / "Monkaa").symlink_to(folder)
    return SceneFlowStereo(str(root), variant="Monkaa", pass_name="final", transforms=keep)


def check_sample(name: str, layout: str, sample: tuple, read: tuple, pair: stereotrace.StereoPair) -> None:
    (left, right), disparities, masks = read
    check(
        f"{name}: the sample is what was read", sample[0] is left and sample[1] is right and sample[2] is disparities[0]
    )
    for eye, picture in (("left", left), ("right", right)):
        check(f"{name}: {eye} picture", np.array_equal(np.asarray(picture)[..., :3], getattr(pair, eye).color))
    eyes = ("left",) if layout in ("kitti", "sintel") else ("left", "right")
    for eye, found, mask in zip(eyes, disparities, masks):
        found = np.asarray(found, np.float64)[0]
        expected, surface = truth(pair, eye)
        check(f"{name}: {eye} has surfaces of disparity above 0", surface.any() and (expected[surface] > 0).all())
        # KITTI's files have 256 steps a pixel, the others the float32 nearest to the exact value.
        most = 0.5 / 256 + 1e-4 if layout == "kitti" else 1e-4
        off = np.abs(found - expected)[surface].max()
        check(f"{name}: {eye} disparity of surfaces", off <= most, off)
        check(f"{name}: {eye} sky is 0", not found[~surface].any(), found[~surface].max(initial=0))
        if layout == "sintel":
            seen = getattr(pair, eye).occlusion == 0
            check(f"{name}: {eye} mask is where both eyes see", np.array_equal(np.asarray(mask), seen))
        elif mask is not None:
            check(f"{name}: {eye} mask is where surfaces are", np.array_equal(np.asarray(mask), surface))
        if layout == "kitti":
            check(f"{name}: what is not 0 is where surfaces are", np.array_equal(found > 0, surface))
    # The sign: carried by its disparities the right picture is the left one, where both eyes see a point.
    columns = np.arange(SIZE[0])[None, :] - np.rint(np.asarray(disparities[0])[0]).astype(int)
    rows = np.arange(SIZE[1])[:, None]
    seen = (pair.left.occlusion == 0) & (columns >= 0)
    carried = np.asarray(right)[rows, np.clip(columns, 0, SIZE[0] - 1), :3]
    median = np.median(np.abs(carried.astype(int) - np.asarray(left)[..., :3]).mean(axis=-1)[seen])
    check(
        f"{name}: the right picture is carried to the left one",
        seen.mean() > 0.3 and median <= 4,
        (seen.mean(), median),
    )


def check_layout(name: str, layout: str, folders: list[Path], pairs: list[stereotrace.StereoPair]) -> None:
    before, faults = COUNT, len(FAULTS)
    with tempfile.TemporaryDirectory() as root:
        keep = Keep()
        data = loaded(layout, Path(root), folders, keep)
        check(f"{name}: number of pairs", len(data) == len(pairs), len(data))
        for number, pair in enumerate(pairs):
            sample = data[number]
            check_sample(f"{name}, pair {number}", layout, sample, keep.read, pair)
        surfaces = [truth(pair, "left") for pair in pairs]
        least = min(expected[surface].min() for expected, surface in surfaces)
        most = max(expected[surface].max() for expected, surface in surfaces)
        sky = np.mean([~surface for _, surface in surfaces])
    kind = type(data).__name__
    print(
        f"{name}: {kind}: {len(data)} pairs, disparities {least:.3f} to {most:.3f} px, sky {sky:.1%}: {COUNT - before} checks, {len(FAULTS) - faults} failed"
    )


def check_flow(layout: str, kind: type, **options: str) -> None:
    """Compares optical flow that torchvision reads with that of the pairs."""
    before, faults = COUNT, len(FAULTS)
    spec = dataset.Spec.load(
        {
            "pairs": PAIRS,
            "size": SIZE,
            "format": layout,
            "scenes": [{"builtin": "hall"}],
            "motion": {"camera": {"right": 0.05, "turn": 1}, "objects": {"share": 0.5, "distance": 0.05}},
        }
    )
    with tempfile.TemporaryDirectory() as out, tempfile.TemporaryDirectory() as root:
        report = dataset.make(spec, out)
        check(f"flow of {layout} is made", report.pairs == PAIRS, report.summary())
        (Path(root) / kind.__name__).symlink_to(out)
        data, worker = kind(root, **options), dataset.Worker(spec)
        check(f"flow of {layout}: number of pairs", len(data) == PAIRS, len(data))
        for number in range(PAIRS):
            first, second, flow, *valid = data[number]
            # Sintel's sequences come in the order of the folder's entries.
            path = Path(data._image_list[number][0])
            item = int(path.parent.name if layout == "sintel" else path.name.partition("_")[0])
            pair, _ = worker.pair(item)
            following, forward, _ = pair.motion
            name = f"flow of {layout}, pair {item}"
            check(f"{name}: first picture", np.array_equal(np.asarray(first)[..., :3], pair.left.color))
            check(f"{name}: second picture", np.array_equal(np.asarray(second)[..., :3], following.left.color))
            known = np.asarray(valid[0]) if valid else np.isfinite(forward.left.flow[..., 0])
            check(f"{name}: has valid pixels", known.mean() > 0.5, known.mean())
            off = np.abs(np.moveaxis(np.asarray(flow), 0, -1) - forward.left.flow)[known].max()
            check(f"{name}: flow", off <= (0.5 / 64 + 1e-5 if layout == "kitti" else 0), off)
    print(f"flow of {layout}: {kind.__name__}: {COUNT - before} checks, {len(FAULTS) - faults} failed")


def main() -> None:
    given = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    given.add_argument("--command", help="the Rust command, whose data sets are loaded too")
    command = given.parse_args().command
    os.environ.setdefault("STEREOTRACE_ADAPTER", "software")
    print(f"torchvision {torchvision.__version__}, stereotrace {stereotrace.__version__}")
    scenes = [("hall-finished", {"kind": "free"}), ("spheres", {"kind": "orbit"})]
    check_flow("kitti", KittiFlow)
    check_flow("sintel", Sintel, pass_name="final")
    for layout in ("middlebury", "kitti", "sceneflow", "sintel"):
        for scene, poses in scenes:
            with tempfile.TemporaryDirectory() as out:
                values = {
                    "pairs": PAIRS,
                    "shard_pairs": 2 if layout != "sceneflow" else PAIRS,
                    "size": SIZE,
                    "format": layout,
                    "poses": poses,
                }
                spec = dataset.Spec.load({**values, "scenes": [{"builtin": scene}]})
                report = dataset.make(spec, out)
                check(f"{layout} of {scene} is made", report.pairs == PAIRS, report.summary())
                # The same pairs, with depths for the truth.
                with_depth = {"format": "webdataset", "outputs": ["color", "depth", "disparity", "occlusion"]}
                again = {**values, **with_depth, "rig": {"screen_distance": "inf"}}
                worker = dataset.Worker(dataset.Spec.load({**again, "scenes": [{"builtin": scene}]}))
                pairs = [worker.pair(number)[0] for number in range(PAIRS)]
                folders = (
                    [Path(out)]
                    if layout in ("kitti", "sintel")
                    else sorted(path for path in Path(out).iterdir() if path.is_dir())
                )
                check_layout(f"Python, {layout}, {scene}", layout, folders, pairs)
        if command:
            renderer, hall = stereotrace.Renderer(), stereotrace.Scene.builtin("hall-finished")
            camera = hall.camera(size=SIZE).replace(screen_distance=float("inf"))
            with tempfile.TemporaryDirectory() as out:
                arguments = [
                    "dataset",
                    "builtin:hall-finished",
                    "--size",
                    f"{SIZE[0]}x{SIZE[1]}",
                    "--pairs",
                    PAIRS,
                    "--layout",
                    layout,
                    "--out",
                    out,
                ]
                subprocess.run([command, *map(str, arguments)], check=True, capture_output=True)
                places = [
                    renderer.free_camera(hall, camera, 0, item, max_disparity=0.2 * SIZE[0])[0] for item in range(PAIRS)
                ]
                outputs = ["color", "depth", "occlusion"]
                pairs = [renderer.render(hall, place, outputs=outputs, seed=item) for item, place in enumerate(places)]
                check_layout(f"command, {layout}, hall-finished", layout, [Path(out)], pairs)
    for fault in FAULTS:
        print(f"WRONG {fault}", file=sys.stderr)
    print(f"{COUNT} checks, {len(FAULTS)} failed")
    sys.exit(1 if FAULTS else 0)


if __name__ == "__main__":
    main()
