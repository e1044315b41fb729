"""A torch Dataset over the shards of a data set: stereo pairs, and optical flow if the spec has motion.

    pip install torch numpy pillow
    python examples/torch_dataset.py out/

It reads single pairs from tar files in any order, so that a DataLoader can shuffle and share them. Here each sample is
checked in place of training: the other picture is warped to the left one by disparity and by flow, and must resemble
it where the point is visible. The spec's outputs are [color, disparity, occlusion], for flow also flow,
flow_visibility and next.color, without `compress`.
"""

from __future__ import annotations

import io
import json
import sys
import tarfile
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image


class StereoPairs(torch.utils.data.Dataset):
    """Pairs of all shards of a folder. Pictures are float, 0 to 1, (3, height, width). Items of data sets with motion
    also have the next left picture and the flow to it.

    - ``left``, ``right``, ``next_left``: pictures.
    - ``disparity``: (height, width), pixels. The right picture shows the point of column x at x - disparity.
    - ``visible``: (height, width), whether the right eye sees the point.
    - ``flow``: (2, height, width), pixels to the right and down, to the next left picture.
    - ``flow_visible``: (height, width), whether the next left picture shows the point.
    """

    def __init__(self, folder: str | Path) -> None:
        self.items: list[dict[str, tuple[Path, int, int]]] = []
        for shard in sorted(Path(folder).glob("*.tar")):
            files: dict[str, dict[str, tuple[Path, int, int]]] = {}
            with tarfile.open(shard) as tar:
                for member in tar:
                    item, _, name = member.name.partition(".")
                    files.setdefault(item, {})[name] = (shard, member.offset_data, member.size)
            self.items += files.values()
        if not self.items:
            raise ValueError(f"{folder}: no shards of pairs")

    def __len__(self) -> int:
        return len(self.items)

    def __getitem__(self, index: int) -> dict[str, Any]:
        files = self.items[index]

        def read(name: str) -> bytes:
            shard, offset, size = files[name]
            with shard.open("rb") as file:
                file.seek(offset)
                return file.read(size)

        def picture(name: str) -> torch.Tensor:
            pixels = np.asarray(Image.open(io.BytesIO(read(name))).convert("RGB"))
            return torch.from_numpy(pixels.transpose(2, 0, 1).copy()).float() / 255

        def array(name: str) -> torch.Tensor:
            return torch.from_numpy(np.load(io.BytesIO(read(name))))

        def visible(name: str) -> torch.Tensor:
            return torch.from_numpy(np.asarray(Image.open(io.BytesIO(read(name)))) == 0)

        sample = {
            "item": json.loads(read("json"))["item"],
            "left": picture("left.png"),
            "right": picture("right.png"),
            "disparity": array("left.disparity.npy"),
            "visible": visible("left.occlusion.png"),
        }
        if "left.flow.npy" in files:
            sample["next_left"] = picture("next.left.png")
            sample["flow"] = array("left.flow.npy").permute(2, 0, 1)
            sample["flow_visible"] = visible("left.flow_visibility.png")
        return sample


def warped(picture: torch.Tensor, flow: torch.Tensor) -> torch.Tensor:
    """Samples pictures, (batch, 3, height, width), at the places that flow, (batch, 2, height, width), leads to."""
    _, _, height, width = picture.shape
    x = torch.arange(width).float() + 0.5 + flow[:, 0]
    y = (torch.arange(height).float() + 0.5)[:, None] + flow[:, 1]
    grid = torch.stack([2 * x / width - 1, 2 * y / height - 1], dim=-1).nan_to_num(0.0)
    return torch.nn.functional.grid_sample(picture, grid, align_corners=False, padding_mode="border")


def main(folder: str) -> None:
    pairs = StereoPairs(folder)
    loader = torch.utils.data.DataLoader(pairs, batch_size=4, shuffle=True, num_workers=2)
    for batch in loader:
        across = torch.stack([-batch["disparity"], torch.zeros_like(batch["disparity"])], dim=1)
        cases = [("right", across, batch["visible"])]
        if "flow" in batch:
            cases.append(("next_left", batch["flow"], batch["flow_visible"]))
        print(f"items {batch['item'].tolist()}: left {tuple(batch['left'].shape)}")
        for name, flow, seen in cases:
            off = (warped(batch[name], flow) - batch["left"]).abs().mean(dim=1)[seen].mean()
            still = (batch[name] - batch["left"]).abs().mean(dim=1)[seen].mean()
            print(f"  {name} warped to left: mean difference {off:.4f} where visible, {still:.4f} without warping")
            assert off < 0.5 * still
    print(f"{len(pairs)} pairs")


if __name__ == "__main__":
    main(sys.argv[1])
