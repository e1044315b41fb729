"""Reads the shards of a data set by the package webdataset, without stereotrace: pip install webdataset pillow numpy

python examples/read_webdataset.py 'out/pairs-{000000..000007}.tar'
"""

from __future__ import annotations

import sys

import numpy as np
import webdataset


def main(urls: str) -> None:
    # "rgb8" decodes PNG files to arrays, (height, width, 3). The three channels of a mask are equal.
    pairs = webdataset.WebDataset(urls, shardshuffle=False).decode("rgb8")
    count = 0
    for pair in pairs:
        arrays = {name: value for name, value in pair.items() if isinstance(value, np.ndarray)}
        if count == 0:
            for name, array in arrays.items():
                print(f"{name}: {array.dtype} {array.shape}")
            print("baseline", pair["json"]["camera"]["baseline"], "fx", pair["json"]["camera"]["left"]["fx"])
        assert all(np.asarray(array).size for array in arrays.values())
        count += 1
    print(f"{count} pairs")


if __name__ == "__main__":
    main(sys.argv[1])
