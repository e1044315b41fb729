"""Tests animations and flow."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import stereotrace
from stereotrace import dataset

SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
FACES = np.array([[0, 1, 2], [0, 2, 3]])


def square() -> stereotrace.Scene:
    scene = stereotrace.Scene()
    scene.add_mesh(SQUARE, FACES)
    return scene


def pair_of(renderer, scene, camera):
    return renderer.render(scene, camera, outputs=["depth", "primitive", "disparity"])


def test_flow_of_a_static_scene_follows_from_depth_and_pose(renderer, hall):
    camera = hall.camera(size=(96, 64))
    moved = camera.replace(eye=np.add(camera.eye, (0.05, 0.02, -0.1)), target=np.add(camera.target, (0.2, 0.1, 0)))
    pair = pair_of(renderer, hall, camera)
    flow = renderer.flow(pair, hall, hall, moved)
    for eye, view, found in (("left", pair.left, flow.left), ("right", pair.right, flow.right)):
        side = -1 if eye == "left" else 1
        forward = np.array(camera.target) - camera.eye
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, (0, 1, 0))
        right /= np.linalg.norm(right)
        up = np.cross(right, forward)
        lens = camera.intrinsics
        cx = lens["cx0"] if side < 0 else lens["cx1"]
        x, y = np.meshgrid(np.arange(96) + 0.5, np.arange(64) + 0.5)
        rays = ((x - cx) / lens["fx"])[..., None] * right - ((y - lens["cy"]) / lens["fy"])[..., None] * up + forward
        points = np.array(camera.eye) + right * side * camera.interaxial / 2 + view.depth[..., None] * rays
        assert found.flow.shape == (64, 96, 2) and found.flow.dtype == np.float32
        for row, column in ((5, 7), (31, 50), (60, 90), (40, 10)):
            place = moved.project(points[row, column], eye)
            expected = [place[0] - x[row, column], place[1] - y[row, column]]
            assert found.flow[row, column] == pytest.approx(expected, abs=2e-3)
        assert not found.displacement.any() and found.visibility.max() <= 2
        assert (found.visibility == 0).mean() > 0.8


def test_objects_that_move_carry_their_points(renderer):
    scene, camera = square(), stereotrace.Camera((0, 0, 5), (0, 0, 0), size=(40, 40))
    pair = pair_of(renderer, scene, camera)
    then = scene.copy()
    then.set_mesh(0, SQUARE * (1, 1, 1) + (0.5, 0, 1), FACES)
    flow = renderer.flow(pair, scene, then).left
    on = pair.left.primitive != stereotrace.MISS
    assert np.allclose(flow.displacement[on], (0.5, 0, 1)) and not flow.displacement[~on].any()
    assert (flow.disparity_change[on] > 0).all() and (flow.disparity_change[~on] == 0).all()
    assert np.array_equal(then.triangles, (SQUARE + np.float32((0.5, 0, 1)))[FACES])
    with pytest.raises(ValueError, match="has 1 triangles instead of 2"):
        then.set_mesh(0, SQUARE, FACES[:1])
        renderer.flow(pair, scene, then)
    with pytest.raises(ValueError, match="'primitive' in outputs"):
        renderer.flow(renderer.render(scene, camera), scene, scene)


def animated(folder: Path) -> Path:
    numbers = np.concatenate([SQUARE.ravel(), [0, 2], [0, 0, 0, 1, 0, 0]]).astype("<f4").tobytes()
    (folder / "a.bin").write_bytes(numbers)
    camera = {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}
    slide = {
        "name": "slide",
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": 1, "output": 2}],
    }
    views = [{"buffer": 0, "byteOffset": begin, "byteLength": size} for begin, size in ((0, 48), (48, 8), (56, 24))]
    accessors = [
        {"bufferView": place, "componentType": 5126, "type": kind, "count": count}
        for place, (kind, count) in enumerate((("VEC3", 4), ("SCALAR", 2), ("VEC3", 2)))
    ]
    file = {
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "cameras": [camera],
        "nodes": [{"mesh": 0, "children": [1]}, {"camera": 0, "translation": [0, 0, 4], "name": "eye"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6}]}], "animations": [slide],
        "buffers": [{"byteLength": len(numbers), "uri": "a.bin"}], "bufferViews": views, "accessors": accessors,
    }
    path = folder / "a.gltf"
    path.write_text(json.dumps(file))
    return path


def test_animations_pose_objects_and_cameras(tmp_path):
    scene = stereotrace.Scene.open(animated(tmp_path))
    assert scene.animations == [("slide", 2.0)]
    rest = scene.triangles
    copy = scene.copy()
    for animation in (None, 0, "slide"):
        copy.pose(1.0, animation)
        assert np.allclose(copy.triangles, rest + np.float32((0.5, 0, 0)))
        assert copy.camera("eye").eye == pytest.approx((0.5, 0, 4))
        copy.pose(9.0, animation)
        assert np.allclose(copy.triangles, rest + np.float32((1, 0, 0)))
    assert np.array_equal(scene.triangles, rest) and scene.camera("eye").eye == (0, 0, 4)
    unknown = "no animation 'walk' in this scene; its animations are: slide"
    for animation, text in ((3, "no animation 3"), ("walk", unknown)):
        with pytest.raises(ValueError, match=text):
            scene.pose(0.0, animation)
    with pytest.raises(ValueError, match="its time is NaN"):
        scene.pose(float("nan"))
    with pytest.raises(ValueError, match="its animations are: none"):
        square().pose(0.0)


def moving(folder: Path, **changes) -> dataset.Spec:
    """A spec with some keys changed; ``None`` removes one."""
    keys = {
        "pairs": 4,
        "seed": 5,
        "size": [64, 48],
        "scenes": [{"file": str(animated(folder)), "lights": 2}, {"builtin": "near"}],
        "rig": {"interaxial": 0.1, "screen_distance": ".inf"},
        "motion": {
            "step": {"uniform": [0.1, 0.3]},
            "camera": {"right": {"uniform": [-0.1, 0.1]}, "forward": 0.05, "turn": {"uniform": [-2, 2]}, "roll": 1},
            "objects": {"share": 0.5, "distance": 0.1, "turn": {"uniform": [-20, 20]}},
        },
        "outputs": ["color", "disparity", "flow", "flow_visibility", "disparity_change", "next.disparity", "next.flow"],
        **changes,
    }
    return dataset.Spec.load({key: value for key, value in keys.items() if value is not None})


def test_items_of_data_sets_have_next_pairs(tmp_path):
    spec = moving(tmp_path)
    files = [{}, {}]
    for found, order in zip(files, (range(4), (3, 1, 0, 2)), strict=True):
        worker = dataset.worker.Worker(spec)
        for item in order:
            pair, record = worker.pair(item)
            found[item] = dataset.worker.encode.files(pair, spec, record)
            following, forward, backward = pair.motion
            assert following.camera != pair.camera and following.motion is None
            for eye in ("left", "right"):
                there, back = getattr(forward, eye), getattr(backward, eye)
                rows, columns = np.nonzero(there.visibility == 0)
                x = np.rint(columns + there.flow[rows, columns, 0]).astype(int)
                y = np.rint(rows + there.flow[rows, columns, 1]).astype(int)
                inside = (x >= 0) & (x < 64) & (y >= 0) & (y < 48)
                rows, columns, x, y = (values[inside] for values in (rows, columns, x, y))
                # The nearest pixel is up to half a pixel off, so most values are close.
                returned = np.abs(back.flow[y, x] + there.flow[rows, columns]).max(axis=1)
                assert np.median(returned) < 0.05
                now, then = getattr(pair, eye).disparity, getattr(following, eye).disparity
                off = np.abs(now[rows, columns] + there.disparity_change[rows, columns] - then[y, x])
                assert np.median(off) < 0.05
    assert files[0] == files[1]
    names = {"left.flow.npy", "right.flow_visibility.png", "next.left.disparity.npy", "next.right.flow.npy", "json"}
    assert names <= set(files[0][0]) and "next.left.png" not in files[0][0]
    assert {"camera", "next_camera"} <= set(json.loads(files[0][0]["json"]))


def test_specs_of_motion_name_what_is_wrong(tmp_path):
    for changes, text in (
        ({"motion": None, "outputs": ["flow"]}, "left.flow needs a next pair: set motion"),
        ({"motion": None, "outputs": ["next.left.color"]}, "next.left.color needs a next pair"),
        ({"motion": {"camera": {"side": 1}}}, "motion.camera: unknown key 'side'"),
        ({"motion": {"step": 0}}, "motion.step"),
        ({"outputs": ["next.left.flows"]}, "unknown 'next.left.flows'"),
        ({"format": "middlebury", "outputs": None}, "the layout middlebury holds no motion"),
        ({"render": {"method": "atomic"}}, "flow is for pixel centres"),
    ):
        with pytest.raises(ValueError, match=text):
            moving(tmp_path, **changes)
    with pytest.raises(ValueError, match="no animation 'run' in this scene; its animations are: slide"):
        spec = moving(tmp_path, scenes=[{"file": str(animated(tmp_path))}], motion={"animation": "run"})
        dataset.worker.Worker(spec).pair(0)


def sintel_holds_motion(training, pair):
    """Reads a pair of Sintel's layout as its own code does (``sintel_io.py``), and compares it."""
    following, forward, _ = pair.motion
    for frame, made in ((1, pair), (2, following)):
        name = f"000001/frame_{frame:04}"
        read = cv2.imread(str(training / "disparities" / f"{name}.png"))[..., ::-1].astype(np.float64)
        disparity = read[..., 0] * 4 + read[..., 1] / 2**6 + read[..., 2] / 2**14
        assert np.abs(disparity - made.left.disparity).max() <= 0.5 / 2**14 + 1e-6
        for folder, number in (("occlusions", 1), ("outofframe", 2)):
            mask = cv2.imread(str(training / folder / f"{name}.png"), cv2.IMREAD_UNCHANGED)
            assert np.array_equal(mask == 255, made.left.occlusion == number) and set(mask.flat) <= {0, 255}
        for folder, view in (("final", made.left), ("final_left", made.left), ("final_right", made.right)):
            assert np.array_equal(cv2.imread(str(training / folder / f"{name}.png"))[..., ::-1], view.color)
        data = (training / "camdata_left" / f"{name}.cam").read_bytes()
        assert np.frombuffer(data, np.float32, 1)[0] == np.float32(202021.25)
        numbers = np.frombuffer(data, np.float64, offset=4)
        intrinsics, extrinsics = numbers[:9].reshape(3, 3), numbers[9:].reshape(3, 4)
        # Its places of points are half a pixel less than the camera's, whose pixel centres are at halves.
        eye, target = np.array(made.camera.eye), np.array(made.camera.target)
        for point in (target, target + (0.3, 0.1, -0.2), 0.5 * (eye + target) + (0.1, 0, 0.05)):
            x, y, depth = intrinsics @ (extrinsics @ [*point, 1])
            place = np.array(made.camera.project(point, "left"))[:2] - 0.5
            assert place == pytest.approx((x / depth, y / depth), abs=1e-3)
    flow = np.frombuffer((training / "flow" / "000001" / "frame_0001.flo").read_bytes(), np.float32, offset=12)
    assert np.array_equal(flow.reshape(forward.left.flow.shape), forward.left.flow)
    for folder, classes in (("flow_occlusions", (1, 2)), ("invalid", (3,))):
        mask = cv2.imread(str(training / folder / "000001" / "frame_0001.png"), cv2.IMREAD_UNCHANGED)
        assert np.array_equal(mask == 255, np.isin(forward.left.visibility, classes))


def test_layouts_hold_motion(tmp_path):
    changes = {"outputs": None, "pairs": 2, "scenes": [{"builtin": "near"}]}
    for layout in ("kitti", "sceneflow", "sintel"):
        report = dataset.make(moving(tmp_path, format=layout, **changes), str(tmp_path / layout))
        assert not report.errors
    spec = moving(tmp_path, **{**changes, "outputs": ["occlusion", "disparity", "depth", "object", "flow"]})
    pair, _ = dataset.worker.Worker(spec).pair(1)
    following, forward, backward = pair.motion
    surface = pair.left.occlusion < 3
    surface &= np.isfinite(pair.left.disparity) & (pair.left.disparity > 0)
    training = tmp_path / "kitti" / "training"
    # As KITTI's development kit reads it: BGR for OpenCV, so the valid channel comes first.
    read = cv2.imread(str(training / "flow_occ" / "000001_10.png"), cv2.IMREAD_UNCHANGED).astype(np.float64)
    valid, flow = read[..., 0] == 1, (read[..., :0:-1] - 32768) / 64
    assert (valid == (surface & np.isfinite(forward.left.flow[..., 0]))).mean() > 0.99 and valid.any()
    assert np.abs(flow - forward.left.flow)[valid].max() <= 0.5 / 64 + 1e-6
    then = cv2.imread(str(training / "disp_occ_1" / "000001_10.png"), cv2.IMREAD_UNCHANGED) / 256
    expected = pair.left.disparity + forward.left.disparity_change
    assert np.abs(then - expected)[then > 0].max() <= 0.5 / 256 + 1e-5
    assert np.array_equal(cv2.imread(str(training / "image_3" / "000001_11.png"))[..., ::-1], following.right.color)
    both = cv2.imread(str(training / "disp_noc_1" / "000001_10.png"), cv2.IMREAD_UNCHANGED) / 256
    assert np.array_equal(both[both > 0], then[both > 0]) and 0 < (both > 0).sum() < (then > 0).sum()
    moves = (forward.left.displacement != 0).any(axis=-1)
    objects = cv2.imread(str(training / "obj_map" / "000001_10.png"), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(objects > 0, moves) and moves.any()
    of_objects = {tuple(sorted(set(pair.left.object[objects == number]))) for number in set(objects[moves])}
    assert all(len(ids) == 1 for ids in of_objects)
    sintel_holds_motion(tmp_path / "sintel" / "training", pair)
    flows = next((tmp_path / "sceneflow").rglob("optical_flow"))
    for name, found, frame in (("future", forward, 2), ("past", backward, 3)):
        file = flows / "stereotrace" / f"into_{name}" / "right" / f"OpticalFlowInto{name.title()}_{frame:04}_R.pfm"
        read = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
        assert np.array_equal(read[..., 2], found.right.flow[..., 0], equal_nan=True)
        assert np.array_equal(read[..., 1], found.right.flow[..., 1], equal_nan=True)
