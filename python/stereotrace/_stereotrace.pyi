"""Types of the part of ``stereotrace`` that is written in Rust. Its docstrings, by ``help``, say what things are."""

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, ClassVar, Final, Literal, SupportsIndex, TypeAlias, TypedDict, final, type_check_only

import numpy as np
import numpy.typing as npt
from typing_extensions import NotRequired, Required, Self, Unpack

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
    "_restored",
    "check_options",
    "encode_png",
]

__version__: Final[str]
MISS: Final[int]
METHODS: Final[list[str]]
BUILTINS: Final[list[str]]
LAYOUTS: Final[list[str]]
ANAGLYPHS: Final[list[str]]
PACKINGS: Final[list[str]]
OUTPUTS: Final[list[str]]

Point: TypeAlias = Sequence[float] | npt.NDArray[Any]
Color: TypeAlias = float | Sequence[float] | npt.NDArray[Any]
_Path: TypeAlias = str | os.PathLike[str]
_Vector: TypeAlias = tuple[float, float, float]

class AdapterError(RuntimeError):
    """No graphics adapter fits, or its driver refused something."""

class LimitError(AdapterError):
    """A picture or scene is larger than the adapter allows or has memory for."""

class DeviceLostError(AdapterError):
    """The device went away."""

@type_check_only
class RenderOptions(TypedDict, total=False):
    """What to render with: the keywords of ``Renderer.render``."""

    # How the right view is made: one of METHODS, or buffer-N for N slots; "auto".
    method: str
    # The arrays that come back: names of OUTPUTS, or one name; ["color", "depth", "disparity"].
    outputs: str | Sequence[str]
    # Samples a pixel: 1, 4, 9, 16, 25, 36, 49 or 64; 1.
    samples: int
    # How samples are weighed; "box".
    filter: Literal["box", "tent", "gauss"]
    # Whether samples stand aside of the middles of their cells; True.
    jitter: bool
    # More samples only where a pixel's differ: levels, 2 to 5, and the tolerance in values of an 8-bit channel, 0 to 255; None.
    adaptive: Sequence[float] | None
    # Surfaces, one behind the other, that a ray may come from, 0 to 8; 5.
    bounces: int
    # Rays to each light that is not a point, 1 to 32; 16.
    shadow_rays: int
    # Whether what stands near keeps ambient light off: rays, 1 to 32, and a radius in world units, above 0; None.
    ambient_occlusion: Sequence[float] | None
    # By how many rays, 1 to 32, the sky lights surfaces, in place of ambient light; None, by none.
    sky_rays: int | None
    # What a view takes over of these rays' answers: of places that are fully lit or not at all, or penumbrae too; "shared".
    penumbra: Literal["exact", "shared"]
    # Of all random numbers, 0 to 2**32 - 1; 0.
    seed: int
    # By how many stops pictures are brighter than the light that scenes give, -64 to 64; 0.
    exposure: float
    # What becomes of what is too bright for a picture; "clamp".
    tone: Literal["clamp", "filmic"]
    # Whether each view has random numbers of its own; False.
    noise_by_view: bool
    # How the first hits of traced views are found; "rays".
    visibility: Literal["rays", "t-buffer"]
    # Whether points ask shadow-buffers which point lights they see: rows of a table, 1 or more, and a rule; None.
    shadow_buffer: tuple[int, Literal["object", "depth", "hybrid"]] | None
    # Whether BVH nodes and primitive tests are counted, which is slower; False.
    count: bool

@type_check_only
class Intrinsics(TypedDict):
    """Focal lengths and principal points in pixels, pixel centres at halves."""

    # Focal length along x.
    fx: float
    # Focal length along y.
    fy: float
    # Column of the left eye's principal point.
    cx0: float
    # Column of the right eye's principal point.
    cx1: float
    # Row of both principal points.
    cy: float

@type_check_only
class IntrinsicsFields(TypedDict):
    """The same as a camera takes them."""

    fx: Required[float]
    # fx where it is left out.
    fy: NotRequired[float]
    cx0: Required[float]
    # cx0 where it is left out.
    cx1: NotRequired[float]
    cy: Required[float]

@type_check_only
class CameraFields(TypedDict, total=False):
    """The keywords of ``Camera``."""

    # The direction that is up in the picture, of any length; (0, 1, 0).
    up: Point
    # Width and height in pixels, 1 to 131072 each; (640, 480).
    size: Sequence[int]
    # Vertical field of view in degrees, between 0 and 180; 45.
    fov: float
    # Width of the screen rectangle in world units, in place of the field of view.
    screen_width: float
    # What a calibration says, in pixels, in place of the field of view.
    intrinsics: Intrinsics | IntrinsicsFields
    # From the eyes to the screen in world units, infinite for parallel cameras; the target's distance.
    screen_distance: float
    # Between the eyes in world units; a thirtieth of the target's distance.
    interaxial: float
    # The same in pixels of the picture; not for parallel cameras.
    interaxial_px: float
    # Whether the eyes are turned towards each other; False.
    toe_in: bool

@type_check_only
class CameraReplaceFields(CameraFields, total=False):
    """The keywords of ``Camera.replace``."""

    # The midpoint between the eyes, a world position.
    eye: Point
    # What is looked at, a world position.
    target: Point

@type_check_only
class MaterialFields(TypedDict, total=False):
    """The keywords of ``Material`` beside ``albedo``."""

    # For messages; empty.
    name: str
    # Id of the texture that the albedo is multiplied by; None.
    texture: int | None
    # Id of the texture where whose alpha is below a half there is no surface; None.
    cutout: int | None
    # The share of what is behind the surface that it hides, 0 to 1; 1.
    opacity: float
    # Colour of highlights, or the share that mirrors and glass reflect, linear RGB, 0 to 1; black, or what reflects by
    # ``finish``.
    specular: Color
    # Phong's exponent, 0 to 10000; 30.
    exponent: float
    # Whether highlights conserve energy; False.
    normalised: bool
    # Radiance that the surface gives off, linear RGB, 0 or more; black.
    emission: Color
    # What it does with light beside scattering it; "matte".
    finish: Literal["matte", "mirror", "glass"]
    # Of glass: index of refraction over that of what surrounds it, 0.1 to 10; 1.5.
    index: float
    # Of glass: the share of the light that comes through, linear RGB, 0 to 1; white.
    transmission: Color
    # Of mirrors and glass: whether the angle of view says how much is reflected; False for mirrors, True for glass.
    fresnel: bool

@type_check_only
class MaterialReplaceFields(MaterialFields, total=False):
    """The keywords of ``Material.replace``."""

    # Diffuse reflectance, linear RGB, 0 to 1.
    albedo: Color

@type_check_only
class Work(TypedDict):
    """What one view cost."""

    # Closest-hit rays through pixels.
    primary_rays: int
    # Length-limited rays that check pixels that were taken over.
    verification_rays: int
    # Rays towards lights.
    shadow_rays: int
    # Rays that mirrors, glass and veils send on.
    secondary_rays: int
    # BVH nodes visited; 0 unless counted.
    nodes: int
    # Primitives tested; 0 unless counted.
    primitive_tests: int
    # 2 * nodes + primitive_tests.
    cost: int

@type_check_only
class Choice(TypedDict):
    """What the method ``auto`` chose, and why."""

    # The method that made most of the right view.
    method: str
    # The share of it that was made by bracket, 0 to 1.
    by_bracket: float
    # The share of right pixels that no left sample saw, 0 to 1.
    gaps: float
    # Shadow rays a pixel of the left view.
    shadow_rays: float
    # Rays a pixel of the left view that mirrors, glass and veils sent on.
    secondary_rays: float
    # What the right view was predicted to cost by bracket, in primary rays a pixel.
    bracket: float
    # The same by naive.
    naive: float

@type_check_only
class Statistics(TypedDict):
    """What a pair cost."""

    # The method that made it.
    method: str
    # Why auto chose it; None by other methods.
    choice: Choice | None
    # Whether the frame was rendered again in steps.
    in_steps: bool
    left: Work
    right: Work
    # Right pixels that were taken over from the left view.
    reused: int
    # Right pixels whose left sample was rejected; traced.
    bad: int
    # Right pixels without a left sample; traced.
    missed: int
    # Share of the right pixels that were traced, 0 to 1.
    retraced_share: float
    # The right view's cost relative to the left view's; None unless counted.
    second_eye: float | None
    # Of buffer methods: candidates that were lost.
    lost_candidates: int
    # Of buffer methods: slots a right pixel.
    buffer_depth: int
    # Name and seconds of each pass in order; None where the adapter has no timestamps.
    times: list[tuple[str, float]] | None
    # Device memory of the buffers between the passes, in bytes.
    intermediate_bytes: int

@final
class Scene:
    """A scene to render."""

    def __new__(cls) -> Self: ...
    @staticmethod
    def open(
        path: _Path,
        *,
        crease_angle: float | None = None,
        missing_textures: Literal["error", "warn"] = "error",
        outside_files: Literal["refuse", "allow"] = "refuse",
        origin: Point | Literal["auto", "none"] | None = None,
    ) -> Scene: ...
    @staticmethod
    def builtin(name: str) -> Scene: ...
    def copy(self) -> Scene: ...
    def __copy__(self) -> Scene: ...
    def __deepcopy__(self, _memo: Any, /) -> Scene: ...
    def camera(self, name: str | None = None, size: Sequence[int] = ...) -> Camera: ...  # size: (640, 480)
    @property
    def camera_names(self) -> list[str]: ...
    def add_mesh(
        self,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        name: str = "",
        material: int | Sequence[int] | npt.NDArray[np.integer[Any]] | None = None,
        normals: npt.ArrayLike | None = None,
        uv: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        crease_angle: float | None = None,
    ) -> int: ...
    def add_sphere(self, center: Point, radius: float, material: int = 0) -> None: ...
    def add_spheres(
        self,
        centers: npt.ArrayLike,
        radii: float | Sequence[float] | npt.NDArray[Any],
        materials: int | Sequence[int] | npt.NDArray[np.integer[Any]] | None = None,
    ) -> None: ...
    def add_ellipsoid(self, center: Point, axes: npt.ArrayLike, material: int = 0) -> None: ...
    def add_plane(self, point: Point, normal: Point = ..., material: int = 0, *, tile: float = 1.0) -> None: ...  # normal: (0, 1, 0)
    def add_material(self, material: Material) -> int: ...
    def set_material(self, id: int, material: Material) -> None: ...
    @property
    def materials(self) -> list[Material]: ...
    def add_texture(
        self, picture: _Path | npt.NDArray[np.uint8], wrap: Literal["repeat", "mirror", "clamp"] = "repeat"
    ) -> int: ...
    def add_checkerboard(self, first: Color, second: Color, squares: int) -> int: ...
    @property
    def lights(self) -> list[Light]: ...
    @lights.setter
    def lights(self, lights: Sequence[Light]) -> None: ...
    def add_light(self, light: Light) -> None: ...
    def place_lights(self, count: int, camera: Camera) -> None: ...
    def lights_around(self, count: int, camera: Camera) -> list[Light]: ...
    @property
    def shadows(self) -> bool: ...
    @shadows.setter
    def shadows(self, shadows: bool) -> None: ...
    @property
    def ambient(self) -> _Vector: ...
    @ambient.setter
    def ambient(self, ambient: Color | None) -> None: ...
    @property
    def given_ambient(self) -> _Vector | None: ...
    def set_sky(self, color: Color, zenith: Color | None = None) -> None: ...
    def set_sky_map(self, picture: _Path | npt.ArrayLike) -> None: ...
    def transform_object(self, object: int, transform: npt.ArrayLike) -> None: ...
    @property
    def bounds(self) -> list[_Vector] | None: ...
    @property
    def origin(self) -> _Vector: ...
    @origin.setter
    def origin(self, origin: Point, /) -> None: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def primitive_count(self) -> int: ...
    @property
    def object_count(self) -> int: ...
    @property
    def memory(self) -> int: ...
    def object_of(self, primitive: int) -> int: ...
    def object_name(self, object: int) -> str: ...
    def sha256(self) -> str: ...

@final
class Camera:
    """A stereo camera."""

    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __new__(cls, eye: Point, target: Point, **fields: Unpack[CameraFields]) -> Self: ...
    @staticmethod
    def fitting(scene: Scene, size: Sequence[int] = ...) -> Camera: ...  # size: (640, 480)
    @staticmethod
    def from_json(source: _Path, name: str | None = None, size: Sequence[int] | None = None) -> Camera: ...
    def replace(self, **fields: Unpack[CameraReplaceFields]) -> Camera: ...
    def orbited(self, degrees: float) -> Camera: ...
    @property
    def eye(self) -> _Vector: ...
    @property
    def forward(self) -> _Vector: ...
    @property
    def right(self) -> _Vector: ...
    @property
    def up(self) -> _Vector: ...
    @property
    def target(self) -> _Vector: ...
    @property
    def up_direction(self) -> _Vector: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def screen_distance(self) -> float: ...
    @property
    def interaxial(self) -> float: ...
    @property
    def interaxial_px(self) -> float: ...
    @property
    def intrinsics(self) -> Intrinsics: ...
    def disparity(self, depth: float) -> float: ...
    def project(self, point: Point, eye: Literal["left", "middle", "right"] = "left") -> _Vector: ...
    def to_json(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class Light:
    """A light without falloff."""

    __hash__: ClassVar[None]  # type: ignore[assignment]
    @staticmethod
    def point(position: Point, intensity: Color) -> Light: ...
    @staticmethod
    def sphere(position: Point, radius: float, intensity: Color) -> Light: ...
    @staticmethod
    def rectangle(position: Point, half_width: Point, half_height: Point, intensity: Color) -> Light: ...
    @staticmethod
    def directional(towards: Point, radius: float, intensity: Color) -> Light: ...
    @property
    def position(self) -> _Vector: ...
    @property
    def intensity(self) -> _Vector: ...
    @property
    def shape(self) -> str: ...
    @property
    def radius(self) -> float | None: ...
    def replace(self, *, position: Point | None = None, intensity: Color | None = None) -> Light: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class Material:
    """A surface: what it scatters, shines, reflects, lets through and gives off."""

    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __new__(cls, albedo: Color | None = None, **fields: Unpack[MaterialFields]) -> Self: ...
    def replace(self, **fields: Unpack[MaterialReplaceFields]) -> Material: ...
    @property
    def name(self) -> str: ...
    @property
    def albedo(self) -> _Vector: ...
    @property
    def texture(self) -> int | None: ...
    @property
    def cutout(self) -> int | None: ...
    @property
    def opacity(self) -> float: ...
    @property
    def specular(self) -> _Vector: ...
    @property
    def exponent(self) -> float: ...
    @property
    def normalised(self) -> bool: ...
    @property
    def emission(self) -> _Vector: ...
    @property
    def finish(self) -> str: ...
    @property
    def index(self) -> float | None: ...
    @property
    def transmission(self) -> _Vector | None: ...
    @property
    def fresnel(self) -> bool | None: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class View:
    """What one eye sees: its arrays are there where ``outputs`` names them."""

    @property
    def color(self) -> npt.NDArray[np.uint8]: ...
    @property
    def linear(self) -> npt.NDArray[np.float32]: ...
    @property
    def depth(self) -> npt.NDArray[np.float32]: ...
    @property
    def distance(self) -> npt.NDArray[np.float32]: ...
    @property
    def disparity(self) -> npt.NDArray[np.float32]: ...
    @property
    def occlusion(self) -> npt.NDArray[np.uint8]: ...
    @property
    def normal(self) -> npt.NDArray[np.float32]: ...
    @property
    def geometric_normal(self) -> npt.NDArray[np.float32]: ...
    @property
    def primitive(self) -> npt.NDArray[np.uint32]: ...
    @property
    def object(self) -> npt.NDArray[np.uint32]: ...
    @property
    def material(self) -> npt.NDArray[np.uint32]: ...
    @property
    def source(self) -> npt.NDArray[np.uint8]: ...
    @property
    def shadow_source(self) -> npt.NDArray[np.uint8]: ...
    @property
    def cost(self) -> npt.NDArray[np.uint32]: ...
    @property
    def size(self) -> tuple[int, int]: ...
    def arrays(self) -> dict[str, npt.NDArray[Any]]: ...
    def __dir__(self) -> list[str]: ...
    def _repr_png_(self) -> bytes: ...

@final
class StereoPair:
    """A stereo pair: two views and what they cost."""

    @property
    def left(self) -> View: ...
    @property
    def right(self) -> View: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def statistics(self) -> Statistics: ...
    def anaglyph(self, kind: str = "dubois") -> npt.NDArray[np.uint8]: ...
    def packed(self, packing: str = "side-by-side") -> npt.NDArray[np.uint8]: ...
    def retrace_map(self) -> npt.NDArray[np.uint8]: ...
    def write(self, folder: _Path, layout: str = "middlebury", index: int = 0) -> list[Path]: ...
    def save(self, path: _Path) -> None: ...
    def _repr_png_(self) -> bytes: ...

@final
class Views:
    """The views of several eyes on one line."""

    @property
    def views(self) -> list[View]: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def offsets(self) -> list[float]: ...
    @property
    def made_from(self) -> list[int]: ...
    @property
    def eyes(self) -> list[_Vector]: ...
    @property
    def work(self) -> list[Work]: ...
    def quilt(self, columns: int, rows: int) -> npt.NDArray[np.uint8]: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[View]: ...
    def __getitem__(self, index: SupportsIndex, /) -> View: ...

@final
class Renderer:
    """A graphics device that renders, and the scenes that stand on it."""

    def __new__(cls, adapter: str | None = None, *, kept_scenes: int = ...) -> Self: ...  # kept_scenes: 4
    @property
    def adapter(self) -> str: ...
    @property
    def driver(self) -> str: ...
    @property
    def is_software(self) -> bool: ...
    def render(
        self,
        scene: Scene,
        camera: Camera,
        *,
        progress: Callable[[str, float], object] | None = None,
        **options: Unpack[RenderOptions],
    ) -> StereoPair: ...
    def render_views(
        self,
        scene: Scene,
        camera: Camera,
        eyes: int | Sequence[float] | npt.NDArray[Any],
        *,
        traced: Sequence[int] | None = None,
        progress: Callable[[str, float], object] | None = None,
        **options: Unpack[RenderOptions],
    ) -> Views: ...
    def free_camera(
        self,
        scene: Scene,
        camera: Camera,
        seed: int,
        item: int,
        *,
        clearance: float | None = None,
        max_disparity: float | None = None,
        min_surfaces: float | None = None,
    ) -> tuple[Camera, int]: ...
    def closest_hits(
        self, scene: Scene, origins: npt.ArrayLike, directions: npt.ArrayLike
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]: ...
    def upload(self, scene: Scene, *, build: Literal["fast", "balanced", "best"] = "balanced") -> None: ...
    def release(self, scene: Scene) -> None: ...

def _restored(kind: str, state: bytes) -> Any: ...
def check_options(**options: Unpack[RenderOptions]) -> None: ...
def encode_png(picture: npt.NDArray[np.uint8] | npt.NDArray[np.uint16]) -> bytes: ...
