"""Reads the shards of a data set by torch's DataLoader, with two workers, in batches. It trains nothing.

    pip install torch webdataset pillow
    python examples/read_torch.py 'out/pairs-{000000..000007}.tar'

Each batch is checked: the right picture is warped to the left eye by the disparity. Where both eyes see a point, the
warped picture must resemble the left one.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np
import torch
import webdataset


def tensors(pair: dict[str, Any]) -> dict[str, Any]:
    """Returns the tensors for training.

    Pictures are float, 0 to 1, (3, height, width). Disparities in pixels and masks are (height, width)."""
    occlusion = np.asarray(pair["left.occlusion.png"])[..., 0]
    disparity = pair["left.disparity.npy"] if "left.disparity.npy" in pair else pair["left.disparity.npy.gz"]
    return {
        "item": pair["json"]["item"],
        "left": torch.from_numpy(np.ascontiguousarray(pair["left.png"].transpose(2, 0, 1))).float() / 255,
        "right": torch.from_numpy(np.ascontiguousarray(pair["right.png"].transpose(2, 0, 1))).float() / 255,
        "disparity": torch.from_numpy(disparity),
        "visible": torch.from_numpy(occlusion == 0),
    }


def carried(right: torch.Tensor, disparity: torch.Tensor) -> torch.Tensor:
    """Warps the right pictures to the left eyes: column i shows the right picture at column i - disparity."""
    _, _, height, width = right.shape
    columns = torch.arange(width).float() + 0.5 - disparity
    rows = (torch.arange(height).float() + 0.5)[:, None].expand(height, width)
    grid = torch.stack([2 * columns / width - 1, (2 * rows / height - 1).expand_as(columns)], dim=-1)
    return torch.nn.functional.grid_sample(right, grid, align_corners=False, padding_mode="border")


def main(urls: str) -> None:
    pairs = webdataset.WebDataset(urls, shardshuffle=False, empty_check=False)
    loader = torch.utils.data.DataLoader(pairs.decode("rgb8").map(tensors), batch_size=4, num_workers=2)
    began, items = time.monotonic(), []
    # There may be more workers than shards. A worker without a shard has no pairs, which empty_check would refuse.
    for batch in loader:
        items += batch["item"].tolist()
        difference = (carried(batch["right"], batch["disparity"]) - batch["left"]).abs().mean(dim=1)
        seen = difference[batch["visible"]]
        print(
            f"items {batch['item'].tolist()}: left {tuple(batch['left'].shape)}; "
            f"where both eyes see a point, the mean difference from the warped right picture is {seen.mean():.4f}"
        )
        assert seen.mean() < 0.02
    assert len(set(items)) == len(items)
    print(f"{len(items)} pairs in {time.monotonic() - began:.1f} s")


if __name__ == "__main__":
    main(sys.argv[1])
