"""Tests scenes from arrays and from trimesh against files and equivalent scenes."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import re

import numpy as np
import pytest
import trimesh

import stereotrace
from stereotrace import Camera, Light, Material, Scene

VERTICES = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], np.float64)
FACES = np.array([(0, 1, 2), (0, 2, 3)])
UV = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float64)
CAMERA = Camera((0.4, 0.3, 4), (0, 0, 0), size=(96, 72), interaxial=0.1)


def picture(renderer, scene: Scene) -> np.ndarray:
    if not scene.lights:
        scene.add_light(Light.point((1, 2, 4), 0.8))
    return renderer.render(scene, CAMERA).left.color


def checker() -> np.ndarray:
    random = np.random.default_rng(5)
    return random.integers(0, 256, (8, 8, 3), np.uint8)


def test_a_textured_mesh_is_that_of_a_file(renderer, tmp_path):
    (tmp_path / "t.png").write_bytes(stereotrace.encode_png(checker()))
    (tmp_path / "m.mtl").write_text("newmtl a\nKd 1 1 1\nmap_Kd t.png\n")
    lines = [f"v {x} {y} {z}" for x, y, z in VERTICES] + [f"vt {u} {v}" for u, v in UV]
    lines += ["mtllib m.mtl", "usemtl a"] + ["f " + " ".join(f"{i + 1}/{i + 1}" for i in face) for face in FACES]
    (tmp_path / "m.obj").write_text("\n".join(lines) + "\n")
    scene = Scene()
    material = scene.add_material(Material(albedo=1.0, texture=scene.add_texture(checker())))
    for uv in (UV, UV[FACES], UV.astype(np.float32).tolist()):
        one = scene.copy()
        one.add_mesh(VERTICES, FACES, uv=uv, material=material, name="a")
        assert np.array_equal(picture(renderer, one), picture(renderer, Scene.open(tmp_path / "m.obj")))
    assert len(np.unique(picture(renderer, one).reshape(-1, 3), axis=0)) > 30


@pytest.mark.parametrize("dtype", [np.int32, np.int64, np.uint8, np.uint32])
def test_arrays_of_any_kind_are_taken(renderer, dtype):
    scene, same = Scene(), Scene()
    scene.add_mesh(VERTICES, FACES)
    same.add_mesh(np.asfortranarray(VERTICES.astype(np.float32)), np.asfortranarray(FACES.astype(dtype)))
    assert scene.sha256() == same.sha256()
    assert same.add_mesh(VERTICES, FACES[:0]) == 1 and same.add_mesh(VERTICES, FACES) == 2
    assert scene.triangle_count == 2 and scene.bounds == [(-1, -1, 0), (1, 1, 0)]


def test_colours_of_vertices(renderer):
    """Bytes are sRGB. A white material times a vertex colour equals a material with the linear colour."""
    colored, plain = Scene(), Scene()
    srgb = np.array([200, 100, 50], np.uint8)
    linear = ((srgb / 255 + 0.055) / 1.055) ** 2.4
    for colors in (
        np.tile(srgb, (4, 1)),
        np.tile(np.append(srgb, np.uint8(255)), (4, 1)),
        np.tile(linear, (4, 1)),
        np.tile(linear, (2, 3, 1)),
    ):
        colored = Scene()
        colored.add_mesh(VERTICES, FACES, colors=colors, material=colored.add_material(Material(albedo=1.0)))
        plain = Scene()
        plain.add_mesh(VERTICES, FACES, material=plain.add_material(Material(albedo=linear)))
        assert np.abs(picture(renderer, colored).astype(int) - picture(renderer, plain)).max() <= 1


def test_materials_and_normals(renderer):
    scene = Scene()
    ids = [scene.add_material(Material(albedo=color)) for color in ((0.8, 0.1, 0.1), (0.1, 0.1, 0.8))]
    scene.add_mesh(VERTICES, FACES, material=ids, normals=np.tile((0, 0, 1), (4, 1)))
    shown = renderer.render(scene, CAMERA, outputs=["material", "normal"]).left
    assert set(np.unique(shown.material)) == {*ids, stereotrace.MISS}
    assert np.allclose(shown.normal[36, 48], (0, 0, 1))
    bumpy = Scene()
    bumpy.add_mesh(*icosahedron(), crease_angle=80)
    smooth = renderer.render(bumpy, CAMERA, outputs=["normal", "geometric_normal"]).left
    assert np.abs(smooth.normal - smooth.geometric_normal).max() > 0.1
    glass = Material(finish="glass", index=1.3, transmission=0.9)
    assert (glass.finish, round(glass.index, 5), glass.fresnel) == ("glass", 1.3, True)
    assert Material(finish="mirror", fresnel=True, specular=0.9).replace(albedo=0.2).fresnel is True


def icosahedron():
    ball = trimesh.creation.icosphere(subdivisions=1)
    return ball.vertices, ball.faces


def test_spheres_ellipsoids_and_planes(renderer):
    one, all_at_once = Scene(), Scene()
    centers = np.array([(x, 0, -x) for x in range(4)], np.float32)
    for center in centers:
        one.add_sphere(center, 0.4)
    all_at_once.add_spheres(centers, 0.4)
    assert one.sha256() == all_at_once.sha256()
    with pytest.raises(ValueError, match="radii: 2 for 4 spheres"):
        all_at_once.add_spheres(centers, [1.0, 2.0])
    with pytest.raises(ValueError, match="radius"):
        all_at_once.add_spheres(centers, [1.0, 2.0, 0.0, 1.0])
    assert one.sha256() == all_at_once.sha256()  # either all of them are added or none
    ball, round_one = Scene(), Scene()
    ball.add_sphere((0, 0, 0), 1.0)
    round_one.add_ellipsoid((0, 0, 0), (1, 1, 1))
    depths = [renderer.render(scene, CAMERA).left.depth for scene in (ball, round_one)]
    assert np.allclose(*depths, atol=1e-5) and np.isfinite(depths[0]).any()
    # Axes are columns, as in NumPy's products, so this ellipsoid is long along x + y.
    turned = Scene()
    turned.add_ellipsoid((0, 0, 0), [(1, -0.2, 0), (1, 0.2, 0), (0, 0, 0.3)])
    seen = renderer.render(turned, Camera((0, 0, 9), (0, 0, 0), size=(64, 64))).left.depth < 100
    rows, columns = np.nonzero(seen)
    assert np.corrcoef(columns, -rows)[0, 1] > 0.8
    ball.add_plane((0, -1, 0))
    assert ball.object_count == 2 and renderer.render(ball, CAMERA).left.depth[-1].max() < 100


def test_lights_and_sky(renderer):
    scene = Scene()
    scene.add_mesh(VERTICES, FACES)
    lamps = [
        Light.point((0, 0, 3), 0.5).with_quadratic_falloff(range=7).with_cone((0, 0, -1), 0.1, 0.4),
        Light.sphere((0, 0, 3), 0.2, (0.5, 0.4, 0.3)),
        Light.rectangle((0, 0, 3), (1, 0, 0), (0, 1, 0), 0.5),
        Light.directional((0, 0, 1), 0.01, 0.5),
    ]
    scene.lights = lamps
    assert [light.shape for light in scene.lights] == ["point", "sphere", "rectangle", "directional"]
    assert scene.lights == lamps and scene.lights[1].radius == np.float32(0.2)
    scene.set_sky((0.2, 0.3, 0.4))
    corner = renderer.render(scene, CAMERA, outputs=["linear"]).left.linear[0, 0]
    assert np.allclose(corner, (0.2, 0.3, 0.4), atol=1e-6)
    sky = np.zeros((4, 8, 3), np.float32)
    sky[..., 2] = 0.7
    scene.set_sky_map(sky)
    assert np.allclose(renderer.render(scene, CAMERA, outputs=["linear"]).left.linear[0, 0], (0, 0, 0.7), atol=1e-6)
    sky[:, 4] = (0.7, 0, 0)
    scene.set_sky_map(sky, turn=180, gain=0.5)
    behind = Camera((0, 0, 3), (0, 0, 9), size=(24, 18))
    seen = renderer.render(scene, behind, outputs=["linear"]).left.linear[9, 12]
    assert np.allclose(seen[1], 0, atol=1e-6) and 0.1 < seen[0] <= 0.35
    with pytest.raises(ValueError, match="turned"):
        scene.set_sky_map(sky, turn=float("nan"))
    assert renderer.suggest_exposure(scene, CAMERA, lighting="paths=4:2") > 0
    assert renderer.suggest_exposure(scene, CAMERA) == renderer.suggest_exposure(scene, CAMERA, exposure=3)
    placed = scene.lights_around(3, CAMERA)
    assert len(placed) == 3 and scene.lights == lamps
    scene.place_lights(3, CAMERA)
    assert scene.lights == placed


def test_projectors_project_their_picture_upright(renderer):
    scene = Scene()
    scene.add_plane((0, 0, 0), (0, 0, 1))
    scene.ambient = 0
    halves = np.zeros((2, 2, 3), np.uint8)
    halves[0, 0], halves[1, 1] = (255, 0, 0), (0, 0, 255)
    lamp = Light.point((0, 0, 3), 1.0)
    picture = scene.add_texture(halves)
    scene.lights = [lamp.with_projector(picture, (0, 0, -1), (0, 1, 0), 0.8)]
    camera = Camera((0, 0, 3), (0, 0, 0), size=(24, 24), fov=60)
    shown = renderer.render(scene, camera, outputs=["linear"]).left.linear
    assert shown[5, 5, 0] > 0.3 and shown[5, 5, 2] == 0 and shown[18, 18, 2] > 0.3 and shown[18, 18, 0] == 0
    assert shown[5, 18].max() < 0.1 and shown[18, 5].max() < 0.1 and shown[0, 0].max() == 0
    dots = scene.add_dots(160, 120, 200)
    scene.lights = [lamp.with_projector(dots, (0, 0, -1), (0, 1, 0), 0.8)]
    assert pickle.loads(pickle.dumps(scene.lights)) == scene.lights != [lamp]
    with pytest.raises(ValueError, match="dots: 400 dots in 160x120 pixels"):
        scene.add_dots(160, 120, 400)
    scene.lights = [lamp.with_projector(7, (0, 0, -1), (0, 1, 0), 0.8)]
    with pytest.raises(ValueError, match="the projector's texture 7 is out of range for 2 textures"):
        renderer.render(scene, CAMERA)


def test_trimesh_shows_what_arrays_show(renderer):
    mesh = trimesh.Trimesh(VERTICES, FACES, process=False)
    ours, theirs = Scene(), stereotrace.from_trimesh(mesh)
    ours.add_mesh(VERTICES, FACES)
    outputs = ["depth", "geometric_normal", "primitive"]
    a, b = (renderer.render(scene, CAMERA, outputs=outputs).left for scene in (ours, theirs))
    for name in outputs:
        assert np.array_equal(getattr(a, name), getattr(b, name)), name


def test_trimesh_keeps_textures_colours_and_places(renderer):
    from PIL import Image

    visual = trimesh.visual.TextureVisuals(uv=UV, image=Image.fromarray(checker()))
    textured = stereotrace.from_trimesh(trimesh.Trimesh(VERTICES, FACES, visual=visual, process=False))
    ours = Scene()
    ours.add_mesh(
        VERTICES, FACES, uv=UV, material=ours.add_material(Material(albedo=1.0, texture=ours.add_texture(checker())))
    )
    shown, expected = (renderer.render(scene, CAMERA, outputs=["linear"]).left.linear for scene in (textured, ours))
    colored = expected.reshape(-1, 3).std(axis=0).min() > 0
    # trimesh's own material scales all colours, but the pattern is the same.
    scale = (shown * expected).sum() / (expected * expected).sum()
    assert colored and np.abs(shown - scale * expected).max() < 0.02 * expected.max()

    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.4)
    ball.visual.vertex_colors = np.tile((255, 0, 0, 255), (len(ball.vertices), 1))
    two = trimesh.Scene()
    two.add_geometry(ball, transform=trimesh.transformations.translation_matrix((-1, 0, 0)))
    two.add_geometry(ball, transform=trimesh.transformations.translation_matrix((1, 0, 0)))
    scene = stereotrace.from_trimesh(two, crease_angle=60)
    assert scene.object_count == 2 and np.allclose(scene.bounds, [(-1.4, -0.4, -0.4), (1.4, 0.4, 0.4)], atol=0.01)
    shown = renderer.render(scene, Camera((0, 0, 6), (0, 0, 0), size=(64, 48))).left.color
    assert (shown[..., 0] > 100).any() and shown[..., 1:].max() < 40

    with pytest.raises(ValueError, match="no triangles"):
        stereotrace.from_trimesh(trimesh.PointCloud(VERTICES))


def test_wrong_arrays_are_refused_by_name():
    def mesh(text, vertices=VERTICES, faces=FACES, **more):
        scene = Scene()
        with pytest.raises(ValueError, match=text):
            scene.add_mesh(vertices, faces, **more)
        assert scene.triangle_count == 0

    mesh(r"vertices: their shape must be \(n, 3\)", vertices=VERTICES[:, :2])
    mesh("vertices: they are <U1", vertices=np.array([["a", "b", "c"]]))
    mesh("vertex 1: ", vertices=np.where(np.arange(4)[:, None] == 1, np.nan, VERTICES))
    mesh("faces: they are float64", faces=FACES.astype(float))
    mesh("face 1 has the corner -1", faces=np.array([(0, 1, 2), (0, 2, -1)]))
    mesh("face 0 has the corner 4294967296", faces=np.array([(0, 1, 2**32)]))
    mesh("corner 7 is out of range for 4 vertices", faces=np.array([(0, 1, 7)]))
    mesh("faces: their shape", faces=np.array([(0, 1, 2, 3)]))
    mesh("uv: 3 for 4 vertices", uv=UV[:3])
    mesh("uv: their shape", uv=np.zeros((2, 2, 2)))
    mesh("normals: 1 for 4 vertices", normals=np.array([(0, 0, 1)]))
    mesh("colors: they are int64", colors=np.zeros((4, 3), np.int64))
    mesh("material", material=7)
    mesh("material: 'red' must be", material="red")
    mesh("crease_angle would replace them", normals=np.zeros((4, 3)), crease_angle=30)
    scene = Scene()
    for picture in (np.zeros((4, 4)), np.zeros((4, 4, 3)), np.zeros((4, 4, 2), np.uint8)):
        with pytest.raises(ValueError, match="texture: it must be uint8"):
            scene.add_texture(picture)
    with pytest.raises(ValueError, match="sky: their shape"):
        scene.set_sky_map(np.zeros((4, 4)))
    with pytest.raises(ValueError, match="sky: they are uint8"):
        scene.set_sky_map(np.zeros((4, 8, 3), np.uint8))
    with pytest.raises(ValueError, match="last row"):
        scene.transform_object(0, np.ones((4, 4)))
    with pytest.raises(ValueError, match="material 9: the scene has 1"):
        scene.set_material(9, Material())
    with pytest.raises(ValueError, match="empty"):
        scene.camera()


def everything() -> Scene:
    """Returns a scene with one object of each kind."""
    scene = Scene()
    texture = scene.add_texture(checker(), wrap="mirror")
    board = scene.add_checkerboard(1.0, 0.0, 8)
    shown = scene.add_material(Material(albedo=0.9, texture=texture, cutout=board, name="shown", specular=0.1))
    glass = scene.add_material(Material(finish="glass", index=1.3))
    scene.add_mesh(VERTICES, FACES, uv=UV, material=[shown, glass], normals=np.tile((0, 0, 1), (4, 1)), name="a")
    scene.add_mesh(VERTICES + 2, FACES, colors=np.tile((0.5, 0.25, 1.0), (4, 1)), name="b")
    scene.add_mesh(VERTICES - 2, FACES[:0], name="none")
    scene.add_mesh(VERTICES - 2, FACES, name="c")
    scene.add_sphere((0, 0, 1), 0.3, glass)
    scene.add_ellipsoid((1, 0, 1), (0.1, 0.2, 0.3))
    scene.add_plane((0, -2, 0), tile=2.0)
    scene.lights = [Light.point((0, 0, 3), 0.5), Light.rectangle((0, 0, 3), (1, 0, 0), (0, 1, 0), 0.5)]
    scene.lights += [Light.sphere((1, 1, 3), 0.1, (0.1, 0.2, 0.3)), Light.directional((0, 1, 0), 0.1, 0.5)]
    scene.set_sky_map(np.random.default_rng(2).random((4, 8, 3), np.float32))
    scene.ambient = (0.1, 0.2, 0.3)
    scene.shadows = False
    return scene


def test_all_that_says_what_is_rendered_pickles_and_copies():
    scene = everything()
    cameras = [
        CAMERA,
        CAMERA.replace(screen_distance=float("inf"), fov=0.1 + 40),
        CAMERA.replace(interaxial_px=3.3, screen_width=1.7),
        CAMERA.replace(intrinsics={"fx": 100.1, "fy": 99.7, "cx0": 47.3, "cx1": 48.9, "cy": 36.1}, up=(0.1, 1, 0)),
        CAMERA.replace(toe_in=True),
        CAMERA.replace(projection=360),
        CAMERA.replace(projection=180, pole_merge=None, interaxial=0.065),
        scene.camera(size=(7, 5)),
        Scene.builtin("hall").camera(),
    ]
    for camera in cameras:
        assert Camera.from_json(camera.to_json()) == camera
    assert Camera.from_json(CAMERA.to_json(), size=(10, 20)).size == (10, 20)
    for found in (*cameras, *scene.lights, *scene.materials):
        for copied in (pickle.loads(pickle.dumps(found)), copy.copy(found), copy.deepcopy([found])[0]):
            assert copied == found and type(copied) is type(found)
    for kept in (scene, Scene.builtin("three-spheres-textured"), Scene()):
        for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
            again = pickle.loads(pickle.dumps(kept, protocol))
            assert again.sha256() == kept.sha256() and again.memory == kept.memory
            assert [again.object_name(index) for index in range(4)] == [kept.object_name(index) for index in range(4)]
            assert again.lights == kept.lights and again.materials == kept.materials
        again.add_light(Light.point((0, 0, 0), 1))
        assert again.sha256() != kept.sha256() == copy.deepcopy(kept).sha256()
    assert pickle.loads(pickle.dumps(Scene.builtin("hall"))).camera() == Scene.builtin("hall").camera()
    with pytest.raises(TypeError, match="cannot pickle"):
        pickle.dumps(stereotrace.Renderer())


def test_cameras_that_look_all_around(renderer):
    around = Camera((0, 1, 0), (0, 1, -1), size=(64, 32), interaxial=0.2, projection=360)
    # Straight ahead, the right eye sees a point on its left: 2 atan(0.1 / s) of 64 columns a turn.
    (left, row, depth), (right, same_row, _) = (around.project((0, 1, -2), eye) for eye in ("left", "right"))
    assert row == same_row == 16 and depth == pytest.approx(np.sqrt(4 - 0.01))
    assert left - right == pytest.approx(2 * np.arctan(0.1 / depth) * 64 / (2 * np.pi), abs=2e-5)
    assert around.disparity(depth) == pytest.approx(left - right, abs=2e-5)
    hall = Scene.builtin("hall")
    inside = around.replace(eye=(0.75, 1.75, -4), target=(0.75, 1.75, -5))
    found, expected = (renderer.render(hall, inside, method=method) for method in ("bracket-rays", "naive"))
    assert np.array_equal(found.right.color, expected.right.color) and found.right.depth.max() < np.inf
    assert around.replace(projection="planar") == Camera((0, 1, 0), (0, 1, -1), size=(64, 32), interaxial=0.2)
    with pytest.raises(ValueError, match="no intrinsics"):
        around.intrinsics
    for fields, message in (
        ({"projection": 270}, "projection: 270 must be 'planar', 360 or 180"),
        ({"pole_merge": (70, 60)}, "pole merge is 70 to 60 degrees"),
        ({"pole_merge": 3}, "pole_merge: 3 must be None or two elevations"),
        ({"interaxial_px": 3.0}, "give it in world units"),
        ({"projection": "planar", "pole_merge": (60, 75)}, "only equirectangular pictures have poles"),
    ):
        with pytest.raises(ValueError, match=re.escape(message)):
            around.replace(**fields)


def test_pickles_that_are_none_are_refused():
    restore, (kind, state) = everything().__reduce__()
    assert restore(kind, state).sha256() == everything().sha256()
    random = np.random.default_rng(3)
    for cut in (0, 1, len(state) // 2, len(state) - 1):
        with pytest.raises(ValueError, match="pickled Scene"):
            restore(kind, state[:cut])
    for _ in range(300):
        place, value = int(random.integers(len(state))), int(random.integers(256))
        try:
            restore(kind, state[:place] + bytes([value]) + state[place + 1 :]).sha256()
        except ValueError:
            pass
    for other in ("Camera", "Material", "Renderer"):
        with pytest.raises(ValueError):
            restore(other, b"\xff\xfe")


def same_scene(queue, scene, camera, lights) -> None:
    queue.put((scene.sha256(), camera, lights))


def test_a_spawned_process_gets_them():
    """As the workers of torch's DataLoader do."""
    context = multiprocessing.get_context("spawn")
    queue, scene = context.Queue(), everything()
    process = context.Process(target=same_scene, args=(queue, scene, CAMERA, scene.lights))
    process.start()
    assert queue.get(timeout=120) == (scene.sha256(), CAMERA, scene.lights)
    process.join()


def test_cameras_of_json_are_read_or_named(tmp_path):
    path = tmp_path / "camera.json"
    path.write_text(CAMERA.to_json())
    assert Camera.from_json(path) == Camera.from_json(str(path)) == CAMERA
    with pytest.raises(ValueError, match="selects a camera from several in a file"):
        Camera.from_json(CAMERA.to_json(), "a")
    with pytest.raises(ValueError, match="no object 'camera'"):
        Camera.from_json("{}")
    path.write_text('{"camera": 3')
    with pytest.raises(ValueError, match="camera.json:1: invalid JSON"):
        Camera.from_json(path)
    with pytest.raises(FileNotFoundError, match="none.json"):
        Camera.from_json(tmp_path / "none.json")


def test_arrays_that_are_not_aligned_are_copied():
    def unaligned(array: np.ndarray) -> np.ndarray:
        found = np.frombuffer(b"\0" + array.tobytes(), np.uint8)[1:].view(array.dtype).reshape(array.shape)
        assert not found.flags.aligned
        return found

    scene, same = Scene(), Scene()
    vertices, uv = VERTICES.astype(np.float32), UV.astype(np.float32)
    sky = np.full((2, 4, 3), 0.5, np.float32)
    for one, prepared in ((scene, np.asarray), (same, unaligned)):
        one.add_mesh(
            prepared(vertices),
            prepared(FACES.astype(np.int64)),
            uv=prepared(uv),
            colors=prepared(vertices * 0 + np.float32(0.5)),
        )
        one.set_sky_map(prepared(sky))
    assert scene.sha256() == same.sha256()
    grey = np.arange(12, dtype=np.uint16).reshape(3, 4)
    assert stereotrace.encode_png(unaligned(grey)) == stereotrace.encode_png(grey)


@pytest.mark.parametrize(
    ("material", "specular"),
    [
        (Material(finish="mirror"), 0.95),
        (Material(finish="glass"), 0.04),
        (Material(finish="glass", index=2.0), 1 / 9),
        (Material(finish="glass", fresnel=False), 0.0),
    ],
)
def test_mirrors_and_glass_are_valid_and_seen_by_their_defaults(renderer, material, specular):
    assert material.albedo == (0, 0, 0) and np.allclose(material.specular, specular, atol=1e-6)
    scene = Scene()
    scene.set_sky((0.5, 0.4, 0.3), (0.1, 0.3, 0.9))
    scene.add_sphere((0, 0, 0), 1.0, scene.add_material(material))
    shown = renderer.render(scene, CAMERA, outputs=["linear", "primitive"]).left
    ball, behind = shown.linear[shown.primitive == 0], shown.linear[shown.primitive == stereotrace.MISS]
    # The ball shows other parts of the sky than those behind it.
    assert len(ball) > 1000 and ball.mean() > 0.5 * behind.mean() and ball.std() > 0.01
    assert Material(finish="mirror", albedo=0.02).albedo[0] == np.float32(0.02) and Material(finish="matte").albedo[
        0
    ] == np.float32(0.7)
    assert Material(finish="mirror", specular=0.5).specular == (0.5, 0.5, 0.5)


def test_files_far_from_the_origin_keep_their_places(tmp_path):
    path = tmp_path / "utm.obj"
    path.write_text("v 500000.25 120 -5400000.5\nv 500001.25 120 -5400000.5\nv 500000.25 121 -5400000.5\nf 1 2 3\n")
    scene = Scene.open(path)
    assert scene.origin == (500001, 121, -5400001)
    assert scene.bounds == [(500000.25, 120, -5400000.5), (500001.25, 121, -5400000.5)]
    again = pickle.loads(pickle.dumps(scene))
    assert again.origin == scene.origin and again.sha256() == scene.sha256()
    whole = Scene.open(path, origin="none")
    assert whole.origin == (0, 0, 0) and whole.sha256() != scene.sha256()
    assert Scene.open(path, origin=(500000, 0, 0)).origin == (500000, 0, 0)
    with pytest.raises(ValueError, match="origin: 'there' is not"):
        Scene.open(path, origin="there")
    eye, target = (500000.5, 120.25, -5399998.0), (500000.5, 120.25, -5400000.5)
    camera = Camera(eye, target)
    assert camera.eye == eye and Camera.from_json(camera.to_json()) == camera
    t, ids = stereotrace.Renderer().closest_hits(scene, [eye], [(0, 0, -1)])
    assert ids[0] == 0 and t[0] == 2.5


def test_physically_based_materials_are_shown_by_paths(renderer):
    """Black surfaces under a white sky reflect what Fresnel's equations say, and a tilted normal is lit by a cosine."""

    def middle(material, texture=None, light=False):
        scene = Scene()
        if texture is not None:
            material = {**material, "normal_texture": scene.add_texture(texture, data=True)}
        scene.add_material(Material.principled(**material))
        corners = np.array([[-9, 0, -9], [-9, 0, 9], [9, 0, 9], [9, 0, -9]], np.float32)
        uv = np.array([[0, 0], [0, 1], [1, 1], [1, 0]], np.float32)
        faces = np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
        scene.add_mesh(corners, faces, uv=uv, material=1)
        if light:
            scene.lights = [Light.point((0, 1e6, 0), 1.0)]
        else:
            scene.set_sky((1.0, 1.0, 1.0))
        camera = Camera((0, 3, 0.01), (0, 0, 0), size=(8, 8), fov=1.0)
        pair = renderer.render(scene, camera, method="naive", outputs="linear", lighting="paths=64:1")
        return float(pair.left.linear[..., 0].mean())

    black = {"base": 0.0, "roughness": 0.0}
    assert abs(middle(black) - 0.04) < 1e-3
    assert abs(middle({**black, "specular": 0.0, "clearcoat": 1.0}) - 0.04) < 1e-3
    assert abs(middle({"base": (0.3, 0.2, 0.1), "metallic": 1.0, "roughness": 0.0}) - 0.3) < 2e-3
    tilted = np.array([[[128 + 76, 128, 128 + 102]]], np.uint8)
    matte = {"base": 1.0, "roughness": 1.0, "specular": 0.0, "metallic": 0.0}
    assert abs(middle(matte, tilted, light=True) / middle(matte, light=True) - 0.8) < 0.01
    clear = Material.principled(0.5, texture=0, alpha_blend=True, transmission_texture=0)
    assert clear.alpha_blend and clear != Material.principled(0.5, texture=0, alpha_blend=True)
    with pytest.raises(ValueError, match="roughnes"):
        Material.principled(roughnes=1)
    with pytest.raises(ValueError, match="thin"):
        Material.principled(thin="no")
    assert Material.principled(metallic=1.0) != Material.principled()
    coated = Material.principled(0.5, clearcoat=1.0)
    assert pickle.loads(pickle.dumps(coated)) == coated
