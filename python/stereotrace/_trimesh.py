"""Scenes of trimesh."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from ._needs import needs
from ._stereotrace import Scene


def from_trimesh(mesh: Any, *, crease_angle: float | None = None) -> Scene:
    """A scene of a ``trimesh.Trimesh`` or ``trimesh.Scene``, with its colours, textures and materials: trimesh writes it as glTF, which
    ``Scene.open`` reads. So a geometry that a scene shows at several places becomes as many objects.

    ``crease_angle`` in degrees gives meshes without normals smooth ones: see ``Scene.open``. The scene has no lights but those of
    ``trimesh.Scene``'s file: see ``Scene.place_lights``. Raises ``ValueError`` for what has no triangles, such as point clouds and paths.
    """
    trimesh = needs("trimesh", "trimesh")
    scene: Any = mesh if isinstance(mesh, trimesh.Scene) else trimesh.Scene(mesh)
    triangles = [name for name, part in scene.geometry.items() if isinstance(part, trimesh.Trimesh) and len(part.faces)]
    if not triangles:
        raise ValueError(f"there are no triangles in {mesh!r}")
    with tempfile.TemporaryDirectory(prefix="stereotrace-") as folder:
        path = Path(folder, "scene.glb")
        path.write_bytes(scene.export(file_type="glb"))
        return Scene.open(path, crease_angle=crease_angle)
