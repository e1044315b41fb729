"""Tests animations and flow."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import stereotrace

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
            assert found.flow[row, column] == pytest.approx([place[0] - x[row, column], place[1] - y[row, column]], abs=2e-3)
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
    for animation, text in ((3, "no animation 3"), ("walk", "no animation 'walk' in this scene; its animations are: slide")):
        with pytest.raises(ValueError, match=text):
            scene.pose(0.0, animation)
    with pytest.raises(ValueError, match="its time is NaN"):
        scene.pose(float("nan"))
    with pytest.raises(ValueError, match="its animations are: none"):
        square().pose(0.0)
