"""Compares light by paths with Mitsuba 3: the same scenes, cameras and numbers of bounces.

Run it with a Python that has mitsuba and numpy from PyPI, and this project's package:

    python scripts/beside_mitsuba.py --samples 1024

Each program renders every scene twice, with different random numbers. So its noise is known, and the table can say
whether the programs differ by more than chance explains. Regions are the squares of a 6x6 grid.
"""

import argparse
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

import stereotrace as st

SIDE, BOUNCES, FOV, GRID = 96, 6, 26.0, 6
EYE, TARGET = (0.0, 1.0, 3.75), (0.0, 1.0, 0.0)
WHITE, RED, GREEN = (0.73, 0.73, 0.73), (0.65, 0.05, 0.05), (0.12, 0.45, 0.15)
LAMP = (17.0, 12.0, 4.0)
DULL = {"specular": 0.0, "roughness": 1.0}


def quad(*corners):
    return np.array(corners, np.float32)


def box(low, high):
    """Returns the sides of a box, seen from outside."""
    (a, b, c), (d, e, f) = low, high
    return [
        quad((a, b, f), (d, b, f), (d, e, f), (a, e, f)), quad((d, b, c), (a, b, c), (a, e, c), (d, e, c)),
        quad((a, b, c), (a, b, f), (a, e, f), (a, e, c)), quad((d, b, f), (d, b, c), (d, e, c), (d, e, f)),
        quad((a, e, f), (d, e, f), (d, e, c), (a, e, c)), quad((a, b, c), (d, b, c), (d, b, f), (a, b, f)),
    ]


ROOM = [
    (quad((-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)), ("diffuse", WHITE)),
    (quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)), ("diffuse", WHITE)),
    (quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)), ("diffuse", WHITE)),
    (quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)), ("diffuse", RED)),
    (quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)), ("diffuse", GREEN)),
]
LAMP_QUAD = quad((-0.25, 1.98, -0.25), (0.25, 1.98, -0.25), (0.25, 1.98, 0.25), (-0.25, 1.98, 0.25))
LIT_ROOM = [*ROOM, (LAMP_QUAD, ("lamp", LAMP))]
BOXES = [
    (side, ("diffuse", WHITE))
    for low, high in [((-0.7, 0, -0.7), (-0.1, 1.2, -0.1)), ((0.15, 0, 0), (0.7, 0.6, 0.6))]
    for side in box(low, high)
]
FLOOR = [(quad((-9, 0, -9), (-9, 0, 9), (9, 0, 9), (9, 0, -9)), ("diffuse", (0.5, 0.4, 0.3)))]

# Meshes, balls (centre, radius, surface) and the sky of each scene. A metal has a roughness, a glass an index.
SCENES = {
    "boxes": (LIT_ROOM + BOXES, [], 0.0),
    "rough metal and glass": (
        LIT_ROOM, [((-0.45, 0.4, -0.3), 0.4, ("metal", 0.15)), ((0.45, 0.35, 0.3), 0.35, ("glass", 1.5))], 0.0,
    ),
    "metals under a sky": (
        FLOOR, [((x, 0.35, 0.3), 0.33, ("metal", rough)) for x, rough in ((-0.75, 0.05), (0, 0.1), (0.75, 0.2))], 0.8,
    ),
    "furnace": (
        [], [((-0.5, 1, 0), 0.45, ("diffuse", (0.5, 0.5, 0.5))), ((0.5, 1, 0), 0.45, ("metal", 0.15))], 1.0,
    ),
}


def by_stereotrace(name, samples, seed):
    meshes, balls, sky = SCENES[name]
    scene = st.Scene()
    scene.set_sky((sky,) * 3)

    def material(kind, value):
        match kind:
            case "diffuse":
                made = st.Material.principled(value, **DULL)
            case "lamp":
                made = st.Material(0.0, emission=value)
            case "metal":
                made = st.Material.principled(1.0, metallic=1.0, roughness=value)
            case "glass":
                made = st.Material.principled(1.0, roughness=0.0, transmission=1.0, index=value)
        return scene.add_material(made)

    for corners, surface in meshes:
        scene.add_mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), material=material(*surface))
    for center, radius, surface in balls:
        scene.add_sphere(center, radius, material=material(*surface))
    camera = st.Camera(EYE, TARGET, size=(SIDE, SIDE), fov=FOV, interaxial=0.0)
    lighting = f"paths={samples}:{BOUNCES}"
    pair = RENDERER.render(scene, camera, method="naive", outputs="linear", lighting=lighting, samples=64, seed=seed)
    return pair.left.linear[..., :3]


def by_mitsuba(name, samples, seed):
    meshes, balls, sky = SCENES[name]
    transform = mi.ScalarTransform4f()
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": BOUNCES + 2, "rr_depth": 1000},
        "sensor": {
            "type": "perspective", "fov": FOV, "film": film,
            "to_world": transform.look_at(origin=EYE, target=TARGET, up=(0, 1, 0)),
            "sampler": {"type": "multijitter", "sample_count": samples, "seed": seed},
        },
    }
    if sky:
        scene["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": (sky,) * 3}}

    def surface(kind, value):
        match kind:
            case "diffuse":
                return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": value}}}
            case "lamp":
                return {"type": "diffuse", "reflectance": {"type": "rgb", "value": (0, 0, 0)}}
            case "metal":
                return {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": value**2}
            case "glass":
                return {"type": "dielectric", "int_ior": value, "ext_ior": 1.0}

    with tempfile.TemporaryDirectory() as folder:
        for index, (corners, (kind, value)) in enumerate(meshes):
            # A lamp emits on both sides.
            for turn, order in enumerate([(0, 1, 2, 0, 2, 3), (2, 1, 0, 3, 2, 0)][: 2 if kind == "lamp" else 1]):
                mesh = mi.Mesh("quad", 4, 2)
                parts = mi.traverse(mesh)
                parts["vertex_positions"] = (corners + (0, 1e-4 * turn, 0)).astype(np.float32).ravel()
                parts["faces"] = np.array(order, np.uint32)
                parts.update()
                file = str(Path(folder) / f"{index}_{turn}.ply")
                mesh.write_ply(file)
                shape = {"type": "ply", "filename": file, "face_normals": True, "bsdf": surface(kind, value)}
                if kind == "lamp":
                    shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": value}}
                scene[f"mesh{index}_{turn}"] = shape
        for index, (center, radius, (kind, value)) in enumerate(balls):
            scene[f"ball{index}"] = {"type": "sphere", "center": center, "radius": radius, "bsdf": surface(kind, value)}
        return np.array(mi.render(mi.load_dict(scene), seed=seed))[..., :3]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=1024, help="samples and paths per pixel, a multiple of 64")
    arguments = parser.parse_args()
    print("| scene | mean | by Mitsuba | difference | largest of a region | its noise | pixels, in standard errors |")
    print("|---|---|---|---|---|---|---|")
    for name in SCENES:
        ours, theirs = (
            np.array([render(name, arguments.samples, seed) for seed in (1, 2)])
            for render in (by_stereotrace, by_mitsuba)
        )
        # Half of the squared difference of two pictures is a pixel's variance; the mean of two has half of it.
        variances = [((one[0] - one[1]) ** 2) / 4 for one in (ours, theirs)]
        a, b = ours.mean(0), theirs.mean(0)

        def regions(picture):
            return picture.reshape(GRID, SIDE // GRID, GRID, SIDE // GRID, 3).mean((1, 3))

        lit = regions(b).mean(-1) > 0.02 * b.mean()
        difference = (regions(a).mean(-1) / np.maximum(regions(b).mean(-1), 1e-9) - 1)[lit]
        noise = np.sqrt(regions(sum(variances)).mean(-1) / (SIDE // GRID) ** 2)[lit] / regions(b).mean(-1)[lit]
        worst = np.abs(difference).argmax()
        # Noise of the neighbourhood: two pictures say little about a single pixel.
        local = np.kron(regions(sum(variances)), np.ones((SIDE // GRID, SIDE // GRID, 1)))
        pixels = np.sqrt((((a - b) ** 2)[local > 1e-9] / local[local > 1e-9]).mean()) if (local > 1e-9).any() else 0.0
        print(
            f"| {name} | {a.mean():.4f} | {b.mean():.4f} | {a.mean() / b.mean() - 1:+.2%} "
            f"| {difference[worst]:+.2%} | ±{noise[worst]:.2%} | {pixels:.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    mi.set_variant("scalar_rgb")
    RENDERER = st.Renderer()
    main()
