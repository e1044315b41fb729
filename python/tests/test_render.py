"""Tests the arrays of pairs against files of the Rust command, read by other programs' readers."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest

import stereotrace
from stereotrace import Camera, Light, Material, Renderer, Scene

COMMAND = os.environ.get("STEREOTRACE_COMMAND")
by_command = pytest.mark.skipif(COMMAND is None, reason="STEREOTRACE_COMMAND does not name the Rust command")


def run(*arguments: object) -> None:
    assert COMMAND
    subprocess.run([COMMAND, *map(str, arguments)], check=True, capture_output=True)


def read(path: Path) -> np.ndarray:
    found = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert found is not None, path
    return found[..., 2::-1] if found.ndim == 3 else found


@by_command
@pytest.mark.parametrize("method", ["naive", "bracket", "atomic"])
def test_pictures_are_the_commands(renderer, hall, tmp_path, method):
    run("render", "builtin:hall", "--size", "160x120", "--method", method, "--out", tmp_path)
    pair = renderer.render(hall, hall.camera(size=(160, 120)), method=method)
    for eye in ("left", "right"):
        assert np.array_equal(read(tmp_path / f"{eye}.png"), getattr(pair, eye).color), eye
    assert np.array_equal(read(tmp_path / "anaglyph.png"), pair.anaglyph())
    assert not np.array_equal(pair.left.color, pair.right.color)


@by_command
@pytest.mark.parametrize("layout", stereotrace.LAYOUTS)
def test_data_sets_are_the_commands(renderer, hall, tmp_path, layout):
    """Both find the same cameras and write the same files, byte for byte."""
    size, projection = ("96x64", "planar") if layout != "panorama" else ("96x48", 360)
    options = ["--size", size, "--projection", projection, "--pairs", 2, "--layout", layout]
    run("dataset", "builtin:hall", *options, "--out", tmp_path / "command")
    if layout == "panorama":
        camera, limit = hall.camera(size=(96, 48)).replace(projection=360, interaxial=0.065), np.inf
    else:
        camera, limit = hall.camera(size=(96, 64)).replace(screen_distance=np.inf), 0.2 * 96
    for item in range(2):
        place, _ = renderer.free_camera(hall, camera, 0, item, max_disparity=limit)
        pair = renderer.render(hall, place, outputs=["color", "occlusion"])
        written = pair.write(tmp_path / "python", layout, item)
        assert len(written) >= 5
        for path in map(Path, written):
            assert path.read_bytes() == (tmp_path / "command" / path.relative_to(tmp_path / "python")).read_bytes(), (
                path
            )


def test_every_array_has_its_shape_and_agrees_with_the_others(renderer, hall):
    camera = hall.camera(size=(97, 61))
    pair = renderer.render(hall, camera, method="bracket", outputs=stereotrace.OUTPUTS)
    depths = {
        "color": (np.uint8, 3),
        "linear": (np.float32, 3),
        "normal": (np.float32, 3),
        "geometric_normal": (np.float32, 3),
    }
    bytes_of = {"occlusion", "source", "shadow_source"}
    ids = {"primitive", "object", "material", "cost"}
    for view in (pair.left, pair.right):
        for name, array in view.arrays().items():
            default = np.uint8 if name in bytes_of else np.uint32 if name in ids else np.float32
            dtype, channels = depths.get(name, (default, None))
            assert array.shape == (61, 97) + ((channels,) if channels else ()), name
            assert array.dtype == dtype and array.flags.c_contiguous, name
            assert getattr(view, name) is array  # one copy, kept
        z, disparity = view.depth[30, 40], view.disparity[30, 40]
        # The rendered eyes are f32 positions, and disparities belong to these.
        assert abs(disparity - camera.disparity(z)) < 1e-5
        for normal in (view.normal, view.geometric_normal):
            assert np.allclose(np.linalg.norm(normal[view.primitive != stereotrace.MISS], axis=-1), 1, atol=1e-5)
        assert (view.distance >= view.depth * (1 - 1e-6)).all()
    assert set(stereotrace.OUTPUTS) - set(pair.right.arrays()) == {"albedo"}
    assert set(stereotrace.OUTPUTS) - set(pair.left.arrays()) == {"albedo", "source", "shadow_source"}
    by_paths = renderer.render(hall, camera, outputs=["albedo"], lighting="paths=1:1").right.albedo
    assert by_paths.shape == (61, 97, 3) and by_paths.dtype == np.float32 and 0 < by_paths.mean() < 1
    reused = int((pair.right.source == 0).sum())
    assert reused == pair.statistics["reused"] > 0
    # A world point that a pixel shows is where the camera projects it to.
    row, column = 20, 70
    directions = np.array(camera.intrinsics["fx"])
    x = (column + 0.5 - camera.intrinsics["cx0"]) / directions * pair.left.depth[row, column]
    y = (row + 0.5 - camera.intrinsics["cy"]) / camera.intrinsics["fy"] * pair.left.depth[row, column]
    eye = np.array(camera.eye) - np.array(camera.right) * camera.interaxial / 2
    point = (
        eye
        + x * np.array(camera.right)
        - y * np.array(camera.up)
        + pair.left.depth[row, column] * np.array(camera.forward)
    )
    left, right = camera.project(point), camera.project(point, "right")
    assert np.allclose(left[:2], (column + 0.5, row + 0.5), atol=1e-3)
    assert abs(left[0] - right[0] - pair.left.disparity[row, column]) < 1e-3


def test_disparities_carry_one_view_to_the_other(renderer):
    """OpenCV warps the right picture by the disparities. Points that both eyes see then equal the left picture."""
    scene = Scene.builtin("hall-finished")
    pair = renderer.render(scene, scene.camera(size=(320, 240)), outputs=["color", "disparity", "occlusion"])
    columns, rows = np.meshgrid(np.arange(320, dtype=np.float32), np.arange(240, dtype=np.float32))
    carried = cv2.remap(pair.right.color, columns - pair.left.disparity, rows, cv2.INTER_LINEAR)
    both = pair.left.occlusion == 0
    assert 0.5 < both.mean() < 1
    difference = np.abs(carried.astype(int) - pair.left.color).mean(axis=-1)
    assert np.median(difference[both]) <= 2  # measured 1.0, and 3 to 4 with the opposite sign
    turned = cv2.remap(pair.right.color, columns + pair.left.disparity, rows, cv2.INTER_LINEAR)
    assert np.median(np.abs(turned.astype(int) - pair.left.color).mean(axis=-1)[both]) > 3


def test_block_matching_finds_the_disparities(renderer):
    scene = Scene.builtin("hall-finished")
    camera = scene.camera(size=(400, 300))
    pair = renderer.render(scene, camera, outputs=["color", "disparity", "occlusion"], shadow_rays=4)
    low = int(np.floor(pair.left.disparity.min())) - 2
    matcher = cv2.StereoSGBM_create(
        minDisparity=low, numDisparities=64, blockSize=5, P1=600, P2=2400, uniquenessRatio=5
    )
    grey = [cv2.cvtColor(view.color, cv2.COLOR_RGB2GRAY) for view in (pair.left, pair.right)]
    found = matcher.compute(*grey).astype(np.float32) / 16
    known = (pair.left.occlusion == 0) & (found >= low)
    assert known.mean() > 0.5
    assert np.median(np.abs(found - pair.left.disparity)[known]) < 0.5


def test_python_runs_while_pictures_are_made(renderer, hall):
    count, done = 0, threading.Event()

    def work():
        try:
            renderer.render(hall, hall.camera(size=(640, 480)))
        finally:
            done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        count += 1
    thread.join()
    assert count > 10_000  # there are millions; with the lock held, only one or two


def test_threads_may_share_a_renderer(renderer, hall):
    spheres = Scene.builtin("spheres")
    jobs = [(scene, scene.camera(size=(64, 48))) for scene in (hall, spheres)] * 3
    alone = [renderer.render(scene, camera).left.color for scene, camera in jobs[:2]]
    found: list[np.ndarray | None] = [None] * len(jobs)

    def work(place: int) -> None:
        found[place] = renderer.render(*jobs[place]).left.color

    threads = [threading.Thread(target=work, args=(place,)) for place in range(len(jobs))]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert all(np.array_equal(one, alone[place % 2]) for place, one in enumerate(found))


def test_a_callback_is_told_and_may_stop(renderer, hall):
    told = []
    renderer.render(hall, hall.camera(size=(320, 240)), progress=lambda step, share: told.append((step, share)))
    assert told[-1][1] == 1.0

    class Enough(Exception):
        pass

    def stop(step, share):
        raise Enough

    with pytest.raises(Enough):
        renderer.render(hall, hall.camera(size=(320, 240)), progress=stop)


def test_a_fork_does_not_take_the_device_along():
    """Forked processes, as of torch's DataLoader, get errors. Drivers would wait for ever."""
    text = """if 1:
        import os, stereotrace
        scene = stereotrace.Scene.builtin("near")
        camera, renderer = scene.camera(size=(32, 24)), stereotrace.Renderer()
        renderer.render(scene, camera)
        child = os.fork()
        if child == 0:
            wrong = 0
            one_shot = lambda: stereotrace.render(scene, camera)  # noqa: E731
            for call in (lambda: renderer.render(scene, camera), one_shot, stereotrace.Renderer):
                try:
                    call()
                except RuntimeError as error:
                    wrong += "by spawn" not in str(error)
                else:
                    wrong += 1
            os._exit(wrong)
        assert os.waitpid(child, 0)[1] == 0
    """
    found = subprocess.run([sys.executable, "-c", text], timeout=120, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr


def test_a_callback_cannot_render_with_its_own_renderer(renderer, hall):
    """A nested call would wait for itself, so it raises an error."""
    with pytest.raises(RuntimeError, match="use another renderer"):
        renderer.render(hall, hall.camera(size=(64, 48)), progress=lambda *_: renderer.render(hall, hall.camera()))
    renderer.render(hall, hall.camera(size=(64, 48)))


def test_scenes_that_change_show_what_they_are(renderer):
    scene = Scene.builtin("three-spheres")
    camera = scene.camera(size=(80, 60))
    before = renderer.render(scene, camera).left.color
    scene.transform_object(0, [[1, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    scene.lights = [Light.point((3, 5, 4), 0.8)]
    scene.set_material(1, scene.materials[1].replace(albedo=(0.1, 0.6, 0.1)))
    after = renderer.render(scene, camera).left.color
    assert not np.array_equal(before, after)
    assert np.array_equal(after, Renderer().render(scene.copy(), camera).left.color)


def test_a_film_has_a_history_until_it_is_forgotten(hall):
    renderer = Renderer()
    camera = hall.camera(size=(80, 60))
    pairs = [renderer.render(hall, camera, method="bracket", history=64) for _ in range(2)]
    renderer.forget()
    pairs.append(renderer.render(hall, camera, method="bracket", history=64))
    first, second, third = (pair.statistics["left"]["primary_rays"] for pair in pairs)
    assert first == third == 80 * 60 > 2 * second
    assert np.array_equal(pairs[0].left.color, pairs[2].left.color)


def test_auto_chooses_by_a_calibration(hall):
    renderer = Renderer()
    camera = hall.camera(size=(64, 48))
    usual = renderer.calibration
    assert usual[0] == 0
    renderer.calibration = (0, 1e6, usual[2])
    assert renderer.render(hall, camera).statistics["method"] == "naive"
    renderer.calibration = (0, 0, usual[2])
    assert renderer.render(hall, camera).statistics["method"] == "bracket"
    ray_seconds, search, shadow = renderer.calibrate()
    assert renderer.calibration == (ray_seconds, search, shadow)
    assert 0 < ray_seconds < 1e-3 and shadow > 0 and search == search
    for wrong in [(0, float("nan"), 1), (0, 1, 0), (-1, 1, 1), (float("inf"), 1, 1)]:
        with pytest.raises(ValueError, match="calibration"):
            renderer.calibration = wrong


def test_views_of_a_rig(renderer, hall):
    views = renderer.render_views(
        hall, hall.camera(size=(64, 48)).replace(interaxial_px=1.0), 6, outputs=["color", "depth"]
    )
    assert len(views) == 6 and views.offsets == [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5]
    quilt = views.quilt(3, 2)
    assert quilt.shape == (96, 192, 3)
    assert np.array_equal(quilt[48:, :64], views[0].color) and np.array_equal(quilt[:48, 128:], views[-1].color)
    with pytest.raises(IndexError):
        views[6]
    with pytest.raises(ValueError, match="quilt of 4x2"):
        views.quilt(4, 2)
    for output in ("normal", "disparity"):
        with pytest.raises(ValueError, match=f"{output} is available for pairs"):
            renderer.render_views(hall, hall.camera(), 3, outputs=[output])


def test_notebooks_show_the_anaglyph(renderer, hall):
    pair = renderer.render(hall, hall.camera(size=(64, 48)))
    shown = cv2.imdecode(np.frombuffer(pair._repr_png_(), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    assert np.array_equal(shown, pair.anaglyph("dubois"))
    shown = cv2.imdecode(np.frombuffer(pair.left._repr_png_(), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    assert np.array_equal(shown, pair.left.color)


def test_pictures_round_trip_through_png():
    random = np.random.default_rng(1)
    for shape, dtype in [((5, 7), np.uint8), ((5, 7), np.uint16), ((5, 7, 3), np.uint8), ((5, 7, 4), np.uint8)]:
        picture = random.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
        # One picture is not in C order.
        for given in (picture, np.asfortranarray(picture), picture[:, ::-1]):
            file = np.frombuffer(stereotrace.encode_png(given), np.uint8)
            found = cv2.imdecode(file, cv2.IMREAD_UNCHANGED)
            found = found[..., [2, 1, 0, 3][: found.shape[2]]] if found.ndim == 3 else found
            assert np.array_equal(found, given)
    with pytest.raises(ValueError, match="uint8"):
        stereotrace.encode_png(np.zeros((2, 2)))


def test_closest_hits(renderer):
    scene = Scene()
    scene.add_sphere((0, 0, 0), 1.0)
    t, primitive = renderer.closest_hits(scene, [(0, 0, 5)], [(0, 0, -1), (0, 0, 1)])
    assert t[0] == 4 and np.isinf(t[1])
    assert list(primitive) == [0, stereotrace.MISS]


def test_files_of_both_eyes(renderer, hall, tmp_path):
    pair = renderer.render(hall, hall.camera(size=(64, 48)), outputs=["color", "depth", "occlusion"])
    for ending in ("png", "jpg", "jps", "mpo"):
        pair.save(tmp_path / f"pair.{ending}")
    assert np.array_equal(read(tmp_path / "pair.png"), pair.anaglyph())
    renderer.render(hall, hall.camera(size=[64, 48]), outputs=["linear", "primitive"]).save(tmp_path / "pair.exr")
    assert pair.packed("top-bottom").shape == (96, 64, 3)
    assert pair.retrace_map().shape == (48, 64, 3)


def raises(kind, text, call):
    with pytest.raises(kind, match=text) as caught:
        call()
    assert type(caught.value) is kind


def test_every_option_and_output_is_described():
    described = Renderer.render.__doc__
    assert all(f"- ``{name}``: " in described for name in [*stereotrace.OPTIONS, "outputs"])
    assert all(f"- ``{name}``: " in stereotrace.View.__doc__ for name in stereotrace.OUTPUTS)
    for name, value in {
        "adaptive": (4, 8.0),
        "ambient_occlusion": None,
        "jitter": np.bool_(False),
        "penumbra": "exact",
        "samples": np.int64(1),
        "shadow_buffer": (400, "depth"),
    }.items():
        stereotrace.check_options(**{name: value})


def test_errors_say_what_is_wrong(renderer, hall, tmp_path):
    camera = hall.camera(size=(32, 24))
    broken = tmp_path / "broken.obj"
    broken.write_text("v 0 0 0\nv 1 0 0\nv 0 1 x\nf 1 2 3\n")
    raises(FileNotFoundError, "missing.glb", lambda: Scene.open("missing.glb"))
    raises(ValueError, r"broken.obj:3: ", lambda: Scene.open(broken))
    raises(ValueError, "built-in scene 'x'; use one of", lambda: Scene.builtin("x"))
    raises(ValueError, "method 'x'; use one of", lambda: renderer.render(hall, camera, method="x"))
    raises(ValueError, "unknown option 'sample'; use one of method", lambda: renderer.render(hall, camera, sample=4))
    raises(ValueError, "samples: 3 per pixel", lambda: renderer.render(hall, camera, samples=3))
    raises(ValueError, "samples: -1 must be", lambda: renderer.render(hall, camera, samples=-1))
    raises(ValueError, "unknown output 'z'; use one of", lambda: renderer.render(hall, camera, outputs=["z"]))
    raises(
        ValueError,
        "ground truth is for pixel centres",
        lambda: renderer.render(hall, camera, method="atomic", outputs=["normal"]),
    )
    raises(ValueError, "target is .* must differ from the eye", lambda: Camera((0, 0, 0), (0, 0, 0)))
    raises(TypeError, "(?s)must be three numbers.*'eye'", lambda: Camera((0, 0), (0, 0, 1)))
    raises(ValueError, "camera: up: .*must be three numbers", lambda: camera.replace(up=1))
    raises(ValueError, "unknown field 'upp'", lambda: camera.replace(upp=(0, 1, 0)))
    raises(ValueError, "fov and intrinsics", lambda: camera.replace(fov=40, intrinsics={"fx": 1, "cx0": 1, "cy": 1}))
    raises(ValueError, "intrinsics.*no cy", lambda: camera.replace(intrinsics={"fx": 1, "cx0": 1}))
    raises(AttributeError, "'normal' was not requested", lambda: renderer.render(hall, camera).left.normal)
    raises(AttributeError, "no 'nothing'", lambda: renderer.render(hall, camera).left.nothing)
    raises(ValueError, "ground truth, which was not requested", lambda: renderer.render(hall, camera).write(tmp_path))
    raises(ValueError, "parallel", lambda: renderer.render(hall, camera, outputs="occlusion").write(tmp_path, "kitti"))
    raises(
        ValueError,
        "pair.bmp: pairs can be written as",
        lambda: renderer.render(hall, camera).save(tmp_path / "pair.bmp"),
    )
    raises(
        ValueError,
        "pair.exr: .*'linear' and 'primitive' in outputs",
        lambda: renderer.render(hall, camera).save(tmp_path / "pair.exr"),
    )
    raises(ValueError, "bounces: 99; it must be 0 to 8", lambda: stereotrace.check_options(bounces=99))
    raises(ValueError, "samples: 3 per pixel", lambda: stereotrace.check_options(samples=3))
    raises(FileNotFoundError, "nowhere", lambda: renderer.render(hall, camera).save(tmp_path / "nowhere" / "pair.png"))
    raises(stereotrace.AdapterError, "no graphics adapter found for the name 'Voodoo2'", lambda: Renderer("Voodoo2"))
    wide = camera.replace(size=(20_000, 20), fov=0.066)
    raises(stereotrace.LimitError, "max_texture_dimension_2d", lambda: renderer.render(hall, wide, method="bracket"))
    raises(ValueError, "kept_scenes", lambda: Renderer(kept_scenes=0))
    assert issubclass(stereotrace.LimitError, stereotrace.AdapterError) and issubclass(
        stereotrace.AdapterError, RuntimeError
    )
    with pytest.raises(ValueError, match="albedo"):
        scene = Scene.builtin("near")
        scene.add_material(Material(albedo=-1))
        renderer.render(scene, scene.camera())


def test_messages_go_to_pythons_log(caplog, tmp_path):
    flat = tmp_path / "flat.obj"
    flat.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nusemtl none\n")
    with caplog.at_level("WARNING", logger="stereotrace"):
        Scene.open(flat)
    assert any("without area" in message for message in caplog.messages), caplog.messages


def test_nothing_is_printed_that_is_not_ours(tmp_path):
    """Without a session Mesa would print a line about XDG_RUNTIME_DIR."""
    env = {key: value for key, value in os.environ.items() if key not in ("XDG_RUNTIME_DIR", "NODEVICE_SELECT")}
    text = (
        "import stereotrace; scene = stereotrace.Scene.builtin('near'); "
        "stereotrace.render(scene, scene.camera(size=(8, 6)))"
    )
    commands = [[sys.executable, "-c", text]]
    if COMMAND:
        commands.append([COMMAND, "render", "builtin:near", "--size", "8x6", "--out", str(tmp_path / "out")])
    for command in commands:
        found = subprocess.run(command, env=env, capture_output=True, text=True, timeout=120)
        assert (found.returncode, found.stderr) == (0, ""), command


def test_everything_has_a_docstring():
    for name in stereotrace.__all__:
        value = getattr(stereotrace, name)
        if isinstance(value, type) or callable(value):
            assert value.__doc__, name
        if isinstance(value, type):
            for member, found in vars(value).items():
                if not member.startswith("_") and (callable(found) or hasattr(found, "__get__")):
                    assert found.__doc__, f"{name}.{member}"


def test_passes_refine_a_picture(renderer, hall):
    camera = hall.camera(size=(40, 30))
    passes = stereotrace.Passes()
    options = {"method": "naive", "outputs": ["linear"], "lighting": "paths=2:2"}
    first = renderer.render(hall, camera, passes=passes, **options)
    assert (passes.count, passes.paths) == (1, 2)
    told = []
    both = renderer.render(hall, camera, passes=passes, progress=lambda *_: told.append(passes.paths), **options)
    assert set(told) == {2}
    whole = renderer.render(hall, camera, **{**options, "lighting": "paths=4:2"})
    assert np.abs(both.right.linear - whole.right.linear).max() < 1e-5
    assert np.abs(first.right.linear - whole.right.linear).max() > 1e-3
    with pytest.raises(ValueError, match="cameras"):
        renderer.render(hall, hall.camera(size=(41, 30)), passes=passes, **options)
    other = Renderer()
    again = lambda *_: other.render(hall, camera, passes=passes, **options)  # noqa: E731
    with pytest.raises(ValueError, match="another frame"):
        renderer.render(hall, camera, passes=passes, progress=again, **options)
    views = renderer.render_views(hall, camera, 3, passes=stereotrace.Passes(), **options)
    assert len(views) == 3
    assert repr(passes) == "Passes(2, 4 paths)"
