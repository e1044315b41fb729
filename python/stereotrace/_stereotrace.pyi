"""Types of the part of ``stereotrace`` that is written in Rust. ``help`` shows the full docstrings."""

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
    "OPTIONS",
    "OUTPUTS",
    "PACKINGS",
    "AdapterError",
    "Camera",
    "Correspondence",
    "DataSetSpec",
    "DeviceLostError",
    "EyeFlow",
    "EyeLayers",
    "EyeMatches",
    "Flow",
    "Layers",
    "Light",
    "LimitError",
    "Material",
    "PairMaker",
    "Passes",
    "Renderer",
    "Scene",
    "StereoPair",
    "View",
    "Views",
    "__version__",
    "_restored",
    "check_options",
    "decode_png",
    "encode_png",
]

__version__: Final[str]
MISS: Final[int]
METHODS: Final[list[str]]
BUILTINS: Final[list[str]]
LAYOUTS: Final[list[str]]
ANAGLYPHS: Final[list[str]]
PACKINGS: Final[list[str]]
OPTIONS: Final[list[str]]
OUTPUTS: Final[list[str]]

Point: TypeAlias = Sequence[float] | npt.NDArray[Any]
Color: TypeAlias = float | Sequence[float] | npt.NDArray[Any]
_Path: TypeAlias = str | os.PathLike[str]
_Vector: TypeAlias = tuple[float, float, float]

class AdapterError(RuntimeError):
    """No graphics adapter is suitable, or its driver refused a request."""

class LimitError(AdapterError):
    """A picture or scene exceeds the adapter's limits or memory."""

class DeviceLostError(AdapterError):
    """The device was lost."""

@type_check_only
class RenderOptions(TypedDict, total=False):
    """Options of rendering: the keywords of ``Renderer.render``."""

    # Method that makes the right view: one of METHODS, or buffer-N for N slots. Default "auto".
    method: str
    # Arrays to return: names of OUTPUTS, or one name. Default ["color", "depth", "disparity"].
    outputs: str | Sequence[str]
    # Samples per pixel, for antialiasing: 1, 4, 9, 16, 25, 36, 49 or 64. Default 1.
    samples: int
    # Weights of samples. Default "box".
    filter: Literal["box", "tent", "gauss"]
    # Whether to jitter the sample grid. Default True.
    jitter: bool
    # Adaptive antialiasing: levels, 2 to 5, and a tolerance in 8-bit values, 0 to 255. Default None.
    adaptive: Sequence[float] | None
    # Light by other surfaces: "direct", "paths", "paths=SAMPLES" or "paths=SAMPLES:BOUNCES". Default "direct".
    lighting: str
    # Whether to remove noise from light by paths. Default False.
    denoise: bool
    # Maximum number of reflections and refractions along a ray, 0 to 8. Default 5.
    bounces: int
    # Rays to each light that is not a point, 1 to 32. Default 16.
    shadow_rays: int
    # Ambient occlusion: rays, 1 to 32, and radius for occluders in world units, above 0. Default None.
    ambient_occlusion: Sequence[float] | None
    # Number of rays, 1 to 32, by which the sky lights surfaces, in place of ambient light. Default None.
    sky_rays: int | None
    # Results of soft shadow rays that a view reuses: of fully lit or shadowed points, or of penumbrae too. Default
    # "shared".
    penumbra: Literal["exact", "shared"]
    # Seed of all random numbers, 0 to 2**32 - 1. Default 0.
    seed: int
    # Exposure in stops, -64 to 64. Default 0.
    exposure: float
    # Tone mapping. Default "clamp".
    tone: Literal["clamp", "filmic"]
    # Whether each view has its own random numbers. Default False.
    noise_by_view: bool
    # How traced views find their closest hits. Default "rays".
    visibility: Literal["rays", "t-buffer"]
    # Shadow buffers in place of shadow rays to point lights: rows of a table, 1 or more, and a rule. Default None.
    shadow_buffer: tuple[int, Literal["object", "depth", "hybrid"]] | None
    # Memory for samples of earlier frames in MiB, by which the next frame finds the same first hits. Default None.
    history: int | None
    # Whether to count BVH nodes and primitive tests, which is slower. Default False.
    count: bool

@type_check_only
class Intrinsics(TypedDict):
    """Focal lengths and principal points in pixels, with pixel centres at halves."""

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
    """Intrinsics as a camera takes them."""

    fx: Required[float]
    # Default fx.
    fy: NotRequired[float]
    cx0: Required[float]
    # Default cx0.
    cx1: NotRequired[float]
    cy: Required[float]

@type_check_only
class LensFields(TypedDict, total=False):
    """A lens of ``Camera``."""

    # Focal lengths in pixels; ``fy`` defaults to ``fx``.
    fx: Required[float]
    fy: float
    # Principal point in pixels, with pixel centres at halves.
    cx: Required[float]
    cy: Required[float]
    # OpenCV's coefficients k1, k2, p1, p2, then optionally k3, then optionally k4, k5, k6.
    radial_tangential: Sequence[float] | npt.NDArray[Any]
    # OpenCV's coefficients k1 to k4, in place of ``radial_tangential``.
    fisheye: Sequence[float] | npt.NDArray[Any]

@type_check_only
class LensPair(TypedDict):
    """The lenses of both eyes of ``Camera``."""

    left: LensFields
    right: LensFields

@type_check_only
class CameraFields(TypedDict, total=False):
    """The keywords of ``Camera``."""

    # Up direction of the picture, of any length. Default (0, 1, 0).
    up: Point
    # Width and height in pixels, 1 to 131072 each. Default (640, 480).
    size: Sequence[int]
    # Vertical field of view in degrees, between 0 and 180. Default 45.
    fov: float
    # Width of the screen rectangle in world units, in place of the field of view.
    screen_width: float
    # Calibration in pixels, in place of the field of view.
    intrinsics: Intrinsics | IntrinsicsFields
    # Distance from the eyes to the screen (convergence distance) in world units, infinite for parallel cameras. Default
    # the target's distance.
    screen_distance: float
    # Distance between the eyes (baseline) in world units. Default a thirtieth of the target's distance.
    interaxial: float
    # Distance between the eyes in pixels of the picture; not for parallel cameras.
    interaxial_px: float
    # Whether the eyes turn towards each other. Default False.
    toe_in: bool
    # "planar", or 360 or 180 for equirectangular pictures of so many degrees. Default "planar".
    projection: Literal["planar", 180, 360]
    # Elevations in degrees between which the eyes of an equirectangular pair approach each other. Default (60, 75).
    pole_merge: tuple[float, float] | None
    # A lens with distortion, or the lenses of both eyes. Default None.
    lens: LensFields | LensPair | None

@type_check_only
class CameraReplaceFields(CameraFields, total=False):
    """The keywords of ``Camera.replace``."""

    # World position of the midpoint between the eyes.
    eye: Point
    # World position that the camera looks at.
    target: Point

@type_check_only
class MaterialFields(TypedDict, total=False):
    """The keywords of ``Material`` beside ``albedo``."""

    # Name in messages. Default empty.
    name: str
    # Id of the texture that multiplies the albedo. Default None.
    texture: int | None
    # Id of the texture that cuts the surface out where its alpha is below a half. Default None.
    cutout: int | None
    # Share of the background that the surface hides, 0 to 1. Default 1.
    opacity: float
    # Whether the alpha of ``texture`` multiplies the opacity. Default False.
    alpha_blend: bool
    # Colour of highlights, or reflectance of mirrors and glass, linear RGB, 0 to 1. Default black for matte surfaces;
    # see ``Material`` for others.
    specular: Color
    # Phong's exponent, 0 to 10000. Default 30.
    exponent: float
    # Whether highlights conserve energy. Default False.
    normalised: bool
    # Emitted radiance, linear RGB, 0 or more. Default black.
    emission: Color
    # Reflection or refraction of the surface. Default "matte".
    finish: Literal["matte", "mirror", "glass"]
    # Glass: refractive index relative to the surrounding medium, 0.1 to 10. Default 1.5.
    index: float
    # Glass: share of light that is transmitted, linear RGB, 0 to 1. Default white.
    transmission: Color
    # Mirrors and glass: whether the reflectance depends on the angle. Default False for mirrors, True for glass.
    fresnel: bool

@type_check_only
class PrincipledFields(TypedDict, total=False):
    """The keywords of ``Material.principled`` beside ``base``."""

    # 0 for a dielectric, 1 for a metal. Default 0.
    metallic: float
    # 0, smooth, to 1. Default 0.5.
    roughness: float
    # Refractive index of a dielectric, 0.1 to 10. Default 1.5.
    index: float
    # Factor of a dielectric's reflectance, 0 to 1. Default 1.
    specular: float
    # Further factor at normal incidence, linear RGB, 0 to 1. Default 1.
    specular_color: Color
    # Share of the light that enters a dielectric and is transmitted, 0 to 1. Default 0.
    transmission: float
    # Whether transmitted light is not refracted. Default False.
    thin: bool
    # Light that is absorbed inside per world unit, linear RGB. Default 0.
    absorption: Color
    # Share of the surface under a clear coat, 0 to 1. Default 0.
    clearcoat: float
    # Roughness of the clear coat, 0 to 1. Default 0.
    clearcoat_roughness: float
    # Emitted radiance, linear RGB. Default 0.
    emission: Color
    # Factor of the normals' x and y. Default 1.
    normal_scale: float
    # Ids of textures, which multiply the values of these names; ``texture`` multiplies ``base``. Default None.
    texture: int | None
    roughness_texture: int | None
    metallic_texture: int | None
    normal_texture: int | None
    emission_texture: int | None
    transmission_texture: int | None
    clearcoat_texture: int | None
    clearcoat_roughness_texture: int | None
    # As in ``Material``.
    name: str
    cutout: int | None
    opacity: float
    alpha_blend: bool

@type_check_only
class MaterialReplaceFields(MaterialFields, total=False):
    """The keywords of ``Material.replace``."""

    # Diffuse reflectance, linear RGB, 0 to 1.
    albedo: Color

@type_check_only
class Work(TypedDict):
    """Cost of one view."""

    # Closest-hit rays through pixels.
    primary_rays: int
    # Rays of limited length that check reused pixels.
    verification_rays: int
    # Rays towards lights.
    shadow_rays: int
    # Rays from mirrors, glass and translucent surfaces.
    secondary_rays: int
    # BVH nodes visited; 0 unless counted.
    nodes: int
    # Primitives tested; 0 unless counted.
    primitive_tests: int
    # 2 * nodes + primitive_tests.
    cost: int

@type_check_only
class Choice(TypedDict):
    """Choice of the method ``auto``, and its reasons."""

    # Method that made most of the right view.
    method: str
    # Share of the right view made by bracket, 0 to 1.
    by_bracket: float
    # Share of right pixels that no left sample saw, 0 to 1.
    gaps: float
    # Shadow rays per pixel of the left view.
    shadow_rays: float
    # Rays per pixel of the left view from mirrors, glass and translucent surfaces.
    secondary_rays: float
    # Predicted cost of the right view by bracket, in primary rays per pixel.
    bracket: float
    # Predicted cost of the right view by naive, in primary rays per pixel.
    naive: float

@type_check_only
class Statistics(TypedDict):
    """Cost of a pair."""

    # Method that made the pair.
    method: str
    # Reasons of auto; None for other methods.
    choice: Choice | None
    # Whether the frame was rendered again in steps.
    in_steps: bool
    left: Work
    right: Work
    # Number of right pixels that were reused from the left view.
    reused: int
    # Number of right pixels whose left sample was rejected; they were traced.
    bad: int
    # Number of right pixels without a left sample; they were traced.
    missed: int
    # Share of right pixels that were traced, 0 to 1.
    retraced_share: float
    # Cost of the right view relative to the left view; None unless counted.
    second_eye: float | None
    # Buffer methods: number of lost candidates.
    lost_candidates: int
    # Buffer methods: number of slots a right pixel.
    buffer_depth: int
    # Name and seconds of each pass in order; None if the adapter has no timestamps.
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
    @property
    def animations(self) -> list[tuple[str, float]]: ...
    def pose(self, seconds: float, animation: str | int | None = None) -> None: ...
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
    def add_plane(
        self, point: Point, normal: Point = ..., material: int = 0, *, tile: float = 1.0
    ) -> None: ...  # normal: (0, 1, 0)
    def add_material(self, material: Material) -> int: ...
    def set_material(self, id: int, material: Material) -> None: ...
    @property
    def materials(self) -> list[Material]: ...
    def add_texture(
        self,
        picture: _Path | npt.NDArray[np.uint8],
        wrap: Literal["repeat", "mirror", "clamp"] = "repeat",
        *,
        data: bool = False,
    ) -> int: ...
    def add_checkerboard(self, first: Color, second: Color, squares: int) -> int: ...
    def add_dots(self, width: int, height: int, count: int, seed: int = 0) -> int: ...
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
    def set_sky(self, color: Color, zenith: Color | None = None) -> None: ...
    def set_sky_map(self, picture: _Path | npt.ArrayLike, *, turn: float = 0.0, gain: float = 1.0) -> None: ...
    def set_mesh(
        self,
        object: int,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        name: str = "",
        material: int | Sequence[int] | npt.NDArray[np.integer[Any]] | None = None,
        normals: npt.ArrayLike | None = None,
        uv: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        crease_angle: float | None = None,
    ) -> None: ...
    @property
    def triangles(self) -> npt.NDArray[np.float32]: ...
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
    @property
    def radians_per_pixel(self) -> tuple[float, float] | None: ...
    @property
    def lens(self) -> LensPair | None: ...
    def rectified(self) -> Camera: ...
    def rectify_map(
        self, eye: Literal["left", "right"] = "left"
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]: ...
    def raised(self, distance: float) -> Camera: ...
    def disparity(self, depth: float) -> float: ...
    def project(self, point: Point, eye: Literal["left", "middle", "right"] = "left") -> _Vector: ...
    def to_json(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class Light:
    """A light."""

    __hash__: ClassVar[None]  # type: ignore[assignment]
    @staticmethod
    def point(position: Point, intensity: Color) -> Light: ...
    @staticmethod
    def sphere(position: Point, radius: float, intensity: Color) -> Light: ...
    @staticmethod
    def rectangle(position: Point, half_width: Point, half_height: Point, intensity: Color) -> Light: ...
    @staticmethod
    def directional(towards: Point, radius: float, intensity: Color) -> Light: ...
    def with_quadratic_falloff(self, *, range: float | None = None) -> Light: ...
    def with_cone(self, direction: Point, inner: float, outer: float) -> Light: ...
    def with_projector(self, texture: int, direction: Point, up: Point, fov: float) -> Light: ...
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
    """A surface: diffuse reflectance, highlights, reflection, transmission and emission."""

    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __new__(cls, albedo: Color | None = None, **fields: Unpack[MaterialFields]) -> Self: ...
    @staticmethod
    def principled(base: Color | None = None, **fields: Unpack[PrincipledFields]) -> Material: ...
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
    def alpha_blend(self) -> bool: ...
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
    """The view of one eye, with the arrays that ``outputs`` named."""

    @property
    def color(self) -> npt.NDArray[np.uint8]: ...
    @property
    def linear(self) -> npt.NDArray[np.float32]: ...
    @property
    def albedo(self) -> npt.NDArray[np.float32]: ...
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
    """A stereo pair: two views and their cost."""

    @property
    def left(self) -> View: ...
    @property
    def right(self) -> View: ...
    @property
    def motion(self) -> tuple[StereoPair, Flow, Flow] | None: ...
    @property
    def layers(self) -> Layers | None: ...
    @property
    def matches(self) -> Correspondence | None: ...
    @property
    def array(self) -> dict[tuple[int, int], StereoPair]: ...
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
class Correspondence:
    """Places of a pair's points in the other eye's picture."""

    @property
    def left(self) -> EyeMatches: ...
    @property
    def right(self) -> EyeMatches: ...

@final
class EyeMatches:
    """Places of one view's points in the other eye's picture, as arrays."""

    @property
    def place(self) -> npt.NDArray[np.float32]: ...
    @property
    def visibility(self) -> npt.NDArray[np.uint8]: ...

@final
class EyeFlow:
    """Motion of the points that one view shows, as arrays."""

    @property
    def flow(self) -> npt.NDArray[np.float32]: ...
    @property
    def disparity_change(self) -> npt.NDArray[np.float32]: ...
    @property
    def displacement(self) -> npt.NDArray[np.float32]: ...
    @property
    def visibility(self) -> npt.NDArray[np.uint8]: ...

@final
class Flow:
    """Motion of a pair's points to another time."""

    @property
    def left(self) -> EyeFlow: ...
    @property
    def right(self) -> EyeFlow: ...

@final
class EyeLayers:
    """The surfaces that the lines of sight of one view meet, as arrays."""

    @property
    def count(self) -> npt.NDArray[np.uint32]: ...
    @property
    def depth(self) -> npt.NDArray[np.float32]: ...
    @property
    def distance(self) -> npt.NDArray[np.float32]: ...
    @property
    def disparity(self) -> npt.NDArray[np.float32]: ...
    @property
    def vertical_disparity(self) -> npt.NDArray[np.float32]: ...
    @property
    def visibility(self) -> npt.NDArray[np.uint8]: ...
    @property
    def bends(self) -> npt.NDArray[np.uint32]: ...
    @property
    def position(self) -> npt.NDArray[np.float32]: ...
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

@final
class Layers:
    """All surfaces along the lines of sight of a pair."""

    @property
    def left(self) -> EyeLayers: ...
    @property
    def right(self) -> EyeLayers: ...

@final
class Views:
    """Views of several eyes on one line."""

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
class Passes:
    """The passes of a picture so far, for the argument ``passes`` of ``Renderer.render``."""

    def __new__(cls) -> Self: ...
    @property
    def count(self) -> int: ...
    @property
    def paths(self) -> int: ...

@final
class Renderer:
    """A graphics device that renders, and the scenes uploaded to it."""

    # kept_scenes: 4
    def __new__(
        cls, adapter: str | None = None, *, kept_scenes: int = ..., ray_queries: bool = False
    ) -> Self: ...
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
        passes: Passes | None = None,
        progress: Callable[[str, float], object] | None = None,
        **options: Unpack[RenderOptions],
    ) -> StereoPair: ...
    def suggest_exposure(self, scene: Scene, camera: Camera, **options: Unpack[RenderOptions]) -> float: ...
    def render_views(
        self,
        scene: Scene,
        camera: Camera,
        eyes: int | Sequence[float] | npt.NDArray[Any],
        *,
        traced: Sequence[int] | None = None,
        passes: Passes | None = None,
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
    def flow(self, pair: StereoPair, scene: Scene, then: Scene, camera: Camera | None = None) -> Flow: ...
    def correspondence(self, pair: StereoPair, scene: Scene) -> Correspondence: ...
    def pair_of(
        self, views: Views, scene: Scene, left: int, right: int, *, below: Views | None = None
    ) -> StereoPair: ...
    def layers(
        self,
        pair: StereoPair,
        scene: Scene,
        surfaces: int = 4,
        *,
        refracted: bool = False,
        mirrored: bool = False,
    ) -> Layers: ...
    def closest_hits(
        self, scene: Scene, origins: npt.ArrayLike, directions: npt.ArrayLike
    ) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.uint32]]: ...
    def upload(self, scene: Scene, *, build: Literal["fast", "balanced", "best"] = "balanced") -> None: ...
    def release(self, scene: Scene) -> None: ...
    def forget(self) -> None: ...
    def calibrate(self) -> tuple[float, float, float]: ...
    @property
    def calibration(self) -> tuple[float, float, float]: ...
    @calibration.setter
    def calibration(self, numbers: tuple[float, float, float]) -> None: ...

@final
class DataSetSpec:
    """A checked spec of a data set, from JSON text. Paths of files are relative to ``folder``."""

    def __new__(cls, text: str, folder: str | os.PathLike[str]) -> Self: ...
    def to_json(self) -> str: ...
    @property
    def arrays(self) -> list[tuple[str, str]]: ...

@final
class PairMaker:
    """Makes the pairs of a spec. It reads scenes when they are needed, and keeps the most recently used ones."""

    def __new__(cls, spec: DataSetSpec, scene_memory: int) -> Self: ...
    def expect_hashes(self, hashes: Sequence[str | None]) -> None: ...
    @property
    def scenes_read(self) -> list[int]: ...
    def has_scene(self, scene: int) -> bool: ...
    def scene_of(self, item: int) -> int: ...
    def scene(self, scene: int) -> Scene: ...
    def scene_sha256(self, scene: int) -> str: ...
    def pair(self, renderer: Renderer, item: int) -> tuple[StereoPair, str]: ...

def _restored(kind: str, state: bytes) -> Any: ...
def check_options(**options: Unpack[RenderOptions]) -> None: ...
def decode_png(file: bytes) -> npt.NDArray[Any]: ...
def encode_png(picture: npt.NDArray[np.uint8] | npt.NDArray[np.uint16]) -> bytes: ...
