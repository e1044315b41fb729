"""Compares the first hits of an equirectangular stereo pair with those that Embree finds, pixel by pixel.

Run it with a Python that has embreex, numpy and trimesh from PyPI, and this project's package:

    python scripts/beside_embree.py model.obj --eye 0,1.5,1

The rays of both eyes are computed here in double precision, from the formulas of docs/DESIGN.md, section 2. Embree
traces them in f32, with the option for watertight intersections. Triangles are those that trimesh reads.
"""

import argparse
import math

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

import stereotrace as st

MISS = 0xFFFFFFFF


def rays(size, degrees: int, merge, interaxial: float, side: int):
    """Returns the origins, relative to the camera's eye, and the directions of a view that looks along -z.

    Directions have the horizontal length 1, so the distance along a ray is the horizontal distance ``s``.
    """
    width, height = size
    azimuth = ((np.arange(width) + 0.5) / width * 2 - 1) * math.radians(degrees) / 2
    elevation = (0.5 - (np.arange(height) + 0.5) / height) * math.pi
    radius = np.full(height, 0.5 * interaxial * side)
    if merge:
        share = np.clip((np.abs(np.degrees(elevation)) - merge[0]) / (merge[1] - merge[0]), 0, 1)
        radius *= np.cos(share * math.pi / 2)
    a, p = np.meshgrid(azimuth, elevation)
    nothing = np.zeros_like(a)
    origins = radius[:, None, None] * np.stack([np.cos(a), nothing, np.sin(a)], axis=-1)
    return origins, np.stack([np.sin(a), np.tan(p), -np.cos(a)], axis=-1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("model")
    parser.add_argument("--eye", default="0,0,0", type=lambda text: [float(number) for number in text.split(",")])
    parser.add_argument("--interaxial", default=0.3, type=float)
    parser.add_argument("--height", default=512, type=int)
    parser.add_argument("--method", default="bracket")
    options = parser.parse_args()
    mesh = trimesh.load(options.model, process=False, force="mesh")
    vertices, faces = np.asarray(mesh.vertices, np.float32), np.asarray(mesh.faces, np.uint32)
    scene = st.Scene()
    scene.add_mesh(vertices, faces)
    embree = EmbreeScene(robust=True)
    TriangleMesh(embree, vertices[faces])
    renderer = st.Renderer()
    eye = np.array(options.eye)
    print(f"{len(faces)} triangles, eye {options.eye}, interaxial {options.interaxial}, {renderer.adapter}")
    for degrees in (360, 180):
        for merge in ((60, 75), None):
            size = (options.height * degrees // 180, options.height)
            camera = st.Camera(
                options.eye, eye - [0, 0, 1], size=size, projection=degrees, pole_merge=merge,
                interaxial=options.interaxial,
            )
            pair = renderer.render(scene, camera, method=options.method, outputs=["depth", "primitive"])
            for name, view, side in (("left", pair.left, -1), ("right", pair.right, 1)):
                origins, directions = rays(size, degrees, merge, options.interaxial, side)
                length = np.linalg.norm(directions, axis=-1)
                found = embree.run(
                    np.ascontiguousarray((origins + eye).reshape(-1, 3), np.float32),
                    np.ascontiguousarray((directions / length[..., None]).reshape(-1, 3), np.float32),
                    output=True,
                )
                theirs = found["primID"].reshape(length.shape)
                distance = found["tfar"].reshape(length.shape) / length
                ours, depth = view.primitive, view.depth.astype(np.float64)
                hit, their_hit = ours != MISS, theirs >= 0
                both = hit & their_hit
                off = np.abs(depth - distance)[both] / distance[both]
                # At edges of triangles rounding decides which of two is hit, mostly at one distance.
                other = ((ours != theirs) & both)[both]
                print(
                    f"{degrees} merge {merge} {name}: {100 * hit.mean():.1f}% hits; hits or misses differ in {100 * (hit != their_hit).mean():.4f}% "
                    f"of the pixels, surfaces in {100 * (off > 1e-3).mean():.4f}% and triangles in "
                    f"{100 * other.mean():.4f}% of the hits; distances by {np.median(off):.1e} (median), "
                    f"{np.percentile(off, 99.9):.1e} (99.9%)"
                )


if __name__ == "__main__":
    main()
