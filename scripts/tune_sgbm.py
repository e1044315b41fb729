#!/usr/bin/env python3
"""Chooses the parameters of OpenCV's SGBM on generated scenes and on the built-in hall, and compares both choices on
scenes of other authors.

    scripts/tune_sgbm.py [--pairs 24] [--tries 48] [--scenes target/scenes]

Needs the packages stereotrace[dataset] and opencv-python-headless, and ../shared/scenes/unpack.sh before: it is no part
of CI. All sets have the same number of pairs, at 640x480 with the noise of a sensor. Each set tries the same random
parameters and keeps those with the least error. The error is the share of visible surface pixels whose disparity is
unknown or wrong by more than 2 pixels, as the mean over pairs. The foreign scenes have no part in the choice.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cv2
import numpy as np

from stereotrace import MISS, dataset

SIZE = [640, 480]
DISPARITIES = 128
Pair = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def pairs(scenes: list[dict], interaxial: list[float] | None, count: int, seed: int) -> list[Pair]:
    """Returns left and right pictures, disparities, and where both eyes see a surface."""
    spec = dataset.Spec.load(
        {
            "pairs": count,
            "seed": seed,
            "size": SIZE,
            "scenes": scenes,
            "rig": {"screen_distance": "inf"} | ({"interaxial": {"log_uniform": interaxial}} if interaxial else {}),
            "sensor": {"full_well": {"log_uniform": [2000, 20000]}, "read_noise": {"uniform": [2, 12]}},
            "render": {"samples": 4},
            "outputs": ["color", "disparity", "left.occlusion", "left.object"],
        }
    )
    worker, found = dataset.Worker(spec), []
    for item in range(count):
        pair, _ = worker.pair(item)
        surface = pair.left.object != MISS
        seen = (pair.left.occlusion == 0) & surface & (pair.left.disparity < DISPARITIES - 1)
        pictures = [cv2.cvtColor(view.color, cv2.COLOR_RGB2BGR) for view in (pair.left, pair.right)]
        found.append((*pictures, pair.left.disparity, seen))
    return found


def parameters(random: np.random.Generator) -> dict[str, int]:
    """Draws parameters of SGBM."""
    block = int(random.choice([1, 3, 5, 7, 9, 11]))
    smooth = int(round(np.exp(random.uniform(np.log(1), np.log(40))) * 3 * block * block))
    return {
        "blockSize": block,
        "P1": smooth,
        "P2": int(smooth * random.uniform(1.5, 10)),
        "uniquenessRatio": int(random.integers(0, 16)),
        "preFilterCap": int(random.choice([1, 7, 15, 31, 63])),
        "disp12MaxDiff": int(random.choice([-1, 1, 2, 4])),
        "mode": int(random.choice([cv2.STEREO_SGBM_MODE_SGBM, cv2.STEREO_SGBM_MODE_SGBM_3WAY])),
    }


def error(given: dict[str, int], among: list[Pair]) -> float:
    """Returns the share of visible surface pixels that are unknown or wrong by more than 2 pixels."""
    shares = []
    for left, right, disparity, seen in among:
        # Columns beside the left picture, so that all of its pixels have all disparities.
        left, right = (cv2.copyMakeBorder(one, 0, 0, DISPARITIES, 0, cv2.BORDER_REPLICATE) for one in (left, right))
        matcher = cv2.StereoSGBM_create(minDisparity=0, numDisparities=DISPARITIES, **given)
        found = matcher.compute(left, right)[:, DISPARITIES:].astype(np.float32) / 16
        wrong = (found < 0) | (np.abs(found - disparity) > 2)
        shares.append(wrong[seen].mean())
    return float(np.mean(shares))


def sets_of(count: int, scenes: Path) -> tuple[dict[str, list[Pair]], dict[str, list[Pair]]]:
    """Returns the sets to choose or to train on, and the foreign scenes to test on, by name."""
    kinds = [{"generate": kind} for kind in ("rooms", "floating", "outdoors")]
    # Generated scenes have interaxials of their own.
    hall = pairs([{"builtin": "hall"}], [0.05, 0.3], count, 1)
    plain = [{"generate": {"kind": kind["generate"], "plain": {"uniform": [0, 0.6]}}} for kind in kinds]
    sets = {
        "generated": pairs(kinds, None, count, 1),
        "generated, plain": pairs(plain, None, count, 1),
        "hall": hall,
    }
    life = Path(__file__).parent.parent / "scenes" / "still_life.obj"
    foreign = {
        "sponza": (scenes / "sponza" / "sponza.obj", [0.5, 2]),
        "thin": (scenes / "thin" / "thin.obj", [1, 6]),
        "still life": (life, [0.3, 1]),
    }
    tests = {
        name: pairs([{"file": str(file.resolve())}], interaxial, count, 2)
        for name, (file, interaxial) in foreign.items()
    }
    for name, among in [*sets.items(), *tests.items()]:
        found = np.concatenate([disparity[seen] for *_, disparity, seen in among])
        print(f"{name}: {len(found)} pixels, disparities of 5 to 95%: {np.percentile(found, [5, 50, 95]).round(1)}")
    return sets, tests


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--pairs", type=int, default=24)
    parser.add_argument("--tries", type=int, default=48)
    parser.add_argument("--scenes", type=Path, default=Path("target/scenes"))
    given = parser.parse_args()
    cv2.setNumThreads(1)
    sets, tests = sets_of(given.pairs, given.scenes)
    random = np.random.default_rng(7)
    usual = {"blockSize": 3, "P1": 8 * 27, "P2": 32 * 27}
    tried = [usual] + [parameters(random) for _ in range(given.tries)]
    errors = {name: [error(one, among) for one in tried] for name, among in sets.items()}
    print(f"| chosen on | {' | '.join([*sets, *tests])} | parameters |")
    rows = {"OpenCV's sample": usual} | {name: tried[int(np.argmin(errors[name]))] for name in sets}
    for name, chosen in rows.items():
        shares = [error(chosen, among) for among in [*sets.values(), *tests.values()]]
        print(f"| {name} | {' | '.join(f'{100 * share:.1f}%' for share in shares)} | {chosen} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
