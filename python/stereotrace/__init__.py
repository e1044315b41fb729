"""Ray-traced stereo pairs for little more than one eye's price, with exact ground truth, as NumPy arrays.

    import stereotrace

    scene = stereotrace.Scene.builtin("hall")
    pair = stereotrace.render(scene, scene.camera(size=(640, 480)), outputs=["color", "disparity", "occlusion"])
    pair.left.color, pair.left.disparity, pair.left.occlusion

All arrays are row-major, top row first. World space is right-handed with y up; lengths are in world units. Disparities are
``x_left - x_right`` in pixels. What is wrong with input is a ``ValueError`` (an ``OSError`` for files), what is wrong with the graphics adapter
an ``AdapterError``. Messages of the library go to the logger ``stereotrace``.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

# Without a user's session Mesa's device chooser prints an error line, which means nothing here. It reads this when a
# device is opened.
if sys.platform == "linux" and not os.path.isdir(os.environ.get("XDG_RUNTIME_DIR", "")):
    os.environ.setdefault("NODEVICE_SELECT", "1")

from ._stereotrace import (  # noqa: E402

    ANAGLYPHS,
    BUILTINS,
    LAYOUTS,
    METHODS,
    MISS,
    OUTPUTS,
    PACKINGS,
    AdapterError,
    Camera,
    DeviceLostError,
    Light,
    LimitError,
    Material,
    Renderer,
    Scene,
    StereoPair,
    View,
    Views,
    __version__,
    check_options,
    encode_png,
)
from ._trimesh import from_trimesh

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._stereotrace import RenderOptions

__all__ = [
    "ANAGLYPHS",
    "BUILTINS",
    "LAYOUTS",
    "METHODS",
    "MISS",
    "OUTPUTS",
    "PACKINGS",
    "AdapterError",
    "Camera",
    "DeviceLostError",
    "Light",
    "LimitError",
    "Material",
    "Renderer",
    "Scene",
    "StereoPair",
    "View",
    "Views",
    "__version__",
    "check_options",
    "encode_png",
    "from_trimesh",
    "render",
]

_renderer: Renderer | None = None


def render(scene: Scene, camera: Camera, **options: Unpack[RenderOptions]) -> StereoPair:
    """Renders a stereo pair, as ``Renderer.render`` does, by a renderer that is made at the first call and kept: on the adapter that the
    environment variable ``STEREOTRACE_ADAPTER`` names, or else on the fastest one."""
    global _renderer
    if _renderer is None:
        _renderer = Renderer()
    try:
        return _renderer.render(scene, camera, **options)
    except DeviceLostError:
        _renderer = None  # the next call opens another one
        raise
