"""Tests pairs of the views of camera arrays."""

from __future__ import annotations

import numpy as np
import pytest

from stereotrace import MISS

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
