"""Tests lenses with distortion against OpenCV."""

from __future__ import annotations

import json
import pickle

import cv2
import numpy as np
import pytest

import stereotrace
from stereotrace import dataset
from stereotrace.dataset.verify import read, verify

SIZE = (96, 64)
RADIAL = {"fx": 60.0, "fy": 62.0, "cx": 48.4, "cy": 32.7, "radial_tangential": [-0.22, 0.04, 2e-3, -1e-3, 0.01]}
FISHEYE = {"fx": 55.0, "cx": 48.0, "cy": 32.0, "fisheye": [-0.02, 0.004, -1e-3, 1e-4]}


def camera_of(hall, **fields):
    return hall.camera(size=SIZE).replace(interaxial=0.2, **fields)


def matrix(lens):
    # OpenCV's pixel centres are at integers.
    fy = lens.get("fy", lens["fx"])
    return np.array([[lens["fx"], 0, lens["cx"] - 0.5], [0, fy, lens["cy"] - 0.5], [0, 0, 1]])


def projected(lens, points):
    points = points.reshape(-1, 1, 3)
    if "fisheye" in lens:
        found, _ = cv2.fisheye.projectPoints(points, np.zeros(3), np.zeros(3), matrix(lens), np.array(lens["fisheye"]))
    else:
        distortion = np.array(lens["radial_tangential"])
        found, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), matrix(lens), distortion)
    return found.reshape(-1, 2) + 0.5


@pytest.mark.parametrize("lens", [RADIAL, FISHEYE])
def test_points_are_projected_as_opencv_projects_them(hall, lens):
    camera = camera_of(hall, lens=lens)
    axes = np.array([camera.right, -np.array(camera.up), camera.forward])
    points = np.random.default_rng(3).uniform((-2, -1, 2), (2, 1, 5), (200, 3))
    expected = projected(lens, points)
    eye = np.array(camera.eye) - np.array(camera.right) * camera.interaxial / 2
    found = np.array([camera.project(eye + point @ axes)[:2] for point in points])
    assert np.abs(found - expected).max() < 1e-4


def test_maps_are_those_of_opencv(hall):
    camera = camera_of(hall, lens=RADIAL)
    k, distortion = matrix(RADIAL), np.array(RADIAL["radial_tangential"])
    expected = cv2.initUndistortRectifyMap(k, distortion, None, k, SIZE, cv2.CV_32FC1)
    for eye in ("left", "right"):
        maps = camera.rectify_map(eye)
        for found, wanted in zip(maps, expected, strict=True):
            assert found.shape == (64, 96) and found.dtype == np.float32
            assert np.abs(found - wanted).max() < 1e-4
    k = matrix(FISHEYE)
    expected = cv2.fisheye.initUndistortRectifyMap(k, np.array(FISHEYE["fisheye"]), np.eye(3), k, SIZE, cv2.CV_32FC1)
    for found, wanted in zip(camera_of(hall, lens=FISHEYE).rectify_map(), expected, strict=True):
        assert np.abs(found - wanted).max() < 1e-4


def test_remapped_pictures_are_those_of_the_rectified_camera(renderer, hall):
    camera = camera_of(hall, lens=RADIAL)
    rectified = camera.rectified()
    assert rectified.lens is None and rectified.intrinsics["cx0"] == RADIAL["cx"] == rectified.intrinsics["cx1"]
    raw = renderer.render(hall, camera, outputs=["color", "object"])
    ideal = renderer.render(hall, rectified, outputs=["color", "object", "disparity"])
    for eye, view, wanted in (("left", raw.left, ideal.left), ("right", raw.right, ideal.right)):
        x, y = camera.rectify_map(eye)
        found = cv2.remap(view.object.astype(np.float32), x, y, cv2.INTER_NEAREST, borderValue=-1)
        inside = found >= 0
        assert inside.mean() > 0.9
        # The nearest pixel may be beyond an edge.
        assert (found == wanted.object)[inside].mean() > 0.9


@pytest.mark.parametrize("lens", [RADIAL, FISHEYE, {"left": FISHEYE, "right": {**FISHEYE, "cx": 44.0}}])
def test_matches_show_the_same_objects(renderer, hall, lens):
    camera = camera_of(hall, lens=lens)
    pair = renderer.render(hall, camera, outputs=["depth", "object", "primitive", "occlusion", "normal"])
    found = renderer.correspondence(pair, hall)
    for own, other, matches in ((pair.left, pair.right, found.left), (pair.right, pair.left, found.right)):
        assert matches.place.shape == (64, 96, 2) and matches.place.dtype == np.float32
        visible = matches.visibility == 0
        assert 0.5 < visible.mean() < 1
        # Points behind another eye count as outside its picture.
        assert (np.minimum(matches.visibility, 2) == own.occlusion).all()
        # The nearest pixel may be beyond an edge.
        x, y = np.floor(matches.place[visible]).astype(int).T
        assert (other.object[y, x] == own.object[visible]).mean() > 0.9
    with pytest.raises(AttributeError, match="rows"):
        renderer.render(hall, camera, outputs=["disparity"]).left.disparity  # noqa: B018
    with pytest.raises(ValueError, match="name 'depth' in outputs"):
        renderer.correspondence(renderer.render(hall, camera, outputs=["color"]), hall)


def test_lenses_are_fields_of_cameras(hall):
    camera = camera_of(hall, lens=RADIAL)
    assert camera.lens["left"] == camera.lens["right"]
    assert camera.lens["left"]["radial_tangential"][:5] == RADIAL["radial_tangential"]
    assert pickle.loads(pickle.dumps(camera)) == camera
    assert camera_of(hall, lens=camera.lens) == camera
    assert camera_of(hall, lens={**RADIAL, "radial_tangential": np.array(RADIAL["radial_tangential"])}) == camera
    assert camera.replace(lens=None).lens is None
    assert camera_of(hall).lens is None and camera_of(hall).rectified() == camera_of(hall)
    with pytest.raises(ValueError, match="intrinsics"):
        camera.intrinsics  # noqa: B018
    with pytest.raises(ValueError, match="set the camera's lens"):
        camera_of(hall).rectify_map()
    with pytest.raises(ValueError, match="use left or right"):
        camera.rectify_map("middle")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"lens": 3}, "must be an object"),
        ({"lens": {"fx": 60}}, "cx of a lens is missing"),
        ({"lens": {**RADIAL, "radial_tangential": [1, 2]}}, "4, 5 or 8 coefficients"),
        ({"lens": {**RADIAL, "k1": 0}}, "no 'k1'"),
        ({"lens": {**RADIAL, "radial_tangential": [-0.9, 0, 0, 0]}}, "folds at pixel"),
        ({"lens": {**RADIAL, "radial_tangential": [float("nan"), 0, 0, 0]}}, "JSON"),
        ({"lens": {**RADIAL, "fx": object()}}, "camera: lens"),
        ({"lens": RADIAL, "fov": 40}, "lens and fov"),
        ({"lens": RADIAL, "toe_in": True}, "lens and toe_in"),
    ],
)
def test_bad_lenses_are_refused_by_name(hall, fields, message):
    with pytest.raises(ValueError, match=message):
        camera_of(hall, **fields)


@pytest.mark.parametrize("lens", [RADIAL, FISHEYE, None])
def test_data_sets_have_matches(renderer, hall, lens):
    spec = {
        "pairs": 2,
        "seed": 5,
        "size": list(SIZE),
        "scenes": [{"builtin": "hall"}],
        "rig": {"interaxial": 0.2, **({} if lens is None else {"lens": {**lens, "cx": {"uniform": [46, 50]}}})},
        "outputs": ["color", "match", "match_visibility", "left.object"],
    }
    loaded = dataset.Spec.load(spec)
    worker = dataset.worker.Worker(loaded)
    for item in range(2):
        pair, record = worker.pair(item)
        files = dataset.encode.files(pair, loaded, record)
        arrays = {name: read(name, data) for name, data in files.items()}
        camera = stereotrace.Camera.from_json(json.dumps(arrays["json"]["camera"]))
        assert (camera.lens is None) == (lens is None) and arrays["json"]["interaxial"] == pytest.approx(0.2)
        if lens is not None:
            assert 46 <= camera.lens["left"]["cx"] <= 50
        again = renderer.render(hall, camera, outputs=["depth", "object", "primitive"])
        found = renderer.correspondence(again, hall)
        assert np.array_equal(arrays["left.match.npy"], found.left.place, equal_nan=True)
        assert np.array_equal(arrays["right.match_visibility.png"], found.right.visibility)
        assert np.array_equal(arrays["left.object.npy"], again.left.object)
        assert pair.matches is not None and pair.matches.left.place.shape == (64, 96, 2)
    with pytest.raises(ValueError, match="use match and match_visibility"):
        dataset.Spec.load({**spec, "rig": {"lens": RADIAL}, "outputs": ["disparity"]})


def test_data_sets_of_lenses_are_read_back(tmp_path):
    lens = {**RADIAL, "radial_tangential": [{"uniform": [-0.2, 0]}, 0.02, 0, 0]}
    spec = {"pairs": 2, "size": list(SIZE), "scenes": [{"builtin": "hall"}], "rig": {"lens": lens}}
    report = dataset.make(dataset.Spec.load(spec), str(tmp_path / "set"))
    assert report.errors == [] and report.failed == []
    assert not list(verify(str(tmp_path / "set")))


def test_pairs_with_lenses_have_flow(tmp_path):
    spec = {
        "pairs": 1,
        "size": [64, 48],
        "scenes": [{"builtin": "near"}],
        "rig": {"interaxial": 0.1, "lens": {"fx": 60, "radial_tangential": [-0.2, 0.03, 0, 0]}},
        "motion": {"camera": {"right": 0.05, "turn": 2}},
        "outputs": ["color", "match", "flow", "flow_visibility", "next.color", "next.match", "next.flow"],
    }
    assert not dataset.make(dataset.Spec.load(spec), str(tmp_path)).errors and not list(verify(str(tmp_path)))
    pair, _ = dataset.Worker(dataset.Spec.load(spec)).pair(0)
    following, forward, _ = pair.motion
    # Carried by the flow, the next picture is the first one, where the point stays visible.
    row, column = np.mgrid[:48, :64]
    there = np.stack([column, row], axis=-1) + np.nan_to_num(forward.left.flow)
    carried = cv2.remap(following.left.color, there.astype(np.float32), None, cv2.INTER_LINEAR)
    seen = forward.left.visibility == 0
    apart = lambda other: np.abs(other.astype(float) - pair.left.color)[seen].mean()  # noqa: E731
    assert seen.mean() > 0.8 and apart(carried) < 0.5 * apart(following.left.color)
    with pytest.raises(ValueError, match="disparity_change: a lens moves points out of their rows"):
        dataset.Spec.load({**spec, "outputs": ["disparity_change"]})
    with pytest.raises(ValueError, match="motion.rolling: its bands are for planar pictures: leave out rig.lens"):
        dataset.Spec.load({**spec, "motion": {"rolling": {"readout": 1}}, "outputs": ["color"]})
