"""Compares lenses with OpenCV: places of points, maps of rectification, and rays of kernels.

Run it with a Python that has opencv-python-headless and numpy from PyPI, and this project's package:

    python scripts/beside_opencv_lens.py

Prints the largest errors in pixels. Rays are those of a software adapter, unless STEREOTRACE_ADAPTER names another one.
"""

import os

import cv2
import numpy as np

os.environ.setdefault("STEREOTRACE_ADAPTER", "software")

import stereotrace as st

SIZE = (640, 480)
LENSES = {
    "radial-tangential, 4": {"radial_tangential": [-0.28, 0.07, 1e-3, -5e-4]},
    "radial-tangential, 5": {"radial_tangential": [0.12, -0.05, 2e-3, -3e-3, 0.01]},
    "rational, 8": {"radial_tangential": [0.4, 0.05, 1e-3, 2e-3, 0.002, 0.8, 0.18, 0.01]},
    "strong tangential": {"radial_tangential": [-0.05, 0.02, 0.06, -0.08]},
    "fisheye": {"fisheye": [0.05, 0.01, -2e-3, 1e-3]},
    "wide fisheye": {"fisheye": [-0.02, 0.003, -1e-3, 2e-4]},
}
FOCAL = {"wide fisheye": 275.0, "rational, 8": 320.0}
# Slopes of the planes that measure rays, which must be in front of all rays. These numbers are exact in float32.
TILT = {"wide fisheye": 1 / 16, "rational, 8": 1 / 16}


def lens_of(name: str) -> dict:
    focal = FOCAL.get(name, 400.0)
    return {"fx": focal, "fy": 1.03 * focal, "cx": 326.3, "cy": 234.6, **LENSES[name]}


def matrix(lens: dict) -> np.ndarray:
    # OpenCV's pixel centres are at integers.
    return np.array([[lens["fx"], 0, lens["cx"] - 0.5], [0, lens["fy"], lens["cy"] - 0.5], [0, 0, 1]])


def projected(lens: dict, points: np.ndarray) -> np.ndarray:
    points, still = points.reshape(-1, 1, 3), np.zeros(3)
    if "fisheye" in lens:
        places, _ = cv2.fisheye.projectPoints(points, still, still, matrix(lens), np.array(lens["fisheye"]))
    else:
        places, _ = cv2.projectPoints(points, still, still, matrix(lens), np.array(lens["radial_tangential"]))
    return places.reshape(-1, 2) + 0.5


def camera_of(lens: dict, interaxial: float = 0.0) -> st.Camera:
    return st.Camera((0, 0, 0), (0, 0, -1), size=SIZE, interaxial=interaxial, lens=lens)


def error_of_points(lens: dict) -> float:
    """Compares the places of random points in the frame."""
    points = np.random.default_rng(1).uniform((-3, -3, 0.5), (3, 3, 4), (4000, 3))
    expected = projected(lens, points)
    found = np.array([camera_of(lens).project((x, -y, -z))[:2] for x, y, z in points])
    # Elsewhere OpenCV folds the picture.
    inside = ((expected >= 0) & (expected < SIZE)).all(axis=1) & ~np.isnan(found).any(axis=1)
    return np.abs(found - expected)[inside].max()


def error_of_maps(lens: dict) -> float:
    k = matrix(lens)
    if "fisheye" in lens:
        distortion = np.array(lens["fisheye"])
        expected = cv2.fisheye.initUndistortRectifyMap(k, distortion, np.eye(3), k, SIZE, cv2.CV_32FC1)
    else:
        distortion = np.array(lens["radial_tangential"])
        expected = cv2.initUndistortRectifyMap(k, distortion, None, k, SIZE, cv2.CV_32FC1)
    worst = 0.0
    for found, wanted in zip(camera_of(lens, 0.1).rectify_map(), expected):
        # The library leaves directions out that the lens does not show.
        known = ~np.isnan(found)
        worst = max(worst, np.abs(found - wanted)[known].max())
    return worst


def error_of_rays(renderer: st.Renderer, lens: dict, tilt: float) -> float:
    """Measures directions by the depths of two tilted squares, and projects them by OpenCV."""
    tangents = []
    for x, y in ((tilt, 0), (0, tilt)):
        # Corners of the plane x X + y Y + Z = -1, outside the frame.
        corners = [(a, b, -1 - x * a - y * b) for a, b in ((-32, -32), (32, -32), (32, 32), (-32, 32))]
        scene = st.Scene()
        scene.add_mesh(np.array(corners, np.float32), np.array([[0, 1, 2], [0, 2, 3]]))
        depth = renderer.render(scene, camera_of(lens), method="naive", outputs=["depth"]).left.depth.astype(float)
        tangents.append((1 - 1 / depth) / tilt)
    right, up = tangents
    directions = np.stack([right, -up, np.ones_like(right)], axis=-1)
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]]
    expected = np.stack([columns + 0.5, rows + 0.5], axis=-1).reshape(-1, 2)
    return np.hypot(*(projected(lens, directions) - expected).T).max()


def main() -> None:
    renderer = st.Renderer()
    print(f"OpenCV {cv2.__version__}, {renderer}, {SIZE[0]}x{SIZE[1]}; largest errors in pixels")
    print(f"{'lens':<22}{'points':>10}{'maps':>10}{'rays':>10}")
    for name in LENSES:
        lens = lens_of(name)
        rays = error_of_rays(renderer, lens, TILT.get(name, 1 / 4))
        errors = error_of_points(lens), error_of_maps(lens), rays
        print(f"{name:<22}" + "".join(f"{error:>10.1e}" for error in errors))


if __name__ == "__main__":
    main()
