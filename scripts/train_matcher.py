#!/usr/bin/env python3
"""Trains a small matcher on generated scenes and on the built-in hall, and compares both on scenes of other authors.

    scripts/train_matcher.py [--pairs 24] [--steps 4000] [--scenes target/scenes]

Needs the packages stereotrace[dataset], opencv-python-headless and torch, and ../shared/scenes/unpack.sh before: it is
no part of CI. The matcher is that of Žbontar and LeCun 2016 (MC-CNN, the fast one): four layers of 3x3 convolutions
describe a patch of 9x9 pixels, and the hinge loss makes the description of the true place more alike than that of
another place. Here the similarity is averaged over 9x9 pixels, and the best disparity wins. Both sets have the same
number of pairs, and the network sees the same number of patches of each. The error is that of tune_sgbm.py.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.nn import functional
from tune_sgbm import DISPARITIES, Pair, sets_of

RADIUS = 4
"""A patch has this many pixels to each side of its middle."""
BATCH = 256


def network() -> torch.nn.Sequential:
    """Returns the layers that describe patches."""
    layers: list[torch.nn.Module] = []
    for number in range(RADIUS):
        layers += [torch.nn.Conv2d(64 if number else 1, 64, 3), torch.nn.ReLU()]
    return torch.nn.Sequential(*layers[:-1])


def grey(picture: np.ndarray) -> np.ndarray:
    """Returns brightness with mean 0 and deviation 1."""
    found = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(np.float32)
    return (found - found.mean()) / (found.std() + 1e-6)


def trained(among: list[Pair], steps: int) -> torch.nn.Sequential:
    """Trains the network by patches of pairs."""
    torch.manual_seed(1)
    random, net = np.random.default_rng(1), network()
    rate = torch.optim.Adam(net.parameters(), 1e-3)
    pictures = [(grey(left), grey(right), disparity, seen) for left, right, disparity, seen in among]
    side = RADIUS + 12
    inner = (slice(RADIUS, -RADIUS), slice(DISPARITIES + side, -side))
    places = [np.argwhere(seen[inner]) + [RADIUS, DISPARITIES + side] for *_, seen in pictures]
    for step in range(steps):
        if step == steps * 3 // 4:
            rate.param_groups[0]["lr"] = 2e-4
        number = int(random.integers(len(pictures)))
        left, right, disparity, _ = pictures[number]
        chosen = places[number][random.integers(len(places[number]), size=BATCH)]
        true = chosen[:, 1] - np.rint(disparity[chosen[:, 0], chosen[:, 1]]).astype(int)
        wrong = true + random.integers(3, 12, BATCH) * random.choice([-1, 1], BATCH)
        patches = [patches_of(left, chosen[:, 0], chosen[:, 1])]
        patches += [patches_of(right, chosen[:, 0], columns) for columns in (true, wrong)]
        found = net(torch.from_numpy(np.concatenate(patches))[:, None])
        one, same, other = functional.normalize(found.flatten(1)).chunk(3)
        loss = (0.2 + (one * other).sum(1) - (one * same).sum(1)).clamp(min=0).mean()
        rate.zero_grad()
        loss.backward()
        rate.step()
    return net


def patches_of(picture: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    steps = np.arange(-RADIUS, RADIUS + 1)
    return picture[rows[:, None, None] + steps[:, None], columns[:, None, None] + steps]


@torch.no_grad()
def error(net: torch.nn.Sequential, among: list[Pair]) -> float:
    """Returns the share of visible surface pixels whose disparity is wrong by more than 2 pixels."""
    shares = []
    for left, right, disparity, seen in among:
        both = [torch.from_numpy(np.pad(grey(one), RADIUS, "edge"))[None, None] for one in (left, right)]
        one, other = (functional.normalize(net(picture))[0] for picture in both)
        best = torch.full(disparity.shape, -2.0)
        found = torch.zeros(disparity.shape)
        for shift in range(DISPARITIES):
            alike = torch.full(disparity.shape, -1.0)
            alike[:, shift:] = (one[:, :, shift:] * other[:, :, : other.shape[2] - shift]).sum(0)
            alike = torch.from_numpy(cv2.blur(alike.numpy(), (9, 9)))
            found[alike > best] = shift
            best = torch.maximum(best, alike)
        shares.append((np.abs(found.numpy() - disparity) > 2)[seen].mean())
    return float(np.mean(shares))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--pairs", type=int, default=24)
    parser.add_argument("--steps", type=int, default=4000)
    parser.add_argument("--scenes", type=Path, default=Path("target/scenes"))
    given = parser.parse_args()
    sets, tests = sets_of(given.pairs, given.scenes)
    print(f"| trained on | {' | '.join(tests)} |", flush=True)
    for name, among in sets.items():
        net = trained(among, given.steps)
        shares = [error(net, pairs) for pairs in tests.values()]
        print(f"| {name} | {' | '.join(f'{100 * share:.1f}%' for share in shares)} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
