"""Writes an animated scene as a sequence in Spring's layout: pictures, disparities, disparities of the next and the
previous frame, optical flow both ways, and cameras.

    pip install h5py pillow
    python examples/spring.py animated.glb out --frames 10

Spring (Mehl et al., CVPR 2023) has ground truth of four points per pixel, in pixels of the picture. So the truth is
that of a picture of twice the size, halved. Sky and points behind an eye are NaN. The script reads its files back.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import h5py
import numpy as np
from PIL import Image

import stereotrace

EYES = ("left", "right")
BEHIND = 3
"""Class of points that have no place in the picture."""


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", help="glTF file; its first animation is played")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--fps", type=float, default=24)
    parser.add_argument("--size", type=int, nargs=2, default=(960, 540))
    given = parser.parse_args()
    renderer, sequence = stereotrace.Renderer(), given.folder / "train" / "0001"
    scene = stereotrace.Scene.open(given.scene)
    start = scene.camera(size=given.size)
    scene.place_lights(3, start)

    def at(number: int) -> tuple[stereotrace.Scene, stereotrace.Camera]:
        posed = scene.copy()
        posed.pose(number / given.fps)
        return posed, posed.camera(size=given.size).replace(
            screen_distance=np.inf, interaxial=start.interaxial
        )

    frames = [at(number) for number in range(given.frames)]
    for number, (now, camera) in enumerate(frames):
        picture = renderer.render(now, camera, samples=16, outputs=["color"])
        double = camera.replace(size=[2 * side for side in given.size])
        outputs = ["disparity", "depth", "primitive"]
        truth = renderer.render(now, double, samples=1, outputs=outputs)
        name = f"{number + 1:04}"
        for eye in EYES:
            path = file(sequence, f"frame_{eye}", f"frame_{eye}_{name}.png")
            Image.fromarray(getattr(picture, eye).color).save(path)
            view = getattr(truth, eye)
            disparity = np.where(np.isfinite(view.depth), view.disparity, np.nan) / 2
            write(file(sequence, f"disp1_{eye}", f"disp1_{eye}_{name}.dsp5"), "disparity", disparity)
        for way, other in (("FW", number + 1), ("BW", number - 1)):
            if not 0 <= other < given.frames:
                continue
            then, next_camera = frames[other]
            flow = renderer.flow(truth, now, then, next_camera.replace(size=double.size))
            for eye in EYES:
                view, of = getattr(truth, eye), getattr(flow, eye)
                known = np.isfinite(view.depth) & (of.visibility != BEHIND)
                next_disparity = np.where(known, view.disparity + of.disparity_change, np.nan) / 2
                end = f"{way}_{eye}"
                write(file(sequence, f"disp2_{end}", f"disp2_{end}_{name}.dsp5"), "disparity", next_disparity)
                moved = np.where(of.visibility[..., None] != BEHIND, of.flow, np.nan) / 2
                write(file(sequence, f"flow_{end}", f"flow_{end}_{name}.flo5"), "flow", moved)
    cameras = sequence / "cam_data"
    cameras.mkdir(exist_ok=True)
    pinholes = [[camera.intrinsics[name] for name in ("fx", "fy", "cx0", "cy")] for _, camera in frames]
    np.savetxt(cameras / "intrinsics.txt", pinholes)
    np.savetxt(cameras / "extrinsics.txt", [world_to_left(camera).ravel() for _, camera in frames])
    check(sequence, frames)


def file(sequence: Path, folder: str, name: str) -> Path:
    (sequence / folder).mkdir(parents=True, exist_ok=True)
    return sequence / folder / name


def write(path: Path, name: str, values: np.ndarray) -> None:
    """Writes an array as Spring does: one compressed HDF5 data set."""
    with h5py.File(path, "w") as there:
        there.create_dataset(name, data=values.astype(np.float32), compression="gzip", compression_opts=5)


def world_to_left(camera: stereotrace.Camera) -> np.ndarray:
    """Returns the 4x4 matrix from the world to the left eye's frame: x right, y down, z forward."""
    axes = np.array([camera.right, -np.array(camera.up), camera.forward])
    eye = np.array(camera.eye) - 0.5 * camera.interaxial * np.array(camera.right)
    return np.vstack([np.c_[axes, -axes @ eye], (0, 0, 0, 1)])


def check(sequence: Path, frames: list[tuple[stereotrace.Scene, stereotrace.Camera]]) -> None:
    """Reads the first flow back, and compares it with the cameras: points of static surfaces follow from depth."""
    with h5py.File(sequence / "flow_FW_left" / "flow_FW_left_0001.flo5") as there:
        flow = there["flow"][()]
    with h5py.File(sequence / "disp1_left" / "disp1_left_0001.dsp5") as there:
        disparity = there["disparity"][()]
    fx, fy, cx, cy = np.loadtxt(sequence / "cam_data" / "intrinsics.txt")[0]
    now, then = np.loadtxt(sequence / "cam_data" / "extrinsics.txt")[:2].reshape(2, 4, 4)
    rows, columns = (np.indices(disparity.shape) + 0.5) / 2
    depth = fx * frames[0][1].interaxial / disparity
    points = np.stack([(columns - cx) / fx * depth, (rows - cy) / fy * depth, depth, np.ones_like(depth)], axis=-1)
    x, y, z, _ = np.moveaxis(points @ (then @ np.linalg.inv(now)).T, -1, 0)
    apart = np.hypot(fx * x / z + cx - columns - flow[..., 0], fy * y / z + cy - rows - flow[..., 1])
    static = np.mean(apart[np.isfinite(apart)] < 1e-3)
    print(f"{len(frames)} frames; {100 * static:.1f}% of the first frame's surfaces move by the camera alone")


if __name__ == "__main__":
    main()
