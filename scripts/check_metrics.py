#!/usr/bin/env python3
"""Compares the library's accuracy figures with scikit-image's and NumPy's on the same pictures. Optional.

    pip install scikit-image imageio
    python3 scripts/check_metrics.py [SCENE...]        default: the built-in hall, spheres and fence

Renders each scene by `atomic` and by `naive` with the example, reads the PNG files, and compares identical and differing
pixels, MSE and PSNR with what the example printed. Ends with status 1 where they differ by more than was rounded.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import imageio.v3 as imageio
    import numpy as np
    from skimage.metrics import mean_squared_error, peak_signal_noise_ratio
except ImportError as error:
    sys.exit(f"{error}: pip install scikit-image imageio")

ROOT = Path(__file__).resolve().parent.parent


def render(scene, method, folder, *more):
    """The example's output."""
    command = [
        "cargo",
        "run",
        "--release",
        "--quiet",
        "--package",
        "stereotrace-cli",
        "--",
        "render",
        scene,
        "--method",
        method,
    ]
    command += ["--size", "320x180", "--out", str(folder), *more]
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def printed(text, pattern):
    """The number that the example printed, and half a unit of its last digit."""
    found = re.search(pattern, text)
    if not found:
        sys.exit(f"the example prints no {pattern}:\n{text}")
    number = found.group(1)
    return float(number), 0.51 * 10.0 ** -len(number.partition(".")[2])


def main():
    wrong = 0
    for scene in sys.argv[1:] or ["builtin:hall", "builtin:spheres", "builtin:fence"]:
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            text = render(scene, "atomic", folder / "atomic", "--compare")
            render(scene, "naive", folder / "naive")
            a, b = (imageio.imread(folder / method / "right.png")[..., :3] for method in ("atomic", "naive"))
        differing = np.any(a != b, axis=-1)
        checks = {
            "identical %": (PATTERNS["identical"], 100.0 * (1.0 - differing.mean())),
            "MSE": (PATTERNS["mse"], mean_squared_error(a, b)),
            "PSNR dB": (PATTERNS["psnr"], peak_signal_noise_ratio(b, a, data_range=255)),
        }
        for name, (pattern, expected) in checks.items():
            found, tolerance = printed(text, pattern)
            good = abs(found - expected) <= tolerance
            wrong += not good
            print(f"{scene} {name}: {found} here, {expected:.6f} there{'' if good else ': DIFFERS'}")
    sys.exit(1 if wrong else 0)


PATTERNS = {
    "identical": r"([\d.]+)% of the right eye identical",
    "mse": r"MSE ([\d.]+)",
    "psnr": r"PSNR ([\d.]+)",
}

if __name__ == "__main__":
    main()
