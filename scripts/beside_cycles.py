"""Renders a room by Cycles and by stereotrace, and compares both eyes: light, noise and CPU time.

Run it with a Python that has bpy, numpy and OpenEXR from PyPI:

    python scripts/beside_cycles.py FOLDER --command target/release/stereotrace

It makes the room in Blender and exports it as glTF. Both programs then render a pair, with an off-axis frustum for each
eye: Cycles with 32 samples and its denoiser, stereotrace with several numbers of samples and paths, denoised. The
converged pictures of each program, and of each filter of stereotrace, are rendered twice, with other random numbers. An
error is the root of the mean product of the differences from both, so it leaves out their noise. Values are sRGB, 0 to
1. CPU seconds include the programs' start.
"""

import argparse
import json
import math
import os
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np

SKY = (0.9, 1.125, 1.5)
BOUNCES = 6
EYES = ("left", "right")


def make_room(folder: Path, size) -> None:
    """Makes the room in Blender: wood, bricks with a normal map, fabric, gold, steel, glass, lamps and a window."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = size  # the exported field of view depends on them

    def picture(name, pixels, space="sRGB"):
        height, width, _ = pixels.shape
        image = bpy.data.images.new(name, width, height)
        image.colorspace_settings.name = space
        rgba = np.ones((height, width, 4), np.float32)
        rgba[..., :3] = pixels
        image.pixels.foreach_set(rgba.ravel())
        image.pack()
        return image

    def material(name, color=(0.8, 0.8, 0.8), texture=None, bumps=None, **inputs):
        made = bpy.data.materials.new(name)
        made.use_nodes = True
        nodes, links = made.node_tree.nodes, made.node_tree.links
        surface = nodes["Principled BSDF"]
        surface.inputs["Base Color"].default_value = (*color, 1.0)
        for key, value in inputs.items():
            surface.inputs[key.replace("_", " ")].default_value = value
        if texture:
            node = nodes.new("ShaderNodeTexImage")
            node.image = texture
            links.new(node.outputs["Color"], surface.inputs["Base Color"])
        if bumps:
            node, normal = nodes.new("ShaderNodeTexImage"), nodes.new("ShaderNodeNormalMap")
            node.image = bumps
            links.new(node.outputs["Color"], normal.inputs["Color"])
            links.new(normal.outputs["Normal"], surface.inputs["Normal"])
        return made

    random = np.random.default_rng(3)
    x, y = np.meshgrid(np.arange(512), np.arange(512))
    plank = (y // 64) % 8
    shade = random.uniform(0.5, 1, 8)[plank]
    grain = 0.85 + 0.15 * np.sin(x * 0.02 + 6 * random.uniform(size=8)[plank] + 2 * np.sin(y * 0.9))
    boards = np.multiply.outer(shade * grain * np.where(y % 64 < 2, 0.3, 1.0), (0.55, 0.34, 0.19))
    is_brick = (np.abs(x % 64 - 32) < 29) & (np.abs(y % 32 - 16) < 14)
    height = is_brick.astype(float)
    for _ in range(3):
        height = (height + sum(np.roll(height, step, axis) for step in (1, -1) for axis in (0, 1))) / 5
    slope = [np.roll(height, -1, axis) - np.roll(height, 1, axis) for axis in (1, 0)]
    normal = np.stack([-2 * slope[0], -2 * slope[1], np.ones_like(height)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    wood, brick = picture("wood", boards), picture("brick", np.where(is_brick[..., None], (0.55, 0.25, 0.18), 0.58))
    bumps = picture("bumps", 0.5 + 0.5 * normal, "Non-Color")

    floor = material("floor", texture=wood, Roughness=0.35)
    bricks = material("bricks", texture=brick, bumps=bumps, Roughness=0.9)
    white = material("white", (0.8, 0.78, 0.74), Roughness=0.95)
    green = material("green", (0.15, 0.35, 0.2), Roughness=0.8)
    gold = material("gold", (1.0, 0.77, 0.34), Metallic=1.0, Roughness=0.25)
    steel = material("steel", (0.6, 0.6, 0.62), Metallic=1.0, Roughness=0.08)
    glass = material("glass", (1.0, 1.0, 1.0), Roughness=0.0, Transmission_Weight=1.0, IOR=1.5)
    blue = material("blue", (0.1, 0.2, 0.6), Roughness=0.3)
    fabric = material("fabric", (0.5, 0.12, 0.1), Roughness=1.0)
    glow = material("glow", Emission_Color=(1.0, 0.85, 0.6, 1.0), Emission_Strength=12.0)

    def wall(name, corners, surface, repeats=(1, 1)):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
        layer = mesh.uv_layers.new()
        for index, (u, v) in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
            layer.data[index].uv = (u * repeats[0], v * repeats[1])
        mesh.materials.append(surface)
        scene.collection.objects.link(bpy.data.objects.new(name, mesh))

    def finished(surface, smooth=True):
        if smooth:
            bpy.ops.object.shade_smooth()
        bpy.context.object.data.materials.append(surface)
        return bpy.context.object

    def box(size, place, surface, bevel=0.0):
        bpy.ops.mesh.primitive_cube_add(size=1, location=place)
        made = finished(surface, smooth=False)
        made.scale = size
        bpy.ops.object.transform_apply(scale=True, location=False)
        if bevel:
            edge = made.modifiers.new("bevel", "BEVEL")
            edge.width, edge.segments = bevel, 3

    wall("floor", [(-2.5, -3, 0), (2.5, -3, 0), (2.5, 3, 0), (-2.5, 3, 0)], floor, (3, 4))
    wall("ceiling", [(-2.5, -3, 2.8), (-2.5, 3, 2.8), (2.5, 3, 2.8), (2.5, -3, 2.8)], white)
    wall("back", [(-2.5, 3, 0), (2.5, 3, 0), (2.5, 3, 2.8), (-2.5, 3, 2.8)], bricks, (5, 5.6))
    wall("side", [(-2.5, -3, 0), (-2.5, 3, 0), (-2.5, 3, 2.8), (-2.5, -3, 2.8)], green)
    wall("front", [(2.5, -3, 0), (-2.5, -3, 0), (-2.5, -3, 2.8), (2.5, -3, 2.8)], white)
    # The other side has a window.
    for from_y, to_y, low, high in [(-3, 0, 0, 2.8), (2, 3, 0, 2.8), (0, 2, 0, 0.9), (0, 2, 2.3, 2.8)]:
        wall("part", [(2.5, to_y, low), (2.5, from_y, low), (2.5, from_y, high), (2.5, to_y, high)], white)
    wall("lamp", [(-0.5, -0.3, 2.75), (-0.5, 0.3, 2.75), (0.1, 0.3, 2.75), (0.1, -0.3, 2.75)], glow)
    box((1.4, 0.8, 0.06), (0.3, 0.6, 0.7), floor, 0.01)
    for side in (-0.6, 0.6):
        for end in (-0.3, 0.3):
            box((0.05, 0.05, 0.67), (0.3 + side, 0.6 + end, 0.335), steel)
    box((1.8, 0.8, 0.4), (-1.3, 2.2, 0.2), fabric, 0.08)
    box((1.8, 0.2, 0.5), (-1.3, 2.55, 0.6), fabric, 0.08)
    box((0.4, 1.2, 1.6), (-2.28, 0, 0.8), blue, 0.02)
    for radius, place, surface in [(0.17, (0.05, 0.5, 0.9), glass), (0.14, (0.65, 0.75, 0.87), steel)]:
        bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=place, segments=64, ring_count=32)
        finished(surface)
    bpy.ops.mesh.primitive_monkey_add(size=0.45, location=(-0.3, 0.75, 0.92), rotation=(0, 0, 0.4))
    finer = finished(gold).modifiers.new("finer", "SUBSURF")
    finer.levels = finer.render_levels = 2
    bpy.ops.mesh.primitive_torus_add(
        major_radius=0.12, minor_radius=0.05, location=(0.75, 0.4, 0.78), major_segments=64, minor_segments=24
    )
    finished(blue)
    for kind, place, turn, power, color in [
        ("POINT", (1.8, 2.4, 1.8), (0, 0, 0), 25, (1, 0.8, 0.5)),
        ("SPOT", (-2, -1, 2.6), (0.5, -0.6, 0), 60, (1, 1, 1)),
    ]:
        bpy.ops.object.light_add(type=kind, location=place, rotation=turn)
        light = bpy.context.object.data
        light.energy, light.color, light.shadow_soft_size = power, color, 0
        if kind == "SPOT":
            light.spot_size, light.spot_blend = 1.0, 0.3
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs[0].default_value = (*SKY, 1.0)
    camera = bpy.data.cameras.new("eye")
    eye = bpy.data.objects.new("eye", camera)
    scene.collection.objects.link(eye)
    eye.location, eye.rotation_euler = (0.6, -2.6, 1.5), (math.radians(80), 0, math.radians(8))
    camera.sensor_fit, camera.angle = "HORIZONTAL", math.radians(76)
    scene.camera = eye
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "room.blend"))
    bpy.ops.export_scene.gltf(
        filepath=str(folder / "room.gltf"), export_format="GLTF_SEPARATE", export_lights=True, export_cameras=True,
        export_apply=True,
    )
    # Blender's glass is solid, and glTF's is thin unless it has a volume.
    text = json.loads((folder / "room.gltf").read_text())
    for made in text["materials"]:
        if made["name"] == "glass":
            made["extensions"]["KHR_materials_volume"] = {"thicknessFactor": 1.0}
    text["extensionsUsed"].append("KHR_materials_volume")
    (folder / "room.gltf").write_text(json.dumps(text))


def render_by_cycles(folder: Path, size, samples: int, denoise: bool, seed: int, shift, out: Path) -> None:
    """Renders one eye by Cycles. `shift` is the eye's offset in metres, and the frustum's in widths of the picture."""
    import bpy
    import mathutils

    bpy.ops.wm.open_mainfile(filepath=str(folder / "room.blend"))
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = samples, denoise, seed
    scene.cycles.use_adaptive_sampling, scene.cycles.max_bounces = False, BOUNCES + 1
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    scene.camera.location = scene.camera.matrix_world @ mathutils.Vector((shift[0], 0, 0))
    scene.camera.data.shift_x = shift[1]
    scene.render.filepath = str(out)
    bpy.ops.render.render(write_still=True)


def read(path: Path, part: int = 0) -> np.ndarray:
    import OpenEXR

    channels = OpenEXR.File(str(path)).channels(part)
    return channels["RGB" if "RGB" in channels else "RGBA"].pixels[..., :3].astype(float)


def srgb(light: np.ndarray) -> np.ndarray:
    light = np.clip(light, 0, 1)
    return np.where(light < 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def error(picture: np.ndarray, converged: list) -> float:
    one, other = (srgb(picture) - srgb(limit) for limit in converged)
    return np.sqrt(max((one * other).mean(), 0))


def timed(command: list) -> float:
    """Runs a command, and returns its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--command", default="stereotrace", help="the command stereotrace")
    parser.add_argument("--size", default="480x320")
    parser.add_argument("--paths", default="4:4,9:9,16:16,16:32,36:36", help="samples and paths per pixel")
    parser.add_argument("--filters", default="box,gauss", help="filters of stereotrace")
    parser.add_argument("--converged", type=int, default=256, help="samples and paths of each converged picture")
    parser.add_argument("--part", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    folder = arguments.folder.resolve()
    size = [int(side) for side in arguments.size.split("x")]
    if arguments.part == "room":
        return make_room(folder, size)
    if arguments.part:
        samples, denoise, seed, offset, shift, out = json.loads(arguments.part)
        return render_by_cycles(folder, size, samples, denoise, seed, (offset, shift), Path(out))

    folder.mkdir(parents=True, exist_ok=True)
    this = [sys.executable, os.path.abspath(__file__), folder, "--size", arguments.size]
    timed([*this, "--part", "room"])
    render = [arguments.command, "render", folder / "room.gltf", "--size", arguments.size, "--exposure", "0"]
    render += ["--sky", ",".join(map(str, SKY))]
    report = subprocess.run(
        [str(word) for word in [*render, "--lighting", "direct", "--json", "--out", folder / "direct.png"]],
        check=True, capture_output=True, text=True,
    )
    camera = json.loads(report.stdout)["camera"]
    # A pixel's parallax at infinity is the interaxial on the screen.
    half, half_shift = 0.5 * camera["interaxial"], 0.5 * camera["interaxial_px"] / size[0]

    def by_cycles(samples, denoise, seed):
        files = [folder / f"cycles_{samples}_{seed}_{eye}.exr" for eye in EYES]
        cost = 0.0
        for file, side in zip(files, (-1, 1)):
            part = json.dumps([samples, denoise, seed, side * half, -side * half_shift, str(file)])
            cost += timed([*this, "--part", part])
        return [read(file) for file in files], cost

    def by_stereotrace(samples, paths, filter, *options):
        file = folder / f"stereotrace_{samples}_{paths}_{filter}.exr"
        lighting = ["--samples", samples, "--lighting", f"paths={paths}:{BOUNCES}", "--filter", filter]
        cost = timed([*render, *lighting, *options, "--out", file])
        return [read(file, part) for part in (0, 1)], cost

    seeds = (7, 8)
    ours = {
        filter: [by_stereotrace(64, arguments.converged, filter, "--denoise=false", "--seed", seed)[0] for seed in seeds]
        for filter in arguments.filters.split(",")
    }
    theirs = [by_cycles(arguments.converged, False, seed)[0] for seed in seeds]
    for eye, own, cycles in zip(EYES, zip(*next(iter(ours.values()))), zip(*theirs)):
        means = [np.minimum(np.mean(pictures, 0), 1).mean() for pictures in (own, cycles)]
        print(f"{eye} eye, converged: mean {means[0]:.4f}, {means[1]:.4f} by Cycles ({means[0] / means[1] - 1:+.2%})")
    rows = [("Cycles, 32 samples, denoised", theirs, by_cycles(32, True, 0))]
    for filter, converged in ours.items():
        for samples, paths in (map(int, pair.split(":")) for pair in arguments.paths.split(",")):
            name = f"stereotrace, {filter}, {samples} samples, {paths} paths, denoised"
            by_stereotrace(samples, paths, filter, "--denoise")  # drivers keep compiled kernels
            rows.append((name, converged, by_stereotrace(samples, paths, filter, "--denoise")))
    print("| picture | CPU s a pair | error, left | error, right |\n|---|---|---|---|")
    for name, converged, (pictures, cost) in rows:
        errors = [error(picture, limits) for picture, limits in zip(pictures, zip(*converged))]
        print(f"| {name} | {cost:.1f} | {errors[0]:.4f} | {errors[1]:.4f} |")


if __name__ == "__main__":
    main()
