"""Compares vertices and cameras of an animation with Blender's, at times between and at its key frames.

Run it with a Python that has bpy and numpy from PyPI, and this project's package:

    python scripts/beside_blender_motion.py FOLDER

Blender makes a tube with three bones and a shape key, a cube that turns and is scaled, and a camera. It exports them as
glTF, and computes the vertices of both objects at each frame.
"""

import argparse
import math
from pathlib import Path

import bpy
import numpy as np

import stereotrace as st

FPS, LAST = 24, 24
RINGS, CORNERS, BONES = 12, 16, 3


def key(thing, path: str, frame: int, value) -> None:
    setattr(thing, path, value)
    thing.keyframe_insert(path, frame=frame)


def tube(scene):
    """Makes the tube and its bones."""
    around = [2 * math.pi * corner / CORNERS for corner in range(CORNERS)]
    vertices = [
        (0.3 * math.cos(angle), 0.3 * math.sin(angle), BONES * ring / (RINGS - 1))
        for ring in range(RINGS) for angle in around
    ]
    faces = [
        (ring * CORNERS + corner, ring * CORNERS + (corner + 1) % CORNERS,
         (ring + 1) * CORNERS + (corner + 1) % CORNERS, (ring + 1) * CORNERS + corner)
        for ring in range(RINGS - 1) for corner in range(CORNERS)
    ]
    mesh = bpy.data.meshes.new("tube")
    mesh.from_pydata(vertices, [], faces)
    made = bpy.data.objects.new("tube", mesh)
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    for thing in (made, rig):
        scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    parent = None
    for bone in range(BONES):
        edited = rig.data.edit_bones.new(f"bone{bone}")
        edited.head, edited.tail, edited.parent = (0, 0, bone), (0, 0, bone + 1), parent
        parent = edited
    bpy.ops.object.mode_set(mode="OBJECT")
    for bone in range(BONES):
        group = made.vertex_groups.new(name=f"bone{bone}")
        for index, (_, _, z) in enumerate(vertices):
            weight = 1 - abs(z - bone - 0.5) / 1.2
            if weight > 0:
                group.add([index], weight, "REPLACE")
    made.parent = rig
    made.modifiers.new("rig", "ARMATURE").object = rig
    made.shape_key_add(name="Basis")
    fat = made.shape_key_add(name="fat")
    for index, (x, y, z) in enumerate(vertices):
        fat.data[index].co = (1.8 * x, 1.8 * y, z)
    key(fat, "value", 0, 0.0)
    key(fat, "value", LAST, 1.0)
    key(rig, "location", 0, (0, 0, 0))
    key(rig, "location", LAST, (1, 0.5, 0))
    for bone, angle in enumerate((0.3, 0.8, -1.1)):
        pose = rig.pose.bones[f"bone{bone}"]
        for frame, turn in ((0, (1, 0, 0, 0)), (16, (math.cos(angle / 2), math.sin(angle / 2), 0.1, 0))):
            key(pose, "rotation_quaternion", frame, turn)
        key(pose, "rotation_quaternion", LAST, (1, 0, 0, 0))
    return made


def cube_and_camera(scene):
    bpy.ops.mesh.primitive_cube_add(size=0.8, location=(-2, 0, 1))
    cube = bpy.context.object
    cube.name = "cube"
    for frame, turn, scale in ((0, (0, 0, 0), (1, 1, 1)), (LAST, (1, 2, 0.5), (1, 0.5, 2))):
        key(cube, "rotation_euler", frame, turn)
        key(cube, "scale", frame, scale)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.rotation_euler = (math.radians(85), 0, 0)
    key(camera, "location", 0, (0, -7, 2))
    key(camera, "location", LAST, (1, -6.5, 2.2))
    return cube, camera


def nearest(points: np.ndarray, others: np.ndarray) -> float:
    """Returns the largest distance of a point to the nearest of the others."""
    return max(np.linalg.norm(others - point, axis=1).min() for point in points)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.frame_start, scene.frame_end = FPS, 0, LAST
    objects = [tube(scene)]
    cube, camera = cube_and_camera(scene)
    objects.append(cube)
    model = folder / "moving.glb"
    bpy.ops.export_scene.gltf(
        filepath=str(model), export_cameras=True, export_force_sampling=True, export_animation_mode="ACTIVE_ACTIONS",
    )
    ours = st.Scene.open(model)
    names = [ours.object_name(index) for index in range(ours.object_count)]
    owners = np.repeat([ours.object_of(index) for index in range(ours.triangle_count)], 3)
    worst, moved = {}, {}
    for frame in range(LAST + 1):
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        ours.pose(frame / FPS)
        corners = ours.triangles.reshape(-1, 3)
        for thing in objects:
            evaluated = thing.evaluated_get(graph)
            vertices = np.array([evaluated.matrix_world @ vertex.co for vertex in evaluated.to_mesh().vertices])
            theirs = np.stack([vertices[:, 0], vertices[:, 2], -vertices[:, 1]], axis=1)  # Blender's z is up
            found = corners[owners == names.index(thing.name)]
            worst[thing.name] = max(worst.get(thing.name, 0), nearest(theirs, found), nearest(found, theirs))
            moved.setdefault(thing.name, theirs)
            moved[f"{thing.name} moves"] = np.abs(theirs - moved[thing.name]).max()
        x, y, z = camera.matrix_world.translation
        off = np.abs(np.array(ours.camera("camera").eye) - (x, z, -y)).max()
        worst["camera"] = max(worst.get("camera", 0), off)
    for name, off in worst.items():
        print(f"{name}: at most {off:.1e} from Blender's in {LAST + 1} frames")
    for thing in objects:
        print(f"{thing.name} moves by up to {moved[f'{thing.name} moves']:.2f}")


if __name__ == "__main__":
    main()
