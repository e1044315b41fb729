"""Ray-traced stereo pairs with exact ground truth, as NumPy arrays. One eye's samples are reused for the other.

    import stereotrace

    scene = stereotrace.Scene.builtin("hall")
    pair = stereotrace.render(scene, scene.camera(size=(640, 480)), outputs=["color", "disparity", "occlusion"])
    pair.left.color, pair.left.disparity, pair.left.occlusion

All arrays are row-major, top row first. World space is right-handed with y up; lengths are in world units. Disparities
are ``x_left - x_right`` in pixels. Wrong input raises ``ValueError``, or ``OSError`` for files. Faults of the graphics
adapter raise ``AdapterError``. The library logs to the logger ``stereotrace``.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

# Suppresses an error line of Mesa's device chooser outside a user's session, which means nothing here. Mesa reads the
# variable when a device is opened.
if sys.platform == "linux" and not os.path.isdir(os.environ.get("XDG_RUNTIME_DIR", "")):
    os.environ.setdefault("NODEVICE_SELECT", "1")

from ._stereotrace import (  # noqa: E402
    ANAGLYPHS,
    BUILTINS,
    LAYOUTS,
    METHODS,
    MISS,
    OPTIONS,
    OUTPUTS,
    PACKINGS,
    AdapterError,
    Camera,
    Correspondence,
    DeviceLostError,
    EyeFlow,
    EyeLayers,
    EyeMatches,
    Flow,
    Layers,
    Light,
    LimitError,
    Material,
    Passes,
    Renderer,
    Scene,
    StereoPair,
    View,
    Views,
    __version__,
    check_options,
    decode_png,
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
    "OPTIONS",
    "OUTPUTS",
    "PACKINGS",
    "AdapterError",
    "Camera",
    "Correspondence",
    "DeviceLostError",
    "EyeFlow",
    "EyeLayers",
    "EyeMatches",
    "Flow",
    "Layers",
    "Light",
    "LimitError",
    "Material",
    "Passes",
    "Renderer",
    "Scene",
    "StereoPair",
    "View",
    "Views",
    "__version__",
    "check_options",
    "decode_png",
    "encode_png",
    "from_trimesh",
    "render",
]

_renderer: Renderer | None = None


def render(scene: Scene, camera: Camera, **options: Unpack[RenderOptions]) -> StereoPair:
    """Renders a stereo pair as ``Renderer.render`` does, with a renderer that all calls share.

    The first call opens it, on the adapter that the environment variable ``STEREOTRACE_ADAPTER`` names, or else on the
    fastest. Raises as ``Renderer`` and ``Renderer.render`` do."""
    global _renderer
    if _renderer is None:
        _renderer = Renderer()
    try:
        return _renderer.render(scene, camera, **options)
    except DeviceLostError:
        _renderer = None  # the next call opens a new one
        raise
