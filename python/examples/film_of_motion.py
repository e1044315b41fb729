"""Renders a film of moving objects with its ground truth: the left picture, disparity, optical flow and its classes.

    pip install pillow
    python examples/film_of_motion.py scenes/still_life.obj motion.webp

Each frame shows, from the top left: the left picture; disparity, near points red; optical flow to the next frame, with
the hue of its direction; and whether the next frame shows the point (blue), hides it (red) or has it outside (yellow).
"""

from __future__ import annotations

import argparse

import numpy as np
from PIL import Image

import stereotrace
from stereotrace.dataset import sheet

FRAMES = 36
SIZE = (240, 180)
ROLLING = {"apple_1": (2.0, 1.6), "lemon_1": (-1.6, 2.2), "plum_1": (0.6, 2.8)}
"""Objects that hop out of the bowl, and the way that each one goes: x and z in decimetres."""
TURNING = ("cube", "octahedron")


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("scene", help="the still life")
    parser.add_argument("film", help="WebP file to write")
    given = parser.parse_args()
    scene, renderer = stereotrace.Scene.open(given.scene), stereotrace.Renderer()
    objects = {scene.object_name(number): number for number in range(scene.object_count)}
    start = scene.camera(size=SIZE)
    way = np.subtract(start.target, start.eye)
    start = start.replace(eye=start.target - 0.62 * way, screen_distance=np.inf, interaxial=0.02 * np.linalg.norm(way))
    scene.add_plane((0, scene.bounds[0][1], 0), (0, 1, 0), scene.add_material(stereotrace.Material((0.5, 0.55, 0.5))))
    scene.set_sky((0.5, 0.65, 0.85))
    scene.place_lights(3, start)
    middles = {name: middle_of(scene, objects[name]) for name in (*ROLLING, *TURNING)}

    def at(frame: int) -> tuple[stereotrace.Scene, stereotrace.Camera]:
        there, time = scene.copy(), frame / FRAMES
        for name, (x, z) in ROLLING.items():
            # It goes and comes back: hops, and rolls about the axis across its way.
            share = 0.5 - 0.5 * np.cos(2 * np.pi * time)
            step = np.array([x * share, 1.2 * abs(np.sin(4 * np.pi * time)) * share**0.5, z * share])
            there.transform_object(objects[name], turned(middles[name], (z, 0, -x), 4 * np.pi * share, step))
        for name in TURNING:
            there.transform_object(objects[name], turned(middles[name], (0, 1, 0), 2 * np.pi * time, np.zeros(3)))
        return there, start.orbited(12 * np.sin(2 * np.pi * time))

    pictures = []
    (now, camera), options = at(0), {"samples": 16, "outputs": ["color", "disparity", "depth", "primitive"]}
    for frame in range(FRAMES):
        pair = renderer.render(now, camera, **options)
        then, next_camera = at(frame + 1)
        flow = renderer.flow(pair, now, then, next_camera).left
        left = pair.left
        parts = [left.color, sheet.colors_of_values(left.disparity, (2, 16))]
        parts += [sheet.colors_of_flow(flow.flow, 8), sheet.colors_of_classes(flow.visibility)]
        pictures.append(Image.fromarray(np.vstack([np.hstack(parts[:2]), np.hstack(parts[2:])])))
        now, camera = then, next_camera
    pictures[0].save(given.film, save_all=True, append_images=pictures[1:], duration=80, loop=0, quality=50, method=6)


def middle_of(scene: stereotrace.Scene, number: int) -> np.ndarray:
    """Returns the middle of an object's bounds."""
    corners = scene.triangles[[scene.object_of(index) == number for index in range(scene.triangle_count)]]
    return 0.5 * (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1)))


def turned(middle: np.ndarray, axis: tuple[float, float, float], angle: float, step: np.ndarray) -> np.ndarray:
    """Returns the 4x4 matrix of a turn about an axis through a point, and then of a step (Rodrigues' formula)."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return np.vstack([np.c_[matrix, middle - matrix @ middle + step], (0, 0, 0, 1)])


if __name__ == "__main__":
    main()
