"""Tests the check of finished data sets, and the sheet of their pairs."""

from __future__ import annotations

import hashlib
import io
import json
import os
import shutil
import subprocess
import tarfile
from pathlib import Path
from typing import Callable

import numpy as np
import pytest

import stereotrace
from stereotrace import dataset
from stereotrace.dataset import sheet, verify


def made(folder: Path, **changes: object) -> Path:
    keys = {
        "pairs": 3,
        "shard_pairs": 2,
        "size": [64, 48],
        "scenes": [{"builtin": "near"}],
        "outputs": ["color", "disparity", "occlusion"],
        **changes,
    }
    spec = dataset.Spec.load({key: value for key, value in keys.items() if value is not None})
    assert not dataset.make(spec, str(folder)).errors
    return folder


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    """A data set that no test changes."""
    return made(tmp_path_factory.mktemp("verify") / "set")


@pytest.fixture
def folder(whole, tmp_path) -> Path:
    """A copy of the data set."""
    return Path(shutil.copytree(whole, tmp_path / "set"))


def rewritten(folder: Path, change: Callable[[str, bytes], bytes | None]) -> None:
    """Changes files of the first shard, and its record to fit the new bytes."""
    path, out = folder / "pairs-000000.tar", io.BytesIO()
    with tarfile.open(path) as old, tarfile.open(fileobj=out, mode="w") as new:
        for entry in old:
            file = old.extractfile(entry)
            assert file is not None
            data = change(entry.name, file.read())
            if data is not None:
                entry.size = len(data)
                new.addfile(entry, io.BytesIO(data))
    path.write_bytes(out.getvalue())
    record = json.loads((folder / "pairs-000000.json").read_text())
    record |= {"bytes": len(out.getvalue()), "sha256": hashlib.sha256(out.getvalue()).hexdigest()}
    (folder / "pairs-000000.json").write_text(json.dumps(record))


@pytest.mark.parametrize("changes", [{"compress": True}, {"format": "parquet"}])
def test_whole_data_sets_have_no_fault(tmp_path, capsys, changes):
    folder = made(tmp_path / "set", **changes)
    assert list(verify.verify(str(folder))) == []
    assert verify.main([str(folder)]) == 0 and "no fault" in capsys.readouterr().out


def test_layouts_are_checked_file_by_file(tmp_path):
    for layout in ("middlebury", "kitti"):
        folder = made(tmp_path / layout, format=layout, outputs=None)
        assert list(verify.verify(str(folder))) == []
        file = sorted(folder.rglob("*.png"))[0]
        name = file.relative_to(folder).as_posix()
        file.write_bytes(file.read_bytes()[:-1] + b"x")
        assert list(verify.verify(str(folder))) == [f"pairs-000000: {name}: its SHA-256 is not that of its record"]
        file.unlink()
        assert list(verify.verify(str(folder))) == [f"pairs-000000: {name}: no such file"]


def test_what_is_broken_is_named(folder, capsys):
    tar, whole = folder / "pairs-000000.tar", (folder / "pairs-000000.tar").read_bytes()

    def faults() -> list[str]:
        return list(verify.verify(str(folder)))

    tar.write_bytes(whole[:-1])
    assert faults()[0].startswith("pairs-000000: pairs-000000.tar: it has")
    flipped = bytearray(whole)
    flipped[700] ^= 1
    tar.write_bytes(flipped)
    assert "its SHA-256 is not that of its record" in faults()[0]
    tar.write_bytes(whole[:3000])
    assert any("pair 00000001: it is missing" in fault for fault in faults())
    tar.unlink()
    assert faults() == ["pairs-000000: pairs-000000.tar: no such file"]
    tar.write_bytes(whole)
    (folder / "pairs-000001.json").unlink()
    assert faults() == ["pairs-000001: it has not been made"]
    assert verify.main([str(folder)]) == 1 and "1 fault" in capsys.readouterr().out


def npy(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


@pytest.mark.parametrize(
    ("name", "data", "fault"),
    [
        ("00000001.left.png", b"no picture", "left.png: it can't be read"),
        ("00000001.left.png", stereotrace.encode_png(np.zeros((48, 64, 3), np.uint8)), "left.png: it is black"),
        ("00000001.right.png", None, "right: no such array"),
        ("00000001.left.disparity.npy", npy(np.zeros((48, 63), np.float32)), "its shape is (48, 63)"),
        ("00000001.left.disparity.npy", npy(np.full((48, 64), np.nan, np.float32)), "3072 values are NaN"),
        ("00000001.left.disparity.npy", b"", "left.disparity.npy: it can't be read"),
        ("00000001.json", b"{", "json: it can't be read"),
        ("00000001.json", None, "json: no such file"),
    ],
)
def test_broken_files_of_pairs_are_named(folder, name, data, fault):
    rewritten(folder, lambda known, old: data if known == name else old)
    found = list(verify.verify(str(folder)))
    assert len(found) == 1 and found[0].startswith("pairs-000000: pair 00000001: ") and fault in found[0], found


def test_a_folder_without_a_data_set_is_an_error(tmp_path, capsys):
    assert verify.main([str(tmp_path)]) == 1 and "so this is no data set" in capsys.readouterr().err
    (tmp_path / "dataset.json").write_text("{}")
    assert verify.main([str(tmp_path)]) == 1 and "does not belong to a data set" in capsys.readouterr().err


def test_a_sheet_shows_all_pairs(folder, tmp_path, capsys):
    picture = sheet.sheet(str(folder), width=32)
    # Three pairs of 32x24 pixels, each above its disparity and its occlusion.
    assert picture.shape[0] % 72 == 0 and picture.shape[1] % 32 == 0 and picture.any(axis=(0, 1)).all()
    shard = (folder / "pairs-000000.tar").read_bytes()
    _, files = next(verify.pairs(verify.spec_of(dataset.Store(str(folder))), shard))
    first = stereotrace.decode_png(files["left.png"])
    small = first.reshape(24, 2, 32, 2, 3).astype(float).mean(axis=(1, 3)).round()
    assert np.abs(picture[:24, :32].astype(float) - small).max() <= 1
    file = tmp_path / "sheet.png"
    assert sheet.main([str(folder), str(file), "--pairs", "2", "--width", "40"]) == 0
    assert stereotrace.decode_png(file.read_bytes()).shape[2] == 3
    assert sheet.main([str(tmp_path / "none"), str(file)]) == 1 and "no data set" in capsys.readouterr().err


def test_a_sheet_shows_flow_classes_and_layers_of_pairs_of_several_sizes(tmp_path):
    folder = made(
        tmp_path / "set",
        pairs=6,
        seed=3,
        size={"choice": [[64, 48], [64, 32]]},
        rig={"interaxial": 0.1, "screen_distance": ".inf"},
        motion={"camera": {"right": 0.3}},
        outputs=["color", "disparity", "flow", "flow_visibility", "layer_count"],
    )
    assert list(verify.verify(str(folder))) == []
    sizes = set()
    spec = verify.spec_of(dataset.Store(str(folder)))
    for name in sorted(file.name for file in folder.glob("*.tar")):
        for _, files in verify.pairs(spec, (folder / name).read_bytes()):
            sizes.add(stereotrace.decode_png(files["left.png"]).shape[:2])
    assert sizes == {(48, 64), (32, 64)}
    picture = sheet.sheet(str(folder), width=64)
    # The tallest pair has five pictures of 48 rows.
    assert picture.shape[0] % 240 == 0 and picture.shape[1] % 64 == 0
    colors = sheet.CLASSES.astype(np.uint8)
    assert all((picture == color).all(axis=-1).any() for color in colors[:3])
    # A camera that moves to the right moves all points to the left, which is cyan.
    flow = sheet.colors_of_flow(np.dstack([np.full((4, 4), -2.0), np.zeros((4, 4))]))
    assert flow[0, 0].tolist() == [0, 191, 191]
    assert sheet.colors_of_flow(np.full((2, 2, 2), np.nan)).max() == 0


def test_pictures_are_decoded_as_they_were_encoded():
    random = np.random.default_rng(1)
    for shape, dtype in (((5, 7, 3), np.uint8), ((5, 7, 4), np.uint8), ((5, 7), np.uint8), ((5, 7), np.uint16)):
        picture = random.integers(0, np.iinfo(dtype).max, shape, dtype)
        assert np.array_equal(stereotrace.decode_png(stereotrace.encode_png(picture)), picture)
    with pytest.raises(ValueError):
        stereotrace.decode_png(stereotrace.encode_png(np.ones((5, 7), np.uint8))[:40])


@pytest.mark.skipif("STEREOTRACE_COMMAND" not in os.environ, reason="scripts/check_python.sh builds the command")
@pytest.mark.parametrize("format", ["webdataset", "sintel", "middlebury"])
def test_the_command_reads_data_sets_back(tmp_path, format):
    is_layout = format in stereotrace.LAYOUTS
    outputs = None if is_layout else ["color", "disparity"]
    folder = made(tmp_path, format=format, name="small", outputs=outputs)

    def verified():
        command = [os.environ["STEREOTRACE_COMMAND"], "dataset", "verify", str(folder)]
        return subprocess.run(command, capture_output=True, text=True)

    assert verified().returncode == 0 and ": no fault in" in verified().stdout
    file = sorted(file for file in folder.rglob("*") if file.suffix in (".tar", ".png"))[-1]
    file.write_bytes(file.read_bytes()[:-1])
    (folder / "small-000000.json").unlink()
    faults = verified()
    assert faults.returncode == 1 and "small-000000: it has not been made" in faults.stdout
    assert f"{file.relative_to(folder)}: its SHA-256 is not that of its record" in faults.stdout
