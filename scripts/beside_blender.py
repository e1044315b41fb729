"""Compares an equirectangular stereo pair of stereotrace with Blender's spherical stereo, pixel by pixel.

Run it with a Python that has bpy, numpy and OpenEXR from PyPI:

    python scripts/beside_blender.py model.glb FOLDER --command target/release/stereotrace --eye 0,1.5,1

Cycles writes the position of each pixel's first hit, with the eyes merging between 60 and 75 degrees. The position that
stereotrace sees is computed here in double precision from its depths. Differences are printed in columns of the picture:
the distance of both positions over that of the eye, over the angle of a column.
"""

import argparse
import math
import subprocess
from pathlib import Path

import numpy as np

WIDTH, HEIGHT = 1024, 512
MERGE = (60, 75)


def render_by_blender(model: Path, folder: Path, eye, interaxial: float) -> None:
    """Writes blender_L.exr and blender_R.exr."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(model))
    camera = bpy.data.cameras.new("all around")
    place = bpy.data.objects.new("all around", camera)
    scene = bpy.context.scene
    scene.collection.objects.link(place)
    scene.camera = place
    # Blender's z is up. The camera looks along glTF's -z.
    place.location = (eye[0], -eye[2], eye[1])
    place.rotation_euler = (math.pi / 2, 0, 0)
    camera.type, camera.panorama_type, camera.clip_start = "PANO", "EQUIRECTANGULAR", 1e-6
    stereo = camera.stereo
    stereo.convergence_mode, stereo.interocular_distance = "PARALLEL", interaxial
    stereo.use_spherical_stereo = stereo.use_pole_merge = True
    stereo.pole_merge_angle_from, stereo.pole_merge_angle_to = map(math.radians, MERGE)
    render = scene.render
    render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 1, False, False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01  # rays through the pixels' centres
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    render.use_multiview, render.views_format = True, "STEREO_3D"
    image = render.image_settings
    image.views_format, image.file_format, image.color_depth = "INDIVIDUAL", "OPEN_EXR_MULTILAYER", "32"
    layer = scene.view_layers[0]
    layer.use_pass_position = layer.use_pass_z = True
    for material in bpy.data.materials:  # stereotrace's first hits include clear surfaces
        for node in material.node_tree.nodes if material.use_nodes else []:
            if node.type == "BSDF_PRINCIPLED":
                for link in list(node.inputs["Alpha"].links):
                    material.node_tree.links.remove(link)
                node.inputs["Alpha"].default_value = 1
    render.filepath = str(folder / "blender")
    bpy.ops.render.render(write_still=True)


def read_pfm(path: Path) -> np.ndarray:
    with path.open("rb") as file:
        assert file.readline().strip() == b"Pf"
        width, height = map(int, file.readline().split())
        file.readline()
        return np.frombuffer(file.read(), "<f4").reshape(height, width)[::-1].astype(np.float64)


def positions(depth: np.ndarray, eye, interaxial: float, side: int) -> np.ndarray:
    """Returns the positions at horizontal distances along the rays of an eye (docs/DESIGN.md, section 2)."""
    azimuth = ((np.arange(WIDTH) + 0.5) / WIDTH * 2 - 1) * math.pi
    elevation = (0.5 - (np.arange(HEIGHT) + 0.5) / HEIGHT) * math.pi
    share = np.clip((np.abs(np.degrees(elevation)) - MERGE[0]) / (MERGE[1] - MERGE[0]), 0, 1)
    radius = 0.5 * interaxial * np.cos(share * math.pi / 2) * side
    a, p = np.meshgrid(azimuth, elevation)
    right, up, ahead = np.array([1, 0, 0]), np.array([0, 1, 0]), np.array([0, 0, -1])
    aside = np.cos(a)[..., None] * right - np.sin(a)[..., None] * ahead
    along = np.sin(a)[..., None] * right + np.cos(a)[..., None] * ahead + np.tan(p)[..., None] * up
    return np.array(eye) + radius[:, None, None] * aside + depth[..., None] * along


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--command", type=Path, default=Path("stereotrace"))
    parser.add_argument("--eye", default="0,0,0", type=lambda text: [float(number) for number in text.split(",")])
    parser.add_argument("--interaxial", default=0.3, type=float)
    options = parser.parse_args()
    folder, eye = options.folder, options.eye
    folder.mkdir(parents=True, exist_ok=True)
    target = [eye[0], eye[1], eye[2] - 1]
    command = [options.command, "render", options.model, "--plain", "--lights", "1", "--projection", "360"]
    command += ["--size", f"{WIDTH}x{HEIGHT}", "--interaxial", str(options.interaxial), "--method", "bracket"]
    command += ["--eye=" + ",".join(map(str, eye)), "--target=" + ",".join(map(str, target))]
    subprocess.run([*command, "--ground-truth", "--out", folder], check=True, stdout=subprocess.DEVNULL)
    render_by_blender(options.model, folder, eye, options.interaxial)

    import OpenEXR

    for index, (name, side) in enumerate((("L", -1), ("R", 1))):
        with OpenEXR.File(str(folder / f"blender_{name}.exr")) as file:
            channels = file.parts[0].channels
            xyz = [channels[key].pixels for key in sorted(channels) if "Position" in key]
            depth = next(channels[key].pixels for key in channels if "Depth" in key)
        theirs = np.stack([xyz[0], xyz[2], -xyz[1]], axis=-1).astype(np.float64)
        found = read_pfm(folder / f"depth_z{index}.pfm")
        ours = positions(found, eye, options.interaxial, side)
        hits, their_hits = np.isfinite(found), depth < 1e9
        both = hits & their_hits
        away = np.linalg.norm(theirs - np.array(eye), axis=-1)
        off = (np.linalg.norm(ours - theirs, axis=-1) / (away * 2 * math.pi / WIDTH))[both]
        print(
            f"{name}: sky agrees in {100 * (hits == their_hits).mean():.4f}% of the pixels; hits are within half a column"
            f" in {100 * (off < 0.5).mean():.4f}%, off by {np.median(off):.4f} columns (median),"
            f" {np.percentile(off, 99.9):.4f} (99.9%)"
        )


if __name__ == "__main__":
    main()
