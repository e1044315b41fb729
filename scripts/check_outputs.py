#!/usr/bin/env python3
"""Reads the files that examples/ground_truth.rs writes with other programs' readers, and checks each against the others.

    scripts/check_outputs.sh           installs what this needs, renders, and runs it
    scripts/check_outputs.py FOLDER... [--match FOLDER]

OpenCV reads PFM and PNG, the OpenEXR project's own library reads OpenEXR, Pillow reads JPEG, JPS and MPO, and FFmpeg's stereo3d makes
the packings anew. Camera files are read here, as the Middlebury page of 2014 describes them and as camera.json says of itself, and points
are taken through them from picture to picture. --match also has OpenCV's block matcher find the disparities from the pictures. Ends with
status 1 where anything differs.
"""

import json
import subprocess
import sys
from pathlib import Path

import cv2
import imageio_ffmpeg
import numpy as np
import OpenEXR
from PIL import Image

FAULTS = []
COUNT = 0


def check(folder, what, good, found=""):
    global COUNT
    COUNT += 1
    if not good:
        FAULTS.append(f"{folder}: {what}: {found}")


def read(path):
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if picture is None:
        sys.exit(f"{path}: OpenCV can't read it")
    # OpenCV has blue first.
    return picture[..., [2, 1, 0, 3][: picture.shape[2]]] if picture.ndim == 3 else picture


def read_calib(path):
    """vision.middlebury.edu/stereo/data/scenes2014: NAME=VALUE, cameras as [f 0 cx; 0 f cy; 0 0 1]."""
    calib = dict(line.split("=", 1) for line in path.read_text().splitlines())
    for name in ("cam0", "cam1"):
        calib[name] = np.array([row.split() for row in calib[name].strip("[]").split(";")], dtype=float)
    return {name: value if name.startswith("cam") else float(value) for name, value in calib.items()}


def middles(width, height):
    """Columns and rows of pixel centres, counted from the first pixel's."""
    return np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))


def check_maps(folder, n, calib):
    disparity = read(folder / f"disp{n}.pfm").astype(float)
    depth = read(folder / f"depth{n}.pfm").astype(float)
    distance = read(folder / f"distance{n}.pfm").astype(float)
    sky = read(folder / f"sky{n}.png")
    nocc = read(folder / f"mask{n}nocc.png")
    occlusion = read(folder / f"occlusion{n}.png")
    objects, materials = read(folder / f"objects{n}.png"), read(folder / f"materials{n}.png")
    primitives = read(folder / f"primitives{n}.pfm")
    height, width = disparity.shape
    check(folder, f"size {n}", (width, height) == (calib["width"], calib["height"]), disparity.shape)
    surface = sky == 0
    check(folder, f"sky{n} is where depth is infinite", np.array_equal(sky == 255, np.isinf(depth)))
    check(folder, f"sky{n} has no ids", all(np.array_equal(sky == 255, ids == 0) for ids in (objects, materials)))
    check(folder, f"sky{n} has no primitive", np.array_equal(sky == 255, primitives == -1))
    check(folder, f"ids {n} have 16 bits", objects.dtype == materials.dtype == np.uint16)
    check(folder, f"sky{n} has the disparity of infinity", np.allclose(disparity[~surface], -calib["doffs"], atol=1e-4))
    check(folder, f"mask{n}nocc has 255 and 128", set(np.unique(nocc)) <= {255, 128})
    check(folder, f"mask{n}nocc is what the occlusion says", np.array_equal(nocc == 255, occlusion == 0))
    # The mask says where points leave the other picture.
    x, y = middles(width, height)
    there = x + (-disparity if n == 0 else disparity)
    edge = np.minimum(abs(there + 0.5), abs(there - width + 0.5)) < 1e-3
    leaves = (there < -0.5) | (there > width - 0.5)
    check(folder, f"occlusion{n} is 128 where points leave", np.array_equal((occlusion == 128)[~edge], leaves[~edge]))
    # Depth through calib.txt is the disparity.
    camera = calib[f"cam{n}"]
    with np.errstate(divide="ignore"):
        expected = calib["baseline"] * camera[0, 0] / depth - calib["doffs"]
    off = abs(expected - disparity)[surface].max(initial=0.0)
    check(folder, f"disp{n} is baseline f / Z - doffs to 0.001 px", off < 1e-3, off)
    along = np.sqrt(((x - camera[0, 2]) / camera[0, 0]) ** 2 + ((y - camera[1, 2]) / camera[1, 1]) ** 2 + 1)
    off = abs(distance[surface] / (depth * along)[surface] - 1).max(initial=0.0)
    check(folder, f"distance{n} is depth along the ray", off < 1e-6, off)
    check_kitti(folder, n, disparity, surface, nocc == 255)
    return disparity, depth, surface, nocc == 255, objects, materials, primitives, distance


def check_kitti(folder, n, disparity, surface, seen):
    for name, valid in ((f"disp_occ_{n}.png", surface), (f"disp_noc_{n}.png", surface & seen)):
        if not (folder / name).exists():
            check(folder, f"{name} is left out where disparities are negative", disparity[surface].min(initial=0) <= 0)
            continue
        kitti = read(folder / name)
        check(folder, f"{name} has 16 bits", kitti.dtype == np.uint16)
        check(folder, f"{name} is valid where it should", np.array_equal(kitti > 0, valid))
        off = abs(kitti / 256.0 - disparity)[valid].max(initial=0.0)
        check(folder, f"{name} is the disparity to half a step", off <= 0.5001 / 256, off)


def check_range(folder, calib, maps):
    values = np.concatenate([disparity[surface] for disparity, _, surface, *_ in maps])
    if len(values):
        check(folder, "vmin", calib["vmin"] == np.floor(values.min()), (calib["vmin"], values.min()))
        check(folder, "vmax", calib["vmax"] == np.ceil(values.max()), (calib["vmax"], values.max()))
        check(folder, "ndisp", calib["ndisp"] > values.max())


def world_points(eye, depth):
    height, width = depth.shape
    x, y = middles(width, height)
    # camera.json counts pixels from the corner.
    z = depth
    points = np.stack(
        [(x + 0.5 - eye["cx"]) / eye["fx"] * z, (y + 0.5 - eye["cy"]) / eye["fy"] * z, z, np.ones_like(z)], -1
    )
    return points @ np.array(eye["camera_to_world"]).T


def check_camera(folder, maps, calib):
    """What either eye sees stands in the other's picture where its disparity says: by camera.json alone."""
    camera = json.loads((folder / "camera.json").read_text())
    eyes = [camera["left"], camera["right"]]
    for n, sign in ((0, -1), (1, 1)):
        here, there = eyes[n], eyes[1 - n]
        disparity, depth, surface = maps[n][:3]
        finite = np.where(surface, depth, 1.0)
        points = world_points(here, finite) @ np.array(there["world_to_camera"]).T
        height, width = depth.shape
        x, y = middles(width, height)
        column = there["fx"] * points[..., 0] / points[..., 2] + there["cx"] - 0.5
        row = there["fy"] * points[..., 1] / points[..., 2] + there["cy"] - 0.5
        off = [abs(column - (x + sign * disparity))[surface].max(initial=0), abs(row - y)[surface].max(initial=0)]
        check(folder, f"camera.json takes view {n} to the other to 0.001 px", max(off) < 1e-3, off)
        for name, value in (("cx", 0.5 + calib[f"cam{n}"][0, 2]), ("cy", 0.5 + calib[f"cam{n}"][1, 2])):
            check(folder, f"{name} of camera.json is calib.txt's, half a pixel on", abs(here[name] - value) < 1e-6)
    check(folder, "doffs", abs(eyes[1]["cx"] - eyes[0]["cx"] - calib["doffs"]) < 1e-6)


def check_left_right(folder, maps):
    """Of what both see, the disparity at the nearest pixel of the other view is nearly the same, but at edges."""
    (left, _, surface, seen, *_), (right, *_) = maps
    height, width = left.shape
    x, y = middles(width, height)
    there = np.clip(np.rint(x - left), 0, width - 1).astype(int)
    off = abs(right[y.astype(int), there] - left)[surface & seen]
    if len(off) > 100:
        check(folder, "left and right disparities agree: median below 0.1 px", np.median(off) < 0.1, np.median(off))


def check_normals(folder, n, maps):
    camera = json.loads((folder / "camera.json").read_text())
    eye = camera["left" if n == 0 else "right"]
    depth, surface = maps[n][1], maps[n][2]
    normals = read(folder / f"geometric_normals{n}.pfm").astype(float)
    shading = read(folder / f"normals{n}.pfm").astype(float)
    for name, found in (("geometric", normals), ("shading", shading)):
        length = np.linalg.norm(found, axis=-1)
        check(folder, f"{name} normals {n} have length 1", np.allclose(length, surface, atol=1e-5))
    turned = read(folder / f"camera_normals{n}.pfm").astype(float)
    rotation = np.array(eye["world_to_camera"])[:3, :3]
    check(folder, f"camera normals {n}", np.allclose(shading @ rotation.T, turned, atol=1e-5))
    # Depths alone say which way surfaces face.
    points = world_points(eye, np.where(surface, depth, np.nan))[..., :3]
    if min(depth.shape) < 50:
        return
    across, down = points[1:-1, 2:] - points[1:-1, :-2], points[2:, 1:-1] - points[:-2, 1:-1]
    facing = np.cross(down, across)
    facing /= np.linalg.norm(facing, axis=-1, keepdims=True)
    cosine = np.sum(facing * normals[1:-1, 1:-1], axis=-1)
    cosine = cosine[np.isfinite(cosine)]
    if len(cosine) > 1000:
        check(folder, f"normals {n} are those of depths: median above .99", np.median(cosine) > 0.99, np.median(cosine))


def encoded(linear):
    linear = np.clip(linear, 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def check_exr(folder, maps):
    camera = json.loads((folder / "camera.json").read_text())
    for name, full in (("pair.exr", True), ("pair_half.exr", False)):
        with OpenEXR.File(str(folder / name), separate_channels=True) as file:
            parts = file.parts
            check(folder, f"{name} has two parts", len(parts) == 2, len(parts))
            for n, part in enumerate(parts):
                view = ("left", "right")[n]
                header, channels = part.header, {key: one.pixels for key, one in part.channels.items()}
                check(folder, f"{name}: part {n}", (header["name"], header["view"]) == (view, view), header.get("view"))
                primaries = np.array(header["chromaticities"], dtype=float).ravel()
                rec709 = [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329]
                check(folder, f"{name}: chromaticities", np.allclose(primaries, rec709), primaries)
                kind = np.float32 if full else np.float16
                check(folder, f"{name}: colours are {kind}", all(channels[c].dtype == kind for c in "RGB"))
                rgb = np.stack([channels[c].astype(float) for c in "RGB"], -1)
                shown = read(folder / f"im{n}.png")[..., :3]
                off = abs(encoded(rgb) - shown).max()
                check(folder, f"{name}: colours are im{n}.png's", off <= (0.51 if full else 0.6), off)
                disparity, depth, surface, _, objects, materials, primitives, distance = maps[n]
                check(folder, f"{name}: Z", np.array_equal(channels["Z"].astype(float), depth))
                check(folder, f"{name}: objects", np.array_equal(channels["id.object"], objects))
                check(folder, f"{name}: primitives", np.array_equal(channels["id.primitive"], primitives + 1))
                check(folder, f"{name}: ids are whole", channels["id.primitive"].dtype == np.uint32)
                eye = camera[view]
                to_camera = np.array(header["worldToCamera"], dtype=float).reshape(4, 4)
                expected = np.diag([1, -1, 1, 1]) @ np.array(eye["world_to_camera"])
                check(folder, f"{name}: worldToCamera", np.allclose(to_camera.T, expected, rtol=1e-5, atol=1e-5))
                check(folder, f"{name}: interaxial", np.isclose(header["interaxial"], camera["baseline"]))
                if not full:
                    continue
                check(folder, f"{name}: materials", np.array_equal(channels["id.material"], materials))
                check(folder, f"{name}: disparity", np.array_equal(channels["disparity"].astype(float), disparity))
                check(folder, f"{name}: distance", np.array_equal(channels["distance"].astype(float), distance))
                for prefix, other in (("N", "normals"), ("Ng", "geometric_normals")):
                    normals = np.stack([channels[f"{prefix}.{axis}"] for axis in "XYZ"], -1)
                    check(folder, f"{name}: {other}", np.array_equal(normals, read(folder / f"{other}{n}.pfm")))


def check_jpegs(folder):
    eyes = [read(folder / f"im{n}.png")[..., :3].astype(float) for n in (0, 1)]
    height, width = eyes[0].shape[:2]

    def close(what, found, expected):
        found = np.asarray(found.convert("RGB"), dtype=float)
        if found.shape != expected.shape:
            return check(folder, f"{what} has the size", False, found.shape)
        off = np.sqrt(((found - expected) ** 2).mean())
        check(folder, f"{what} shows the view: RMS below 5 of 255", off < 5, off)

    for n in (0, 1):
        with Image.open(folder / f"im{n}.png") as picture:
            check(folder, f"im{n}.png says that it is sRGB", picture.info.get("srgb") == 1, picture.info)
        with Image.open(folder / f"im{n}.jpg") as picture:
            check(folder, f"im{n}.jpg is a JPEG", picture.format == "JPEG", picture.format)
            close(f"im{n}.jpg", picture, eyes[n])
    with Image.open(folder / "pair.jps") as picture:
        close("pair.jps, right eye first", picture, np.concatenate(eyes[::-1], axis=1))
    said = ffmpeg_says(folder / "pair.jps")
    check(folder, "FFmpeg takes pair.jps for side by side, inverted", "side by side (inverted)" in said, said[-600:])
    with Image.open(folder / "pair.mpo") as picture:
        check(folder, "pair.mpo is an MPO of two", (picture.format, picture.n_frames) == ("MPO", 2), picture.format)
        info = picture.mpinfo
        kinds = [entry["Attribute"]["MPType"] for entry in info[0xB002]]
        check(folder, "pair.mpo holds a disparity", kinds == ["Multi-Frame Image: (Disparity)"] * 2, kinds)
        check(folder, "pair.mpo's first is shown", info[0xB002][0]["Attribute"]["RepresentativeImageFlag"])
        for n in (0, 1):
            picture.seek(n)
            check(folder, f"pair.mpo's {n} has its size", picture.size == (width, height), picture.size)
            close(f"pair.mpo {n}", picture, eyes[n])


def ffmpeg(*arguments, feed=None):
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-nostdin" if feed is None else "-y", *arguments]
    done = subprocess.run(command, input=feed, capture_output=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}:\n{done.stderr.decode()[-2000:]}")
    return done


def ffmpeg_says(path):
    return ffmpeg("-i", str(path), "-vf", "showinfo", "-f", "null", "-").stderr.decode()


def stereo3d(picture, kind):
    """What FFmpeg makes of a picture, whose height stays and width may not, or the other way round."""
    height, width = picture.shape[:2]
    size = f"{width}x{height}"
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24"]
    done = ffmpeg(*raw, "-s", size, "-i", "-", "-vf", f"stereo3d={kind}", *raw, "-", feed=picture.tobytes())
    return np.frombuffer(done.stdout, dtype=np.uint8)


def check_packings(folder):
    left, right = (np.ascontiguousarray(read(folder / f"im{n}.png")[..., :3]) for n in (0, 1))
    height, width = left.shape[:2]

    def same(name, expected, crop=slice(None)):
        found = np.ascontiguousarray(read(folder / f"{name}.png")[..., :3][crop])
        check(folder, f"{name} is FFmpeg's, pixel for pixel", np.array_equal(found.ravel(), expected), found.shape)

    beside, above = np.concatenate([left, right], axis=1), np.concatenate([left, right], axis=0)
    same("side-by-side", beside.ravel())
    same("cross-eyed", stereo3d(beside, "sbsl:sbsr"))
    same("top-bottom", stereo3d(beside, "sbsl:abl"))
    # The interlaced ones, of what FFmpeg then puts between each other; it wants even sizes.
    even = (slice(0, height - height % 2), slice(0, width - width % 2))
    left, right = left[even], right[even]
    if left.size == 0:
        return
    rows = np.concatenate([left[0::2], right[1::2]], axis=0)
    same("row-interlaced", stereo3d(np.ascontiguousarray(rows), "ab2l:irl"), even)
    columns = np.concatenate([left[:, 0::2], right[:, 1::2]], axis=1)
    same("column-interlaced", stereo3d(np.ascontiguousarray(columns), "sbs2l:icl"), even)
    lefts, rights = (np.empty_like(left[:, 0::2]) for _ in range(2))
    lefts[0::2], lefts[1::2] = left[0::2, 0::2], left[1::2, 1::2]
    rights[0::2], rights[1::2] = right[0::2, 1::2], right[1::2, 0::2]
    same("checkerboard", stereo3d(np.concatenate([lefts, rights], axis=1), "sbsl:chl"), even)


def check_match(folder, maps):
    """OpenCV's semi-global block matcher finds the disparities from the pictures alone."""
    left, right = (cv2.imread(str(folder / f"im{n}.png"), cv2.IMREAD_GRAYSCALE) for n in (0, 1))
    disparity, _, surface, seen, *_ = maps[0]
    most = int(np.ceil(disparity[surface].max() / 16 + 1)) * 16
    matcher = cv2.StereoSGBM_create(0, most, 5, 8 * 25, 32 * 25, 1, 63, 10, 100, 2, cv2.STEREO_SGBM_MODE_HH)
    found = matcher.compute(left, right).astype(float) / 16
    # What lies within `most` of the left edge it does not try.
    valid = surface & seen & (found >= 0)
    off = abs(found - disparity)[valid]
    share, median = valid.sum() / (surface & seen).sum(), np.median(off)
    print(f"{folder}: OpenCV's matcher finds {share:.0%} of what both eyes see, off by {median:.3f} px (median)")
    check(folder, "OpenCV's matcher agrees to a median of 0.5 px", median <= 0.5 and share > 0.5, (median, share))


def check_folder(folder, match):
    calib = read_calib(folder / "calib.txt")
    maps = [check_maps(folder, n, calib) for n in (0, 1)]
    check_range(folder, calib, maps)
    check_camera(folder, maps, calib)
    check_left_right(folder, maps)
    for n in (0, 1):
        check_normals(folder, n, maps)
    check_exr(folder, maps)
    check_jpegs(folder)
    check_packings(folder)
    if match:
        check_match(folder, maps)


def main():
    arguments = sys.argv[1:]
    match = []
    if "--match" in arguments:
        place = arguments.index("--match")
        match, arguments = arguments[place + 1 :], arguments[:place]
    if not arguments + match:
        sys.exit(__doc__)
    for folder in arguments + match:
        before, faults = COUNT, len(FAULTS)
        check_folder(Path(folder), folder in match)
        print(f"{folder}: {COUNT - before} checks, {len(FAULTS) - faults} failed")
    for fault in FAULTS:
        print(f"WRONG {fault}", file=sys.stderr)
    sys.exit(1 if FAULTS else 0)


if __name__ == "__main__":
    main()
