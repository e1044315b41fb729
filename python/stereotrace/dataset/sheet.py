"""``python -m stereotrace.dataset.sheet FOLDER SHEET.png``: shows the pairs of a data set as one picture."""

from __future__ import annotations

import argparse
import os
import re
import sys
from typing import Any

import numpy as np

from stereotrace import encode_png

from .store import Store
from .verify import pairs, read, spec_of

RAMP = np.array(
    [(48, 18, 59), (70, 107, 227), (40, 187, 236), (49, 242, 153), (162, 252, 60), (237, 208, 58), (251, 128, 34),
     (210, 49, 5), (122, 4, 3)]
)  # fmt: skip
"""Colours from the least value to the largest one: every 32nd of Google's Turbo."""
CLASSES = np.array([(70, 107, 227), (210, 49, 5), (237, 208, 58), (60, 60, 60)])
"""Colours of visible points, hidden ones, those outside the picture, and others."""


def sheet(url: str, count: int = 200, width: int = 160, storage_options: dict[str, Any] | None = None) -> Any:
    """Returns a picture of up to ``count`` pairs, spread evenly over the data set: uint8, ``(height, width, 3)``.

    A pair is a column of pictures, each ``width`` pixels wide: its left picture and those of its arrays that the data
    set has. Of an array of cameras, it shows camera 0 and the first pair. Disparities and numbers of layers have the
    colours of their own range. Classes of occlusion and of flow are blue for visible points, red for hidden ones,
    yellow outside the picture, and grey otherwise. Flow has the hue of its direction, paler where it is slower. Raises
    ``ValueError`` if the folder has no data set with left pictures in tar or Parquet files, and ``OSError`` if it can't
    be read."""
    store = Store(url, storage_options)
    spec = spec_of(store)
    if spec.is_layout or not {("left", "color"), ("camera00", "color")}.intersection(spec.checked.arrays):
        raise ValueError(f"{url}: a sheet needs left pictures in tar or Parquet files")
    chosen = {index * spec["pairs"] // min(count, spec["pairs"]) for index in range(min(count, spec["pairs"]))}
    tiles = []
    names = store.names()
    for shard in range(spec.shards):
        wanted = chosen.intersection(spec.shard_items(shard))
        if wanted and spec.data_name(shard) in names:
            for key, files in pairs(spec, store.read(spec.data_name(shard))):
                if int(key) in wanted:
                    tiles.append(_tile(files, width))
    if not tiles:
        raise ValueError(f"{url}: it has no pairs yet")
    height = max(tile.shape[0] for tile in tiles)
    tiles = [np.pad(tile, ((0, height - tile.shape[0]), (0, 0), (0, 0))) for tile in tiles]
    across = max(1, round((len(tiles) * tiles[0].shape[0] / tiles[0].shape[1] * 1.5) ** 0.5))
    blank = np.zeros_like(tiles[0])
    tiles += [blank] * (-len(tiles) % across)
    return np.vstack([np.hstack(tiles[row : row + across]) for row in range(0, len(tiles), across)])


def _tile(files: dict[str, bytes], width: int) -> Any:
    picture = "left.png" if "left.png" in files else "camera00.png"
    found = [_small(read(picture, files[picture]), width)]
    for output, colored in (
        ("disparity", colors_of_values),
        ("occlusion", colors_of_classes),
        ("flow", colors_of_flow),
        ("flow_visibility", colors_of_classes),
        ("layer_count", colors_of_values),
    ):
        name = re.compile(rf"(pair\d\d-\d\d\.)?left\.{output}\.(png|npy|npy\.gz)")
        for file in sorted(filter(name.fullmatch, files))[:1]:
            found.append(_small(colored(read(file, files[file])), width))
    return np.vstack(found)


def _small(picture: Any, width: int) -> Any:
    """Returns a picture of this width, by the means of its pixels."""
    height = max(1, round(picture.shape[0] * width / picture.shape[1]))
    means = picture.astype(np.float64)
    for axis, side in enumerate((height, width)):
        length = picture.shape[axis]
        begins = np.minimum(np.linspace(0, length, side + 1).round().astype(int)[:-1], length - 1)
        # A smaller picture has the same pixel several times.
        counts = np.maximum(np.diff(begins, append=length), 1)
        means = np.add.reduceat(means, begins, axis) / np.expand_dims(counts, (1, 2) if axis == 0 else (0, 2))
    return means.round().astype(np.uint8)


def colors_of_classes(values: Any) -> Any:
    """Returns the colours of classes."""
    return CLASSES[np.minimum(values if values.ndim == 2 else values[..., 0], len(CLASSES) - 1)].astype(np.uint8)


def colors_of_flow(flow: Any, longest: float | None = None) -> Any:
    """Returns the colours of flow: the hue of its direction, white for none, and full colours from ``longest`` pixels.

    By default that is the length that 98 percent of the flow do not exceed."""
    known = np.isfinite(flow).all(axis=-1)
    x, y = np.where(known[..., None], flow, 0).transpose(2, 0, 1)
    speed = np.hypot(x, y)
    if longest is None:
        longest = float(np.percentile(speed[known], 98)) if known.any() else 0.0
    share = speed / max(longest, 1e-9)
    hue = np.arctan2(y, x)[..., None] + np.array([0, 2, -2]) * np.pi / 3
    color = 1 - np.minimum(share, 1)[..., None] * (0.5 - 0.5 * np.cos(hue))
    return np.where(known[..., None], 255 * color, 0).astype(np.uint8)


def colors_of_values(values: Any, limits: tuple[float, float] | None = None) -> Any:
    """Returns the colours of values, between limits or from the least to the largest one."""
    values = values.astype(np.float64)
    known = np.isfinite(values)
    low, high = limits or ((values[known].min(), values[known].max()) if known.any() else (0, 1))
    place = np.where(known, (values - low) / max(high - low, 1e-9), 0) * (len(RAMP) - 1)
    colors = [np.interp(place, np.arange(len(RAMP)), RAMP[:, channel]) for channel in range(3)]
    return np.where(known[..., None], np.stack(colors, axis=-1), 0).astype(np.uint8)


def main(arguments: list[str] | None = None) -> int:
    """Returns the exit status: 0, or 1 if the sheet can't be made."""
    parser = argparse.ArgumentParser(
        prog="python -m stereotrace.dataset.sheet", description="Shows the pairs of a data set as one picture."
    )
    parser.add_argument("folder", help="folder of the data set, or its URL")
    parser.add_argument("sheet", help="PNG file to write")
    parser.add_argument("--pairs", type=int, default=200, metavar="N", help="number of pairs [default: 200]")
    parser.add_argument("--width", type=int, default=160, metavar="PX", help="width of a picture [default: 160]")
    given = parser.parse_args(arguments)
    if given.pairs < 1 or not 1 <= given.width <= 4096:
        parser.error("--pairs must be 1 or more, and --width 1 to 4096")
    try:
        picture = sheet(given.folder, given.pairs, given.width)
        folder, name = os.path.split(given.sheet)
        Store(folder or ".").write(name, encode_png(picture))
    except (ImportError, ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    print(given.sheet)
    return 0


if __name__ == "__main__":
    sys.exit(main())
