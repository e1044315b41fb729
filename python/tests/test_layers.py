"""Tests the surfaces along lines of sight."""

from __future__ import annotations

import numpy as np
import pytest

import stereotrace
from stereotrace import dataset


def wall(z: float, half: float) -> np.ndarray:
    return np.array([[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]], np.float32)


FACES = np.array([[0, 1, 2], [0, 2, 3]])


def room(finish: str) -> tuple[stereotrace.Scene, stereotrace.Camera]:
    """Returns a wall at z = -2, one at z = 8, and a smaller pane or mirror at z = 0. The eyes are at z = 4."""
    scene = stereotrace.Scene()
    matte = scene.add_material(stereotrace.Material(0.5))
    pane = scene.add_material(stereotrace.Material(0, finish=finish))
    scene.add_mesh(wall(-2, 9), FACES, material=matte)
    scene.add_mesh(wall(8, 9), FACES, material=matte)
    scene.add_mesh(wall(0, 1), FACES, material=pane)
    camera = stereotrace.Camera((0, 0, 4), (0, 0, 0), size=(64, 48), interaxial=0.2, screen_distance=np.inf)
    return scene, camera


def layers_of(renderer, scene, camera, **choice):
    pair = renderer.render(scene, camera, outputs=["depth", "primitive", "disparity"])
    return pair, renderer.layers(pair, scene, **choice)


def test_lines_pass_glass_and_end_at_walls(renderer):
    scene, camera = room("glass")
    pair, layers = layers_of(renderer, scene, camera, surfaces=3)
    left = layers.left
    assert left.depth.shape == (3, 48, 64) and left.normal.shape == (3, 48, 64, 3) and left.count.shape == (48, 64)
    assert left.visibility.dtype == np.uint8 and left.object.dtype == np.uint32
    behind = left.count == 2
    assert behind.sum() > 100 and (left.count[~behind] == 1).all()
    assert np.array_equal(left.disparity[0], pair.left.disparity)
    fx = camera.intrinsics["fx"]
    assert left.disparity[1][behind] == pytest.approx(fx * 0.2 / 6, abs=1e-4)
    assert left.depth[1][behind] == pytest.approx(6, abs=1e-5)
    assert (left.object[0][behind] == 2).all() and (left.object[1][behind] == 0).all()
    assert (left.object[1][~behind] == stereotrace.MISS).all() and np.isinf(left.depth[1][~behind]).all()
    assert set(np.unique(left.visibility[1][behind])) <= {0, 1} and (left.visibility[2] == 5).all()
    assert not left.bends.any() and not left.vertical_disparity.any()


def test_mirrors_show_virtual_disparities(renderer):
    scene, camera = room("mirror")
    _, layers = layers_of(renderer, scene, camera, surfaces=2)
    assert (layers.left.count == 1).all()
    _, layers = layers_of(renderer, scene, camera, surfaces=2, mirrored=True)
    for eye in (layers.left, layers.right):
        seen = eye.count == 2
        # The wall behind the eyes is 8 behind the mirror, and the mirror 4 from the eyes.
        assert eye.disparity[1][seen] == pytest.approx(camera.intrinsics["fx"] * 0.2 / 12, abs=1e-3)
        assert eye.depth[1][seen] == pytest.approx(12, abs=1e-4) and (eye.bends[1][seen] == 1).all()
        assert eye.position[1][seen][:, 2] == pytest.approx(8, abs=1e-5)
        assert {0} <= set(np.unique(eye.visibility[1][seen])) <= {0, 2, 3}
        assert eye.normal[1][seen][:, 2] == pytest.approx(-1)


def test_layers_that_cannot_be_made_are_refused(renderer):
    scene, camera = room("glass")
    pair = renderer.render(scene, camera, outputs=["depth", "primitive"])
    with pytest.raises(ValueError, match="0 surfaces; it must be 1 to 32"):
        renderer.layers(pair, scene, 0)
    with pytest.raises(ValueError, match="layers need ids"):
        renderer.layers(renderer.render(scene, camera, outputs=["color"]), scene)


def test_data_sets_have_layers():
    spec = {
        "pairs": 2,
        "size": [64, 48],
        "scenes": [{"builtin": "near"}],
        "layers": {"surfaces": 3, "mirrored": True},
        "outputs": ["color", "left.layer_disparity", "layer_visibility", "layer_count"],
    }
    loaded = dataset.Spec.load(spec)
    pair, record = dataset.worker.Worker(loaded).pair(1)
    files = dataset.encode.files(pair, loaded, record)
    assert {"left.layer_disparity.npy", "right.layer_visibility.npy", "left.layer_count.npy"} <= set(files)
    assert "right.layer_disparity.npy" not in files
    assert pair.layers.left.disparity.shape == (3, 48, 64)
    for key, text in (({"surfaces": 33}, "layers.surfaces: 33"), ({"glass": 1}, "layers: unknown key 'glass'")):
        with pytest.raises(ValueError, match=text):
            dataset.Spec.load({**spec, "layers": key})
