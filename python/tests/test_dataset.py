"""Tests data sets: valid specs, their pairs, and that shards are written whole or not at all."""

from __future__ import annotations

import gzip
import io
import json
import os
import pickle
import resource
import signal
import subprocess
import sys
import tarfile
import threading
import time
from pathlib import Path

import cv2
import fsspec
import numpy as np
import pytest
from fsspec.implementations.memory import MemoryFileSystem

import stereotrace
from stereotrace import dataset
from stereotrace.dataset import OtherDataSet, Spec, SpecError, Worker
from stereotrace._stereotrace import PairMaker

SPEC = {
    "name": "small",
    "seed": 11,
    "pairs": 7,
    "shard_pairs": 3,
    "size": [48, 32],
    "scenes": [{"builtin": "near"}, {"builtin": "three-spheres", "weight": 2}],
    "rig": {"interaxial": {"uniform": [0.05, 0.2]}},
    "randomise": {
        "lights": {"count": {"uniform": [1, 3]}, "tint": {"uniform": [0.7, 1]}, "strength": {"log_uniform": [0.5, 1]}},
        "materials": {"share": 0.5, "tint": {"uniform": [0.4, 1.2]}},
        "exposure": {"uniform": [-0.5, 0.5]},
    },
}


def spec(**changes) -> Spec:
    return Spec.load({**SPEC, **changes})


def tar(path: Path) -> dict[str, bytes]:
    with tarfile.open(path) as file:
        return {entry.name: file.extractfile(entry).read() for entry in file}


def manifest(folder: Path) -> list[dict]:
    return [json.loads(line) for line in (folder / "manifest.jsonl").read_text().splitlines()]


def command(*arguments: object, **more) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "stereotrace.dataset", *map(str, arguments)], capture_output=True, text=True, **more
    )


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    report = dataset.make(spec(), str(folder))
    assert (report.made, report.kept, report.pairs, report.errors, report.failed) == (3, 0, 7, [], [])
    assert report.first_pair_seconds < report.seconds
    return folder


def test_shards_hold_what_the_spec_says(made):
    names = sorted(path.name for path in made.iterdir())
    shards = [f"small-{shard:06d}{ending}" for shard in range(3) for ending in (".json", ".tar")]
    assert names == sorted([*shards, "dataset.json", "manifest.jsonl"])
    lines = manifest(made)
    assert lines[0]["spec"]["seed"] == 11 and len(lines[0]["scenes"]) == 2
    pairs = [line for line in lines if "item" in line]
    assert [pair["item"] for pair in pairs] == list(range(7))
    assert len({pair["interaxial"] for pair in pairs}) == 7 and all(0.05 <= pair["interaxial"] <= 0.2 for pair in pairs)
    assert {pair["scene"] for pair in pairs} == {"builtin:near", "builtin:three-spheres"}
    files = tar(made / "small-000001.tar")
    kinds = [
        "left.png",
        "right.png",
        "left.disparity.npy",
        "right.disparity.npy",
        "left.occlusion.png",
        "right.occlusion.png",
        "json",
    ]
    assert list(files) == [f"{item:08d}.{kind}" for item in (3, 4, 5) for kind in kinds]
    picture = cv2.imdecode(np.frombuffer(files["00000004.left.png"], np.uint8), cv2.IMREAD_UNCHANGED)
    disparity = np.load(io.BytesIO(files["00000004.left.disparity.npy"]))
    assert picture.shape == (32, 48, 3) and disparity.shape == (32, 48) and disparity.dtype == np.float32
    camera = json.loads(files["00000004.json"])["camera"]
    assert camera["baseline"] == pairs[4]["interaxial"] and camera["width"] == 48


@pytest.mark.parametrize(
    ("origin", "expected"), [(None, (5e5, 0, 5.4e6)), ("none", (0, 0, 0)), ([4e5, 1, 5e6], (4e5, 1, 5e6))]
)
def test_a_scene_s_origin_is_the_spec_s(tmp_path, origin, expected):
    """Without an origin in the spec, it follows from the file's bounds."""
    path = tmp_path / "far.obj"
    path.write_text("v 500000 0 5400000\nv 500001 0 5400000\nv 500000 1 5400000\nf 1 2 3\n")
    scene = {"file": str(path)} | ({} if origin is None else {"origin": origin})
    found = PairMaker(spec(scenes=[scene]).checked, 0).scene(0)
    assert found.origin == pytest.approx(expected, abs=1)


def test_any_pair_can_be_made_again_alone(made):
    """Pairs have the same bytes on another renderer, in another order, and after other scenes."""
    worker = Worker(spec())
    for item in (5, 0, 3):
        pair, record = worker.pair(item)
        files = dataset.worker.encode.files(pair, spec(), record)
        there = tar(made / f"small-{item // 3:06d}.tar")
        for name, data in files.items():
            assert data == there[f"{item:08d}.{name}"], (item, name)


def test_other_shards_change_nothing(made, tmp_path):
    """Pairs are the same in shards of another size and in another format."""
    import pyarrow.parquet

    dataset.make(spec(shard_pairs=7, format="parquet"), str(tmp_path))
    rows = pyarrow.parquet.read_table(tmp_path / "small-000000.parquet").to_pylist()
    assert [row["item"] for row in rows] == list(range(7))
    for row in rows:
        there = tar(made / f"small-{row['item'] // 3:06d}.tar")
        assert all(row[name] == there[f"{row['key']}.{name}"] for name in row if name not in ("item", "key"))


def test_arrays_may_be_compressed(made, tmp_path):
    dataset.make(spec(compress=True, pairs=3), str(tmp_path))
    files, plain = tar(tmp_path / "small-000000.tar"), tar(made / "small-000000.tar")
    for name, data in plain.items():
        assert gzip.decompress(files[f"{name}.gz"]) == data if name.endswith("npy") else files[name] == data
    assert sum(map(len, files.values())) < 0.8 * sum(map(len, plain.values()))


def test_a_value_of_one_name_stays_when_others_are_added():
    one = PairMaker(spec().checked, 0)
    other = PairMaker(spec(poses={"kind": "orbit", "rise": {"uniform": [0, 20]}}, randomise={}).checked, 0)
    assert [one.scene_of(number) for number in range(50)] == [other.scene_of(number) for number in range(50)]
    # More values are drawn before and between those of the other spec.
    rig = {"screen_distance": {"uniform": [3, 4]}, **SPEC["rig"], "fov": {"uniform": [40, 50]}}
    materials = {"share": 0.5, "tint": {"uniform": [0.4, 0.9]}}
    workers = [
        Worker(spec(scenes=[{"builtin": "near"}], poses={"kind": "fixed"}, **more))
        for more in (
            {"randomise": {"ambient": {"uniform": [0, 1]}}},
            {"rig": rig, "randomise": {"materials": materials, "ambient": {"uniform": [0, 1]}}},
        )
    ]
    for item in range(3):
        records = [worker.pair(item)[1] for worker in workers]
        assert records[0]["interaxial"] == records[1]["interaxial"]
        assert workers[0].maker.scene(0).ambient == workers[1].maker.scene(0).ambient


def test_lights_and_materials_are_drawn():
    worker = Worker(spec(scenes=[{"builtin": "three-spheres"}], pairs=8))
    own = [material.albedo for material in worker.maker.scene(0).materials]
    lights, albedos = set(), set()
    for item in range(8):
        worker.pair(item)
        scene = worker.maker.scene(0)
        lights.add(len(scene.lights))
        albedos.add(tuple(material.albedo for material in scene.materials))
    assert lights == {1, 2, 3} and len(albedos) == 8
    plain = Worker(spec(scenes=[{"builtin": "three-spheres"}], randomise={}))
    plain.pair(0)
    assert [material.albedo for material in plain.maker.scene(0).materials] == own


def test_skies_are_given(tmp_path):
    (tmp_path / "sky.png").write_bytes(stereotrace.encode_png(np.full((4, 8, 3), (255, 0, 0), np.uint8)))
    corners = []
    for sky in ([0, 0, 1], str(tmp_path / "sky.png"), "procedural"):
        worker = Worker(spec(scenes=[{"builtin": "random-20", "sky": sky}], poses={"kind": "fixed"}, randomise={}))
        corners.append(worker.pair(0)[0].left.color[0, 24].tolist())
    assert corners[0] == [0, 0, 255] and corners[1] == [255, 0, 0] and len({tuple(corner) for corner in corners}) == 3


def test_orbits_go_round_what_they_look_at():
    worker = Worker(
        spec(
            scenes=[{"builtin": "spheres"}],
            poses={"kind": "orbit", "rise": {"uniform": [10, 30]}, "distance": {"uniform": [1, 2]}},
        )
    )
    given = stereotrace.Scene.builtin("spheres").camera(size=(48, 32))
    radius = np.linalg.norm(np.subtract(given.eye, given.target))
    for item in range(4):
        pair, _ = worker.pair(item)
        way = np.subtract(pair.camera.eye, given.target)
        assert radius * 0.999 <= np.linalg.norm(way) <= 2.001 * radius
        raised = np.degrees(
            np.arcsin(way[1] / np.linalg.norm(way)) - np.arcsin(np.subtract(given.eye, given.target)[1] / radius)
        )
        assert 9.9 <= raised <= 30.1
        assert np.allclose(np.array(pair.camera.forward), -way / np.linalg.norm(way), atol=1e-5)


@pytest.mark.parametrize("degrees", [360, 180])
def test_points_of_pairs_all_around_are_where_their_disparities_say(degrees, tmp_path):
    made = spec(
        pairs=2,
        scenes=[{"builtin": "hall"}],
        rig={"projection": degrees, "pole_merge": False, "interaxial": {"uniform": [0.2, 0.4]}},
        size=[256 * degrees // 360, 128],
        render={"method": "naive"},
        outputs=["disparity", "distance", "occlusion", "left.object", "right.object"],
    )
    assert dataset.make(made, str(tmp_path)).errors == []
    files = tar(tmp_path / "small-000000.tar")
    for item in range(2):
        load = lambda name: np.load(io.BytesIO(files[f"{item:08}.{name}.npy"]))  # noqa: B023, E731
        width = 256 * degrees // 360
        picture = np.frombuffer(files[f"{item:08}.left.occlusion.png"], np.uint8)
        seen = cv2.imdecode(picture, cv2.IMREAD_UNCHANGED) == 0  # visible to both
        row, column = np.nonzero(seen & np.isfinite(load("left.disparity")))
        there = column + 0.5 - load("left.disparity")[row, column]
        there = np.floor(there % 256 if degrees == 360 else there).astype(int)
        assert there.min() >= 0 and there.max() < width
        # Both eyes are equally far from a point, and see the same object there.
        far = load("left.distance")[row, column]
        assert np.mean(np.abs(load("right.distance")[row, there] / far - 1) < 0.05) > 0.95
        assert np.mean(load("left.object")[row, column] == load("right.object")[row, there]) > 0.95
        interaxial = json.loads(files[f"{item:08}.json"])["interaxial"]
        assert 0.2 <= interaxial <= 0.4
        # The disparity follows from the horizontal distance: twice the angle of half of the eyes' distance.
        level = (row >= 63) & (row <= 64) & np.isfinite(far)
        angles = 2 * np.arctan(interaxial / 2 / (far[level] * np.cos(np.pi / 256)))
        found = load("left.disparity")[row, column][level] * (2 * np.pi / 256)
        assert level.sum() > 50 and np.abs(found - angles).max() < 1e-4


@pytest.mark.parametrize("layout", stereotrace.LAYOUTS)
def test_layouts_are_folders(layout, tmp_path):
    around = {"rig": {"projection": 360}, "size": [48, 24]} if layout == "panorama" else {}
    made = spec(format=layout, pairs=2, shard_pairs=1, scenes=[{"builtin": "hall"}], **around)
    report = dataset.make(made, str(tmp_path))
    assert (report.made, report.errors, report.failed) == (2, [], [])
    left = {
        "middlebury": "small-000001/000001/im0.png",
        "kitti": "training/image_2/000001_10.png",  # there is one root for all shards
        "sceneflow": "small-000001/frames_finalpass/stereotrace/left/0001.png",
        "sintel": "training/final_left/000001/frame_0001.png",
        "panorama": "small-000001/000001/im0.png",
    }
    assert (tmp_path / left[layout]).is_file()
    assert not list(tmp_path.glob("*.part-*"))
    pairs = [line for line in manifest(tmp_path) if "item" in line]
    assert all(pair["disparity"][0] >= 0 for pair in pairs), "cameras are parallel where nothing is said"
    if layout == "kitti":
        assert sorted(path.name for path in tmp_path.iterdir() if path.is_dir()) == ["training"]
        assert [path.name for path in sorted((tmp_path / "training" / "disp_occ_0").iterdir())] == [
            "000000_10.png",
            "000001_10.png",
        ]
        picture = tmp_path / left[layout]
        before = picture.read_bytes()
        # The folder is as a killed process leaves it.
        (tmp_path / "small-000001.json").unlink()
        picture.unlink()
        again = dataset.make(made, str(tmp_path))
        assert (again.made, again.kept) == (1, 1) and picture.read_bytes() == before
        memory = dataset.Store("flaky://kitti")
        dataset.make(made, "flaky://kitti")
        assert memory.read(left[layout]) == before


@pytest.mark.skipif("STEREOTRACE_COMMAND" not in os.environ, reason="scripts/check_python.sh builds the command")
def test_the_command_makes_the_same_pairs(tmp_path):
    options = {"samples": 4, "adaptive": None, "shadow_rays": 3}
    made = Spec.load(
        {
            "seed": 5,
            "pairs": 2,
            "size": [48, 36],
            "format": "middlebury",
            "scenes": [{"builtin": "hall-finished"}],
            "poses": {"clearance": 0.3},
            "render": options,
        }
    )
    dataset.make(made, str(tmp_path / "package"))
    command = [os.environ["STEREOTRACE_COMMAND"], "dataset", "builtin:hall-finished", "--pairs", "2", "--size", "48x36"]
    command += ["--seed", "5", "--clearance", "0.3", "--samples", "4", "--shadow-rays", "3"]
    subprocess.run([*command, "--out", str(tmp_path / "command")], check=True, capture_output=True)
    for item in ("000000", "000001"):
        files = sorted((tmp_path / "package" / "pairs-000000" / item).iterdir())
        assert len(files) == 9
        for file in files:
            assert file.read_bytes() == (tmp_path / "command" / item / file.name).read_bytes(), file


def test_middlebury_has_no_disparity_below_0(tmp_path):
    """Loaders take absolute values, so converged cameras must be requested, and negative disparities are refused."""
    common = {
        "format": "middlebury",
        "pairs": 1,
        "scenes": [{"builtin": "spheres"}],
        "poses": {"kind": "fixed"},
        "randomise": {},
    }
    worker = Worker(spec(**common))
    pair, _ = worker.pair(0)
    pair.write(tmp_path)
    disparity = cv2.imread(str(tmp_path / "000000" / "disp0.pfm"), cv2.IMREAD_UNCHANGED)
    sky = cv2.imread(str(tmp_path / "000000" / "mask0sky.png"), cv2.IMREAD_UNCHANGED) == 255
    assert sky.any() and np.array_equal(np.isinf(disparity), sky) and (disparity[~sky] > 0).all()
    assert np.array_equal(disparity[~sky], pair.left.disparity[~sky])
    report = dataset.make(spec(**common, rig={"screen_distance": 2}), str(tmp_path / "converged"))
    assert "absolute value of a disparity" in report.errors[0]["error"]
    assert dataset.make(spec(**common, rig={"screen_distance": 1e4}), str(tmp_path / "behind")).errors == []


class ReadScenes:
    """The scenes that runs read, in order, by the makers that they create."""

    def __init__(self, monkeypatch) -> None:
        self._makers: list[PairMaker] = []

        def maker(*given) -> PairMaker:
            self._makers.append(PairMaker(*given))
            return self._makers[-1]

        monkeypatch.setattr(dataset.run, "PairMaker", maker)

    def taken(self) -> list[int]:
        """Returns the scenes read since the last call."""
        found = [scene for maker in self._makers for scene in maker.scenes_read]
        self._makers.clear()
        return found


def test_shards_read_each_scene_once(tmp_path, monkeypatch):
    """Pairs are made scene by scene, and are written in their own order."""
    builtins = ("near", "three-spheres", "spheres", "random-20")
    many = spec(
        scenes=[{"builtin": name} for name in builtins],
        pairs=24,
        shard_pairs=12,
        size=[16, 12],
        poses={"kind": "fixed"},
        randomise={},
    )
    read = ReadScenes(monkeypatch)
    dataset.make(many, str(tmp_path / "one"), scene_memory=0)
    opened = read.taken()
    assert sorted(opened[:4]) == list(range(4))
    # One scene is kept, with which each shard begins.
    assert len(opened) == 4 + 3 + 3, opened
    dataset.make(many, str(tmp_path / "all"))
    assert sorted(read.taken()) == list(range(4))
    for name in ("small-000000", "small-000001"):
        assert (tmp_path / "one" / f"{name}.tar").read_bytes() == (tmp_path / "all" / f"{name}.tar").read_bytes()
        record = json.loads((tmp_path / "one" / f"{name}.json").read_text())
        numbers = [pair["item"] for pair in record["pairs"]]
        assert numbers == sorted(numbers) and len(numbers) == 12
        keys = [entry.partition(".")[0] for entry in tar(tmp_path / "one" / f"{name}.tar")]
        assert keys == sorted(keys)
    # Pairs that wait on disk for their position give the same shard.
    monkeypatch.setattr(dataset.worker, "WAITING_MEMORY", 1)
    dataset.make(many, str(tmp_path / "disk"), shards=[1])
    assert (tmp_path / "disk" / "small-000001.tar").read_bytes() == (tmp_path / "all" / "small-000001.tar").read_bytes()


def test_scenes_stay_read_up_to_a_memory():
    many = spec(scenes=[{"builtin": "hall"}, {"builtin": "near"}, {"builtin": "spheres"}]).checked
    size = 3 * stereotrace.Scene.builtin("hall").memory
    for memory, asked, read in (
        (size + 2_000_000, (0, 1, 0, 2, 0, 1), [0, 1, 2]),
        (size - 1, (0, 1, 0, 2, 1, 2), [0, 1, 0, 2, 1]),
    ):
        maker = PairMaker(many, memory)
        for scene in asked:
            maker.scene_sha256(scene)
        assert maker.scenes_read == read and maker.has_scene(asked[-1])


def test_scenes_whose_files_are_as_they_were_are_not_read_again(tmp_path, monkeypatch):
    folder = tmp_path / "scenes"
    folder.mkdir()
    (folder / "a.mtl").write_text("newmtl a\nKd 1 0 0\n")
    (folder / "a.obj").write_text("mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    one = spec(scenes=[{"file": str(folder / "a.obj")}, {"builtin": "near"}], poses={"kind": "fixed"}, pairs=4)
    out = str(folder / "out")  # a data set among its scenes is not a scene
    read = ReadScenes(monkeypatch)
    dataset.make(one, out)
    assert read.taken()[:2] == [0, 1]
    assert dataset.make(one, out).kept == 2 and read.taken() == []
    # After a change of the time the file is read again. With the same content the run continues.
    os.utime(folder / "a.obj", ns=(1, 1))
    assert dataset.make(one, out).kept == 2 and read.taken() == [0]
    assert dataset.make(one, out).kept == 2 and read.taken() == []
    (folder / "a.mtl").write_text("newmtl a\nKd 0 1 0\n")
    with pytest.raises(OtherDataSet, match="a.obj has changed"):
        dataset.make(one, out)
    with pytest.raises(OtherDataSet, match="a.obj has changed"):
        dataset.make(one, out)


def test_runs_on_parts_end_with_a_manifest_of_all(made, tmp_path, monkeypatch):
    """Another run ends after this one has listed the shards, and before it writes the manifest."""
    out, other = str(tmp_path / "out"), []
    real = dataset.Store.writing

    def writing(self, name):
        if name == "manifest.jsonl" and not other:
            other.append(1)
            dataset.make(spec(), out, shards=[0, 2])
        return real(self, name)

    monkeypatch.setattr(dataset.Store, "writing", writing)
    assert dataset.make(spec(), out, shards=[1]).made == 1
    assert other and [line["item"] for line in manifest(tmp_path / "out") if "item" in line] == list(range(7))
    assert manifest(tmp_path / "out")[0] == manifest(made)[0]


def test_a_run_with_nothing_to_do_writes_nothing(tmp_path):
    out = tmp_path / "out"
    dataset.make(spec(pairs=4), str(out))
    times = {path.name: (path.stat().st_mtime_ns, path.stat().st_ino) for path in out.iterdir()}
    assert dataset.make(spec(pairs=4), str(out)).kept == 2
    assert dataset.make(spec(pairs=4), str(out), shards=[1]).kept == 1
    assert times == {path.name: (path.stat().st_mtime_ns, path.stat().st_ino) for path in out.iterdir()}
    # A manifest that a killed run did not write is written.
    (out / "manifest.jsonl").unlink()
    dataset.make(spec(pairs=4), str(out))
    assert [line["item"] for line in manifest(out) if "item" in line] == list(range(4))


def test_a_stopped_run_goes_on_with_what_is_missing(made, tmp_path):
    path = tmp_path / "spec.json"
    path.write_text(json.dumps({**SPEC, "pairs": 60}))
    process = subprocess.Popen(
        [sys.executable, "-m", "stereotrace.dataset", str(path), str(tmp_path / "out"), "--quiet"]
    )
    deadline = time.monotonic() + 120
    # A shard counts once its record exists. The record is written after the shard, so a kill may come between the two.
    while len(list((tmp_path / "out").glob("small-*.json"))) < 2:
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.01)
    process.kill()
    process.wait()
    there = {
        file.name: file.stat().st_mtime_ns
        for file in (tmp_path / "out").glob("*.tar")
        if file.with_suffix(".json").exists()
    }
    assert 2 <= len(there) < 20
    finished = command(path, tmp_path / "out")
    assert finished.returncode == 0, finished.stderr
    assert f"{len(there)} shards already existed" in finished.stdout
    names = sorted(file.name for file in (tmp_path / "out").iterdir())
    assert names == sorted(
        [*(f"small-{n:06d}{end}" for n in range(20) for end in (".json", ".tar")), "dataset.json", "manifest.jsonl"]
    )
    assert all((tmp_path / "out" / name).stat().st_mtime_ns == at for name, at in there.items())
    assert [line["item"] for line in manifest(tmp_path / "out") if "item" in line] == list(range(60))
    # The number of pairs does not change the existing pairs.
    for shard in range(2):
        name = f"small-{shard:06d}.tar"
        assert (tmp_path / "out" / name).read_bytes() == (made / name).read_bytes()


def test_other_specs_files_and_versions_are_not_gone_on_with(made, tmp_path, monkeypatch):
    with pytest.raises(OtherDataSet, match="a different spec: rig, seed"):
        dataset.make(spec(seed=12, rig={}), str(made))
    obj = tmp_path / "a.obj"
    obj.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    one = spec(scenes=[{"file": str(obj)}], poses={"kind": "fixed"}, pairs=1)
    dataset.make(one, str(tmp_path / "out"))
    obj.write_text("# a comment changes nothing\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert dataset.make(one, str(tmp_path / "out")).kept == 1
    obj.write_text("v 0 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n")
    with pytest.raises(OtherDataSet, match="a.obj has changed"):
        dataset.make(one, str(tmp_path / "out"))
    # A file is missing for a while, and comes back with other content.
    obj.unlink()
    assert dataset.make(one, str(tmp_path / "out")).kept == 1
    obj.write_text("v 0 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n")
    with pytest.raises(OtherDataSet, match="a.obj has changed"):
        dataset.make(one, str(tmp_path / "out"))
    monkeypatch.setattr(stereotrace, "__version__", "99.0.0")
    with pytest.raises(OtherDataSet, match="a different version of stereotrace"):
        dataset.make(spec(), str(made))


def test_a_pair_that_cannot_be_made_stops_nothing(tmp_path):
    """The manifest reports a scene that does not load and one without space for a camera. The other pairs are made."""
    (tmp_path / "broken.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 x\nf 1 2 3\n")
    scenes = [{"builtin": "near"}, {"file": str(tmp_path / "broken.obj")}]
    report = dataset.make(spec(scenes=scenes), str(tmp_path / "out"))
    assert report.made == 3 and report.errors and report.pairs + len(report.errors) == 7
    lines = manifest(tmp_path / "out")
    assert "broken.obj:3" in lines[0]["scenes"][1]["error"]
    errors = [line for line in lines if "error" in line]
    assert len(errors) == len(report.errors) and all(
        "broken.obj:3" in line["error"] and line["shard"] for line in errors
    )
    # They are missing until they are made, and every run reports that.
    assert [error["item"] for error in dataset.make(spec(scenes=scenes), str(tmp_path / "out")).errors] == [
        line["item"] for line in errors
    ]
    (tmp_path / "broken.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert dataset.make(spec(scenes=scenes), str(tmp_path / "out")).made == 0
    again = dataset.make(spec(scenes=scenes), str(tmp_path / "out"), retry_errors=True)
    assert again.made == len({line["shard"] for line in errors}) and not again.errors
    assert [line["item"] for line in manifest(tmp_path / "out") if "item" in line] == list(range(7))

    # The arrays do not exist in any pair of a shard.
    for kind in ("webdataset", "parquet"):
        # Without lights `auto` chooses naive, which has none of these arrays.
        dark = [{"builtin": "near", "lights": 0}]
        none = dataset.make(
            spec(pairs=2, format=kind, scenes=dark, randomise={}, outputs=["color", "shadow_source"]),
            str(tmp_path / kind),
        )
        assert (
            none.pairs == 0 and len(none.errors) == 2 and "only bracket methods provide it" in none.errors[0]["error"]
        )
    import pyarrow.parquet

    assert pyarrow.parquet.read_table(tmp_path / "parquet" / "small-000000.parquet").num_rows == 0

    nowhere = dataset.make(
        spec(poses={"kind": "free", "clearance": 1e6}, scenes=[{"builtin": "hall"}], pairs=1), str(tmp_path / "nowhere")
    )
    assert "no free camera position for item 0" in nowhere.errors[0]["error"]


def test_a_full_disk_is_told_and_gone_on_from(tmp_path):
    """No file may exceed 20 kB, so shards can't be written but heads can."""
    path = tmp_path / "spec.json"
    path.write_text(json.dumps(SPEC))

    def limited() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

    env = {**os.environ, "MESA_SHADER_CACHE_DISABLE": "true"}
    full = command(path, tmp_path / "out", preexec_fn=limited, env=env)
    assert full.returncode == 1 and "3 shards failed, the first is small-000000" in full.stdout, (
        full.stdout + full.stderr
    )
    failed = [line for line in manifest(tmp_path / "out") if "error" in line]
    assert [line["shard"] for line in failed] == [f"small-{shard:06d}" for shard in range(3)]
    assert all("large" in line["error"] for line in failed)
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["dataset.json", "manifest.jsonl"]
    assert command(path, tmp_path / "out").returncode == 0
    assert not any("error" in line for line in manifest(tmp_path / "out"))


class Flaky(MemoryFileSystem):
    """A storage that can't be reached for some files."""

    protocol = "flaky"
    store: dict = {}
    pseudo_dirs = [""]
    away: tuple[str, ...] = ()

    def _open(self, path, mode="rb", **more):
        if any(name in path for name in type(self).away):
            raise TimeoutError(f"{path}: the storage does not answer")
        return super()._open(path, mode, **more)


fsspec.register_implementation("flaky", Flaky)


class Counting(MemoryFileSystem):
    """A storage that counts listed files and the files that are read at once."""

    protocol = "counting"
    store: dict = {}
    pseudo_dirs = [""]
    listed = 0
    reading = 0
    most_reading = 0
    lock = threading.Lock()

    def ls(self, path, detail=True, **more):
        found = super().ls(path, detail=detail, **more)
        Counting.listed += len(found)
        return found

    def cat_file(self, path, *given, **more):
        with Counting.lock:
            Counting.reading += 1
            Counting.most_reading = max(Counting.most_reading, Counting.reading)
        time.sleep(0.002)
        try:
            return super().cat_file(path, *given, **more)
        finally:
            with Counting.lock:
                Counting.reading -= 1


fsspec.register_implementation("counting", Counting)


class NoWorker:
    """Makes the records of shards, but no pairs."""

    def __init__(self, spec: Spec, *_: object) -> None:
        self.spec = spec

    def shard(self, number: int, store: dataset.Store, *_: object) -> dict:
        record = {"shard": self.spec.shard_name(number), "pairs": [{"item": number}], "errors": []}
        store.write(f"{record['shard']}.json", json.dumps(record).encode())
        return record


def test_what_a_storage_is_asked_grows_with_the_shards_and_no_faster(monkeypatch):
    from stereotrace.dataset import on_ray

    monkeypatch.setattr(on_ray, "Worker", NoWorker)
    monkeypatch.setattr(on_ray, "_here", lambda: "here")
    listed = {}
    for shards in (100, 400):
        one = spec(pairs=shards, shard_pairs=1, scenes=[{"builtin": "near"}])
        out = f"counting://{shards}"
        data_set = dataset.DataSet(one, dataset.Store(out))
        maker = on_ray.ShardMaker(one.values, ".", data_set.hashes, out, {}, None, 1, "run", 0)
        Counting.listed = Counting.most_reading = 0
        rows = [maker._row(shard) for shard in range(shards)]
        assert all(row["tries"] == 1 for row in rows), rows[0]
        listed[shards] = Counting.listed
        assert data_set.write_manifest([]) == []
        assert 4 < Counting.most_reading <= 32
        lines = [json.loads(line) for line in data_set.store.read("manifest.jsonl").splitlines()]
        assert [line["item"] for line in lines if "item" in line] == list(range(shards))
    # If all marks were listed for each of 400 shards, it would be 160,000.
    assert listed[400] <= 4 * listed[100] + 100, listed
    # Tries are counted, up to one more than allowed.
    assert [maker._count_try("x") for _ in range(5)] == [1, 2, 3, 4, 4]


def test_a_shard_that_failed_elsewhere_stays_in_the_manifest(tmp_path):
    Flaky.away = ("small-000001",)
    dataset.make(spec(), "flaky://pairs/parts", shards=[0, 1])
    Flaky.away = ()
    dataset.make(spec(), "flaky://pairs/parts", shards=[2])
    lines = dataset.Store("flaky://pairs/parts").read("manifest.jsonl").splitlines()
    assert "does not answer" in json.loads(lines[-1])["error"]
    dataset.make(spec(), "flaky://pairs/parts")
    assert b"does not answer" not in dataset.Store("flaky://pairs/parts").read("manifest.jsonl")


def test_any_storage_of_fsspec(made):
    Flaky.away, store = ("small-000001",), dataset.Store("flaky://pairs/one")
    report = dataset.make(spec(), "flaky://pairs/one")
    assert report.made == 2 and [row["shard"] for row in report.failed] == ["small-000001"]
    assert "does not answer" in report.failed[0]["error"]
    lines = [json.loads(line) for line in store.read("manifest.jsonl").splitlines()]
    assert "does not answer" in lines[-1]["error"]
    Flaky.away = ()
    report = dataset.make(spec(), "flaky://pairs/one")
    assert (report.made, report.kept, report.failed) == (1, 2, [])
    for shard in range(3):
        name = f"small-{shard:06d}.tar"
        assert store.read(name) == (made / name).read_bytes()
    Flaky.away = ("dataset.json",)
    with pytest.raises(OSError, match="does not answer"):
        dataset.make(spec(), "flaky://pairs/two")
    Flaky.away = ()
    layout = spec(format="middlebury", pairs=1)
    dataset.make(layout, "flaky://pairs/layout")
    assert dataset.Store("flaky://pairs/layout").exists("small-000000/000000/im0.png")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"pear": 1}, "unknown key 'pear'; the keys are name, seed, pairs"),
        ({"pairs": None}, "pairs: it is missing"),
        ({"pairs": 0}, "pairs: 0 must be a whole number, 1 to"),
        ({"pairs": 1.5}, "pairs: 1.5 must be a whole number"),
        ({"name": "a/b"}, "name: 'a/b' must be at most 64 letters"),
        ({"format": "zip"}, "format: unknown 'zip'; use one of webdataset, parquet, middlebury"),
        ({"size": [640]}, r"size: \[640\] must be a list of 2"),
        ({"scenes": []}, "scenes: at least one scene must have a weight above 0"),
        ({"scenes": [{}]}, r"scenes\[0\]: give a file, the name of a built-in scene, or the kind of"),
        ({"scenes": [{"builtin": "halle"}]}, r"scenes\[0\].builtin: unknown 'halle'"),
        ({"scenes": [{"builtin": "hall", "weight": -1}]}, r"scenes\[0\].weight"),
        ({"scenes": [{"builtin": "hall", "camera": {"eye": [0, 0, 0]}}]}, "give both eye and target"),
        ({"scenes": [{"builtin": "hall", "lights": [{"intensity": 1}]}]}, r"scenes\[0\].lights\[0\]: give a position"),
        ({"scenes": [{"builtin": "hall", "sky": [1, 2]}]}, r"scenes\[0\].sky: \[1,2\] must be a list of 3"),
        ({"poses": {"kind": "walk"}}, "poses.kind: unknown 'walk'; use one of free, orbit, fixed"),
        ({"poses": {"kind": "fixed", "clearance": 1}}, "poses: unknown key 'clearance'; the keys are kind"),
        ({"rig": {"interaxial": {"uniform": [2, 1]}}}, "rig.interaxial.uniform: .* low and a high"),
        (
            {"rig": {"interaxial": {"gauss": [2, 1]}}},
            "rig.interaxial: .* one key: uniform, log_uniform, normal, choice",
        ),
        ({"rig": {"interaxial": {"log_uniform": [0, 1]}}}, "above 0"),
        ({"rig": {"interaxial": 1, "interaxial_px": 2}}, "set the same value"),
        ({"rig": {"interaxial_px": 2, "screen_distance": "inf"}}, "which is 0 for parallel cameras"),
        ({"rig": {"interaxial_px": 2}, "format": "kitti"}, "which is 0 for parallel cameras"),
        ({"rig": {"fov": 10**400}}, "rig.fov: .* must be a number"),
        ({"render": {"method": "atomic"}}, "render.method: atomic shows points up to half a pixel off, but occlusion"),
        ({"render": {"method": "atomic"}, "format": "kitti"}, "render.method: atomic"),
        (
            {"render": {"method": "naive"}, "outputs": ["shadow_source"]},
            "shadow_source needs a bracket method, not naive",
        ),
        ({"randomise": {"lights": {"radius": {"uniform": [-1, 1]}}}}, "radius.uniform.0.: -1 must be 0 or more"),
        ({"randomise": {"materials": {"albedo": 5}}}, "randomise.materials.albedo: 5 must be 0 to 1"),
        ({"rig": {"fov": float("nan")}}, "rig.fov: nan must be a number"),
        (
            {"randomise": {"lights": {"count": {"uniform": [1, 40]}}}},
            r"randomise.lights.count.uniform\[1\]: 40 must be a whole number, 1 to 16",
        ),
        ({"randomise": {"lights": {"count": 0}}}, "randomise.lights.count: 0 must be a whole number, 1 to 16"),
        ({"randomise": {"materials": {"albedo": 1, "tint": 1}}}, "give one of them"),
        ({"render": {"sample": 4}}, "render: unknown option 'sample'"),
        ({"render": {"outputs": ["color"]}}, "render.outputs: use the key outputs"),
        ({"outputs": ["colour"]}, r"outputs\[0\]: unknown 'colour'; use one of color"),
        ({"outputs": ["left.source"]}, "source exists only for the right view"),
        ({"outputs": "color"}, "outputs: 'color' must be a list"),
        ({"outputs": ["color"], "format": "kitti"}, "the layout kitti sets the files"),
        ({"compress": True, "format": "middlebury"}, "compress: the layout middlebury sets"),
        ({"compress": 1}, "compress: 1 must be true or false"),
        ({"pairs": 10_001, "format": "sceneflow"}, "at most 10000"),
        ({"rig": {"interaxial": -0.1}}, "rig.interaxial: -0.1 must be 0 or more"),
        ({"rig": {"interaxial": {"uniform": [-0.1, 1]}}}, r"rig.interaxial.uniform\[0\]: -0.1 must be 0 or more"),
        ({"rig": {"interaxial": {"choice": [1, -1]}}}, r"rig.interaxial.choice\[1\]: -1 must be 0 or more"),
        ({"rig": {"interaxial_px": -1}}, "rig.interaxial_px: -1 must be 0 or more"),
        ({"rig": {"baseline": -1}}, "rig.baseline: -1 must be 0 or more"),
        ({"rig": {"fov": 180}}, "rig.fov: 180 must be above 0 and below 180"),
        ({"rig": {"fov": {"uniform": [0, 60]}}}, r"rig.fov.uniform\[0\]: 0 must be above 0"),
        ({"rig": {"fov": {"uniform": [30, 200]}}}, r"rig.fov.uniform\[1\]: 200 must be above 0 and below 180"),
        ({"rig": {"screen_distance": -2}}, "rig.screen_distance: -2 must be above 0"),
        ({"rig": {"screen_distance": 5}, "format": "kitti"}, "rig.screen_distance: the cameras of kitti are parallel"),
        (
            {"rig": {"screen_distance": {"choice": ["inf", 5]}}, "format": "sceneflow"},
            "the cameras of sceneflow are parallel",
        ),
        ({"rig": {"interaxial_px": 2}, "format": "middlebury"}, "which is 0 for parallel cameras"),
        ({"rig": {"fx": 500, "fov": 40}}, "rig: fov and fx set the same value"),
        ({"rig": {"interaxial": 1, "baseline": 1}}, "rig: interaxial and baseline set the same value"),
        ({"rig": {"cx": 500}}, "rig.cx: it needs fx"),
        ({"rig": {"projection": 270}}, "rig.projection: unknown 270; use planar, 360 or 180"),
        ({"rig": {"projection": 360}}, "size: the width of a picture of 360 degrees must be twice the height"),
        ({"rig": {"projection": 360, "fov": 40}}, "rig.fov: it is for planar pictures"),
        ({"rig": {"projection": 180, "pole_merge": [75, 60]}}, "rig.pole_merge: it must be false, or two elevations"),
        ({"rig": {"pole_merge": False}}, "rig.pole_merge: only equirectangular pictures have poles"),
        ({"format": "panorama"}, "the pictures of panorama are equirectangular: set rig.projection"),
        ({"rig": {"projection": 360}, "format": "kitti"}, "the pictures of kitti are planar"),
        ({"rig": {"fx": 0}}, "rig.fx: 0 must be above 0"),
        ({"rig": {"fx": 100, "interaxial_px": 2}}, "which is 0 for parallel cameras"),
        ({"poses": {"min_surfaces": 1.1}}, "poses.min_surfaces: 1.1 must be 0 to 1"),
        ({"poses": {"clearance": -1}}, "poses.clearance: -1 must be 0 or more"),
        ({"poses": {"clearance": {"uniform": [-1, 1]}}}, r"poses.clearance.uniform\[0\]: -1 must be 0 or more"),
        ({"poses": {"max_disparity": 0}}, "poses.max_disparity: 0 must be above 0"),
        (
            {"poses": {"kind": "orbit", "distance": {"uniform": [0, 1]}}},
            r"poses.distance.uniform\[0\]: 0 must be above 0",
        ),
        ({"scenes": [{"file": "a.obj", "crease_angle": 200}]}, r"scenes\[0\].crease_angle: 200 must be 0 to 180"),
        (
            {"scenes": [{"file": "a.obj", "origin": "there"}]},
            r"scenes\[0\].origin: unknown 'there'; use one of auto, none",
        ),
        ({"scenes": [{"file": "a.obj", "origin": [0, 1]}]}, r"scenes\[0\].origin: .* must be a list of 3"),
        ({"scenes": [{"builtin": "hall", "origin": "none"}]}, r"scenes\[0\]: origin is an option for files"),
        (
            {"scenes": [{"builtin": "hall", "camera": {"eye": [0, 0, 0], "target": [0, 0, 0]}}]},
            r"camera.target: \[0.0,0.0,0.0\] must differ from the eye",
        ),
        ({"scenes": [{"builtin": "hall", "camera": {"up": [0, 0, 0]}}]}, r"scenes\[0\].camera.up: it must not be 0"),
        (
            {"scenes": [{"builtin": "hall", "lights": [{"towards": [0, 0, 0], "intensity": 1}]}]},
            r"lights\[0\].towards: it must not be 0",
        ),
        ({"randomise": {"exposure": 65}}, "randomise.exposure: 65 must be -64 to 64"),
        (
            {"rig": {"fov": 10**5000}},
            "rig.fov: a number with too many digits must be a number|rig.fov: 1000.* must be a number",
        ),
    ],
)
def test_specs_that_say_something_wrong(changes, message):
    with pytest.raises(SpecError, match=message):
        Spec.load({key: value for key, value in {**SPEC, **changes}.items() if value is not None})


def test_specs_of_files(tmp_path):
    path = tmp_path / "spec.yaml"
    path.write_text("pairs: 2\nscenes: [{builtin: hall}]\nrig: {screen_distance: inf, interaxial: 6e-2}\n")
    found = Spec.load(path)
    assert found["rig"] == {"screen_distance": "inf", "interaxial": 0.06} and found["outputs"] == [
        "color",
        "disparity",
        "occlusion",
    ]
    assert found.sha256() == Spec.load({**found.values}).sha256()
    for text, message in (
        ("pairs: [", "spec.yaml: invalid YAML"),
        ("- 1", "spec.yaml: it must be a mapping"),
        ("pairs: x", "spec.yaml: pairs: 'x'"),
    ):
        path.write_text(text)
        with pytest.raises(SpecError, match=message):
            Spec.load(path)
        failed = command(path, tmp_path / "out")
        assert failed.returncode == 1 and message in failed.stderr and "Traceback" not in failed.stderr
    assert not (tmp_path / "out").exists()
    assert "No such file" in command(tmp_path / "none.yaml", tmp_path / "out").stderr
    path.write_text("pairs: 2\nscenes: [{builtin: near}]\nsize: [32, 24]\n")
    (tmp_path / "file").write_text("")
    for arguments, message in (
        ((path, tmp_path / "file" / "out"), "file"),
        ((path, tmp_path / "out", "--adapter", "Voodoo2"), "no graphics adapter found"),
        ((path, tmp_path / "out", "--shards", "0..3"), "shard 1: the data set has 1"),
        ((path, tmp_path / "out", "--item", "2"), "has the items 0 to 1"),
        ((path, "nothing://x"), "nothing"),
    ):
        failed = command(*arguments)
        assert failed.returncode == 1 and message in failed.stderr and "Traceback" not in failed.stderr, failed.stderr


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("pairs: 1:30\n", "pairs: '1:30' must be a whole number"),
        ("pairs: 190:20:30.5\n", "pairs: '190:20:30.5' must be a whole number"),
        ("pairs: 2\nscenes: [{builtin: hall}]\nrig: {fov: 1:30}\n", "rig.fov: '1:30' must be a number"),
        ("pairs: 2\nseed: 1\npairs: 3\n", "line 3: the key 'pairs' occurs twice"),
        ("pairs: 2\nrig: {fov: 40, fov: 50}\n", "line 2: the key 'fov' occurs twice"),
        ("pairs: 2\nscenes: [{builtin: hall}]\ncompress: yes\n", "compress: 'yes' must be true or false"),
        ("pairs: " + 9000 * "9" + "\n", "line 1: .*99"),
        ("pairs: " + 40 * "[" + 40 * "]" + "\n", "line 1: lists and mappings are nested more than 32"),
        ("pairs: " + 100_000 * "[" + "\n", "line 1: lists and mappings are nested more than 32"),
        ("".join(f"{level * ' '}a:\n" for level in range(100)), "nested more than 32"),
        ("pairs: &a [*a]\n", "nested more than 32"),
        ("&a {pairs: *a}\n", "nested more than 32"),
        (
            "a: &a [1,1,1,1,1,1,1,1,1,1]\n"
            + "".join(f"{b}: &{b} [{','.join(10 * ['*' + a])}]\n" for a, b in zip("abcdefgh", "bcdefghi"))
            + "pairs: *i\n",
            "over 1000000 values",
        ),
        ("pairs: 2\nscenes: !!python/object/apply:os.system [ls]\n", "invalid YAML"),
        ("pairs: \x00\n", "invalid YAML"),
    ],
)
def test_yaml_that_means_something_else_is_refused(tmp_path, text, message):
    path = tmp_path / "spec.yaml"
    path.write_text(text)
    with pytest.raises(SpecError, match=message) as caught:
        Spec.load(path)
    assert len(str(caught.value)) < 2000


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"pairs": 1, "pairs": 2}', "the key 'pairs' occurs twice"),
        ('{"pairs": 1, "rig": {"fov": 1, "fov": 2}}', "the key 'fov' occurs twice"),
        (40 * '{"a":' + "1" + 40 * "}", "nested more than 32"),
        (200_000 * "[", "nested more than 32|invalid JSON"),
        ('{"pairs": ' + 9000 * "9" + "}", "invalid JSON"),
        ('{"pairs": NaN}', "pairs: nan must be a number"),
        ("{", "spec.json: invalid JSON"),
    ],
)
def test_json_that_means_something_else_is_refused(tmp_path, text, message):
    path = tmp_path / "spec.json"
    path.write_text(text)
    with pytest.raises(SpecError, match=message):
        Spec.load(path)


def test_what_yaml_and_dicts_may_say(tmp_path):
    path = tmp_path / "spec.yaml"
    path.write_text(
        "pairs: 1_000\nseed: 010\nrig: {<<: {fov: 40, interaxial: 1}, fov: 5e1}\n"
        "compress: TRUE\nname: on\nscenes: [{builtin: hall}]\n"
    )
    found = Spec.load(path)
    assert (found["pairs"], found["seed"], found["rig"], found["compress"], found["name"]) == (
        1000,
        10,
        {"interaxial": 1.0, "fov": 50.0},
        True,
        "on",
    )
    deep: dict = {}
    inner = deep
    for _ in range(5000):
        inner["a"] = {}
        inner = inner["a"]
    itself: dict = {"pairs": 1}
    itself["rig"] = itself
    for wrong in (deep, itself):
        with pytest.raises(SpecError, match="nested more than 32 levels deep"):
            Spec.load(wrong)
    with pytest.raises(SpecError, match="it is not a regular file"):
        Spec.load(tmp_path)


def test_rigs_of_calibrations():
    lens = {"fx": 40.0, "fy": 41.0, "cx": 25.5, "cy": 15.25, "baseline": {"uniform": [0.1, 0.2]}}
    for kind in ("webdataset", "kitti"):
        pair, record = Worker(spec(rig=lens, format=kind, scenes=[{"builtin": "hall"}])).pair(0)
        found = pair.camera.intrinsics
        assert {name: round(value, 9) for name, value in found.items()} == {
            "fx": 40,
            "fy": 41,
            "cx0": 25.5,
            "cx1": 25.5,
            "cy": 15.25,
        }
        assert 0.1 <= record["interaxial"] <= 0.2 and np.isinf(pair.camera.screen_distance)
    pair, _ = Worker(
        spec(rig={"fx": 30, "screen_distance": 4}, scenes=[{"builtin": "hall"}], poses={"kind": "fixed"})
    ).pair(0)
    found = pair.camera.intrinsics
    assert found["fx"] == found["fy"] == 30 and (found["cx0"] + found["cx1"]) / 2 == 24 and found["cy"] == 16
    assert pair.camera.screen_distance == 4 and pair.camera.interaxial > 0


def test_places_with_colons_and_one_pair_of_a_layout(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    dataset.make(spec(pairs=1), "a::b %")
    assert (tmp_path / "a::b %" / "small-000000.tar").is_file()
    path = tmp_path / "spec.json"
    path.write_text(json.dumps({**SPEC, "format": "middlebury"}))
    found = command(path, "memory://x", "--item", 5)
    assert found.returncode == 0 and "memory:///x/000005/im0.png" in found.stdout, found.stdout + found.stderr
    assert not (tmp_path / "memory:").exists()


def test_packages_that_are_not_there_are_named(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(
        "import sys\nfor name in ('yaml', 'tqdm', 'fsspec', 'ray', 'pyarrow', 'trimesh'):\n"
        "    sys.modules[name] = None\n"
    )
    env = {**os.environ, "PYTHONPATH": str(tmp_path)}
    run = lambda text: subprocess.run(  # noqa: E731
        [sys.executable, "-c", text], env=env, capture_output=True, text=True
    )
    assert run("import stereotrace, stereotrace.dataset").returncode == 0
    assert "pip install 'stereotrace[trimesh]'" in run("import stereotrace; stereotrace.from_trimesh(None)").stderr
    path = tmp_path / "spec.yaml"
    path.write_text("pairs: 1\nscenes: [{builtin: near}]\n")
    failed = command(path, tmp_path / "out", env=env)
    assert (
        failed.returncode == 1
        and "pip install 'stereotrace[dataset]'" in failed.stderr
        and "Traceback" not in failed.stderr
    )


def test_outputs_of_eyes():
    assert spec(outputs=["color", "left.normal", "source"]).checked.arrays == [
        ("left", "color"),
        ("right", "color"),
        ("left", "normal"),
        ("right", "source"),
    ]


def test_values_of_dicts_that_json_lacks(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    found = Spec.load({"pairs": np.int64(2), "size": np.array([64, 48]).tolist(), "scenes": ({"file": path},)})
    assert (found["pairs"], found["scenes"][0]["file"]) == (2, str(path))
    for wrong in (b"a.obj", object(), float("nan"), 2**64):
        with pytest.raises(SpecError, match=r"^scenes\[0\].file: .* must be "):
            Spec.load({"pairs": 1, "scenes": [{"file": wrong}]})


def test_specs_can_be_pickled():
    one = spec()
    assert one.checked.arrays
    again = pickle.loads(pickle.dumps(one))
    assert again == one and again.folder == one.folder and again.checked.arrays == one.checked.arrays
