"""Compares a light that projects a picture with Mitsuba 3's projector: the same box, walls, camera and picture.

Run it with a Python that has mitsuba and numpy from PyPI, and this project's package:

    python scripts/beside_mitsuba_projector.py --samples 1024

Mitsuba's projector has a constant irradiance on planes across its direction, so its light is `1 / cos³` of ours with
quadratic falloff. Its pictures are divided by that factor. Pixels at edges are left out, where samples differ.
"""

import argparse
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

import stereotrace as st

SIDE, FOV = 128, 40.0
EYE, TARGET = (0.5, 1.6, 5.0), (0.1, 0.8, 0.0)
PLACE, DIRECTION, UP, ANGLE = np.array((-1.2, 1.5, 3.5)), np.array((1.1, -0.6, -3.0)), (0.3, 1.0, 0.1), 0.7
ALBEDO = (0.7, 0.6, 0.5)
PICTURE = np.random.default_rng(1).integers(0, 256, (5, 8, 3)).astype(np.uint8)


def quads():
    """Returns the floor, the wall and the sides of a box."""
    (a, b, c), (d, e, f) = (-0.3, 0.0, 0.2), (0.5, 0.9, 0.9)
    sides = [
        [(-9, 0, -1), (-9, 0, 9), (9, 0, 9), (9, 0, -1)], [(-9, 0, -1), (9, 0, -1), (9, 9, -1), (-9, 9, -1)],
        [(a, b, f), (d, b, f), (d, e, f), (a, e, f)], [(d, b, c), (a, b, c), (a, e, c), (d, e, c)],
        [(a, b, c), (a, b, f), (a, e, f), (a, e, c)], [(d, b, f), (d, b, c), (d, e, c), (d, e, f)],
        [(a, e, f), (d, e, f), (d, e, c), (a, e, c)],
    ]
    return [np.array(side, np.float32) for side in sides]


def by_stereotrace():
    """Returns the linear picture, and the world position of each pixel."""
    scene = st.Scene()
    scene.set_sky((0, 0, 0))
    scene.ambient = 0
    grey = scene.add_material(st.Material(ALBEDO))
    for corners in quads():
        scene.add_mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), material=grey)
    lamp = st.Light.point(PLACE, 10.0).with_quadratic_falloff()
    scene.lights = [lamp.with_projector(scene.add_texture(PICTURE, data=True), DIRECTION, UP, ANGLE)]
    camera = st.Camera(EYE, TARGET, size=(SIDE, SIDE), fov=FOV, interaxial=0.0)
    seen = st.Renderer().render(scene, camera, method="naive", outputs=["linear", "depth"], samples=64).left
    across = np.tan(np.radians(FOV) / 2) * (2 * (np.arange(SIDE) + 0.5) / SIDE - 1)
    rays = np.array(camera.forward) + across[:, None] * np.array(camera.right)
    rays = rays[None] - across[:, None, None] * np.array(camera.up)
    return seen.linear[..., :3], np.array(EYE) + seen.depth[..., None] * rays


def by_mitsuba(samples):
    transform = mi.ScalarTransform4f()
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    colors = mi.Bitmap(np.float32(PICTURE) / 255)
    picture = {"type": "bitmap", "bitmap": colors, "raw": True, "filter_type": "bilinear", "wrap_mode": "clamp"}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {
            "type": "perspective", "fov": FOV, "film": film,
            "to_world": transform.look_at(origin=EYE, target=TARGET, up=(0, 1, 0)),
            "sampler": {"type": "multijitter", "sample_count": samples},
        },
        "projector": {
            "type": "projector", "irradiance": picture, "fov": float(np.degrees(ANGLE)), "fov_axis": "x",
            "to_world": transform.look_at(origin=PLACE.tolist(), target=(PLACE + DIRECTION).tolist(), up=UP),
            "scale": 10.0,
        },
    }
    bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": ALBEDO}}}
    with tempfile.TemporaryDirectory() as folder:
        for index, corners in enumerate(quads()):
            mesh = mi.Mesh("quad", 4, 2)
            parts = mi.traverse(mesh)
            parts["vertex_positions"] = corners.ravel()
            parts["faces"] = np.array((0, 1, 2, 0, 2, 3), np.uint32)
            parts.update()
            file = str(Path(folder) / f"{index}.ply")
            mesh.write_ply(file)
            scene[f"mesh{index}"] = {"type": "ply", "filename": file, "face_normals": True, "bsdf": bsdf}
        return np.array(mi.render(mi.load_dict(scene)))[..., :3]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=1024, help="samples per pixel by Mitsuba")
    samples = parser.parse_args().samples
    mi.set_variant("scalar_rgb")
    ours, points = by_stereotrace()
    theirs = by_mitsuba(samples)
    ways = points - PLACE
    cosines = (ways @ DIRECTION) / np.linalg.norm(DIRECTION) / np.linalg.norm(ways, axis=-1)
    theirs *= np.maximum(cosines, 0)[..., None] ** 3
    # Away from edges both pictures vary little from pixel to pixel.
    steps = [np.abs(theirs - np.roll(theirs, shift, axis)) for axis in (0, 1) for shift in (-1, 1)]
    lit = (theirs.min(-1) > 0.05 * theirs.max()) & (np.max(steps, axis=(0, -1)) < 0.2 * theirs.min(-1))
    relative = np.abs(ours / np.maximum(theirs, 1e-9) - 1).max(-1)[lit]
    print(f"{lit.sum()} pixels: mean difference {relative.mean():.3%}, largest {relative.max():.3%}")
    print(f"mean of all pixels {ours.mean():.5f}, by Mitsuba {theirs.mean():.5f}: {ours.mean() / theirs.mean() - 1:+.3%}")


if __name__ == "__main__":
    main()
