"""Scenes from trimesh."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from ._needs import needs
from ._stereotrace import Scene


def from_trimesh(mesh: Any, *, crease_angle: float | None = None) -> Scene:
    """Makes a scene from a ``trimesh.Trimesh`` or ``trimesh.Scene``, with its colours, textures and materials.

    Trimesh writes the mesh as glTF, which ``Scene.open`` reads. So each instance of a geometry becomes an object.
    ``crease_angle`` in degrees gives smooth normals to meshes without any: see ``Scene.open``. The scene has only the
    lights that the glTF file has: see ``Scene.place_lights``. Raises ``ValueError`` if there are no triangles, as in
    point clouds and paths.
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
