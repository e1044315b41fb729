"""Tests pairs of the views of camera arrays."""

from __future__ import annotations

import json
import tarfile

import numpy as np
import pytest

from stereotrace import MISS, dataset
from stereotrace.dataset.sheet import sheet
from stereotrace.dataset.verify import read, verify

OUTPUTS = ["color", "depth", "primitive"]


def test_views_of_a_row_are_pairs_with_ground_truth(renderer, hall):
    camera = hall.camera(size=(96, 64)).replace(screen_distance=np.inf, fov=50, interaxial=0.1)
    views = renderer.render_views(hall, camera, [-1, 0, 2], outputs=OUTPUTS)
    pair = renderer.pair_of(views, hall, 0, 2)
    assert np.array_equal(pair.left.color, views[0].color) and np.array_equal(pair.right.depth, views[2].depth)
    fx = camera.intrinsics["fx"]
    surface = pair.left.primitive != MISS
    assert pair.left.disparity[surface] == pytest.approx((fx * 0.3 / pair.left.depth)[surface], rel=1e-4)
    assert pair.camera.interaxial == pytest.approx(0.3) and (pair.left.occlusion == 0).mean() > 0.5
    assert pair.left.normal.shape == (64, 96, 3)
    with pytest.raises(ValueError, match="view 2 is not to the left of view 0"):
        renderer.pair_of(views, hall, 2, 0)
    with pytest.raises(ValueError, match="ground truth needs ids"):
        renderer.pair_of(renderer.render_views(hall, camera, 2, outputs=["color"]), hall, 0, 1)


def test_views_of_a_grid_have_vertical_pairs(renderer, hall):
    camera = hall.camera(size=(96, 64)).replace(screen_distance=np.inf, fov=50, interaxial=0.1)
    upper, lower = (renderer.render_views(hall, camera.raised(y), 2, outputs=OUTPUTS) for y in (0.1, -0.1))
    pair = renderer.pair_of(upper, hall, 1, 1, below=lower)
    assert np.array_equal(pair.left.color, np.rot90(upper[1].color))
    assert np.array_equal(pair.right.primitive, np.rot90(lower[1].primitive))
    surface = pair.left.primitive != MISS
    expected = camera.intrinsics["fy"] * 0.2 / pair.left.depth
    assert pair.left.disparity[surface] == pytest.approx(expected[surface], rel=1e-4)
    with pytest.raises(ValueError, match="the second view must be below the first one"):
        renderer.pair_of(lower, hall, 1, 1, below=upper)


ARRAY = {
    "pairs": 2,
    "size": [48, 32],
    "scenes": [{"builtin": "near"}],
    "poses": {"kind": "fixed"},
    "rig": {"interaxial": 0.1, "screen_distance": "inf", "array": {"columns": 3, "rows": 2, "pairs": "all"}},
    "render": {"method": "naive"},
    "outputs": ["color", "depth", "disparity", "left.occlusion", "layer_count", "normal"],
}


def array_spec(**changes):
    return dataset.Spec.load({**ARRAY, **changes})


def test_a_data_set_holds_an_array_of_cameras(tmp_path):
    made = array_spec()
    report = dataset.make(made, str(tmp_path))
    assert not report.errors and not list(verify(str(tmp_path)))
    with tarfile.open(tmp_path / "pairs-000000.tar") as tar:
        files = {entry.name.removeprefix("00000001."): tar.extractfile(entry).read() for entry in tar}
    load = lambda name: read(name, files[name])  # noqa: E731
    assert {name for name in files if name.endswith("depth.npy") and not name.startswith("0000")} == {
        f"camera{camera:02}.depth.npy" for camera in range(6)
    }
    pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 4), (2, 5), (3, 4), (3, 5), (4, 5)]
    assert sorted(json.loads(files["json"])["pairs"]) == [f"{one:02}-{other:02}" for one, other in pairs]
    # Each camera's picture is that of a camera at its place.
    pair, _ = dataset.Worker(made).pair(1)
    camera = pair.array[0, 1].camera
    step, lens = camera.interaxial, camera.intrinsics
    assert step == pytest.approx(0.1, abs=1e-6)
    row, column = np.mgrid[:32, :48]
    for one, other in pairs:
        name = f"pair{one:02}-{other:02}.left"
        disparity, depth = load(f"{name}.disparity.npy"), load(f"camera{one:02}.depth.npy")
        is_below = one // 3 != other // 3
        apart = step * (1 if is_below else other - one)
        known = np.isfinite(depth)
        focal = lens["fy"] if is_below else lens["fx"]
        assert np.abs(disparity - focal * apart / depth)[known].max() < 2e-4
        # Visible points have their depth at the place in the other camera's picture.
        there = [row - disparity * is_below + 0.5, column - disparity * (not is_below) + 0.5]
        there = [np.clip(np.nan_to_num(at).astype(int), 0, side - 1) for at, side in zip(there, (32, 48))]
        seen = known & (load(f"{name}.occlusion.png") == 0)
        ratio = load(f"camera{other:02}.depth.npy")[tuple(there)][seen] / depth[seen]
        assert seen.sum() > 300 and (np.abs(ratio - 1) < 0.05).mean() > 0.9
        assert (load(f"{name}.layer_count.npy") > 0)[known].all()
    picture = sheet(str(tmp_path), width=48)
    assert np.array_equal(picture[:32, 48:96], load("camera00.png")) and picture.shape[0] == 4 * 32
    # Camera 3 is below camera 0, and the same camera is in pairs of a row and of a column.
    assert np.array_equal(load("camera03.png"), pair.array[3, 4].left.color)
    assert np.array_equal(load("camera03.png"), np.rot90(pair.array[0, 3].right.color, -1))
    assert np.array_equal(load("camera04.normal.npy"), pair.array[3, 4].right.normal)


def test_positions_and_chosen_pairs(tmp_path):
    rig = {"interaxial": 0.1, "array": {"columns": [0, 1, 3.5], "pairs": [[0, 2], [1, 2]]}}
    made = array_spec(rig=rig, outputs=["color", "disparity"], pairs=1)
    pair, record = dataset.Worker(made).pair(0)
    assert sorted(pair.array) == [(0, 2), (1, 2)] and record["item"] == 0
    assert pair.array[0, 2].camera.interaxial == pytest.approx(0.35, abs=1e-6)
    assert pair.array[1, 2].camera.interaxial == pytest.approx(0.25, abs=1e-6)
    assert np.array_equal(pair.array[0, 2].right.color, pair.array[1, 2].right.color)
    column = array_spec(rig={"interaxial": 0.1, "array": {"columns": 1, "rows": 3}}, pairs=1)
    assert not dataset.make(column, str(tmp_path)).errors and not list(verify(str(tmp_path)))


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"columns": 1}, "rig.array: it has 1 cameras; 2 to 64 are possible"),
        ({"columns": 9, "rows": 9}, "rig.array: it has 81 cameras"),
        ({"columns": [0, 2, 1]}, "rig.array.columns: .* must be positions in ascending order"),
        ({"columns": 3, "pairs": [[0, 3]]}, r"rig.array.pairs\[0\]: there is no camera 3; there are 3, from 0"),
        ({"columns": 3, "pairs": [[1, 0]]}, r"rig.array.pairs\[0\]: \[1, 0\]: it must be a camera and another one"),
        ({"columns": 2, "rows": 2, "pairs": [[0, 3]]}, r"rig.array.pairs\[0\]: \[0, 3\]: it must be"),
        ({"columns": 2, "pairs": [[0, 1], [0, 1]]}, r"rig.array.pairs\[1\]: \[0, 1\] is there twice"),
        ({"columns": 3, "pairs": [[0, 1]]}, "rig.array.pairs: camera 2 is in no pair"),
        ({"columns": 3, "pairs": "some"}, "rig.array.pairs: unknown 'some'; use neighbours, first, all"),
        ({"columns": 3, "gap": 1}, "rig.array: unknown key 'gap'"),
    ],
)
def test_arrays_that_make_no_sense_are_refused(changes, text):
    with pytest.raises(ValueError, match=text):
        array_spec(rig={"array": changes})


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"motion": {}}, "motion: items with an array of cameras have no next pair"),
        ({"format": "kitti", "outputs": None}, "format: kitti holds two cameras"),
        ({"outputs": ["source"]}, "outputs: source: an array of cameras does not have it"),
        ({"outputs": ["match"]}, "outputs: match: an array of cameras does not have it"),
        ({"outputs": ["right.depth"]}, "outputs: depth: leave out the eye"),
    ],
)
def test_arrays_have_no_motion_and_no_layout(changes, text):
    given = {key: value for key, value in {**ARRAY, **changes}.items() if value is not None}
    with pytest.raises(ValueError, match=text):
        dataset.Spec.load(given)
