"""The spec of a data set: checks, defaults and one canonical form."""

from __future__ import annotations

import hashlib
import json
import math
import operator
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Mapping, Sequence

import stereotrace

from .file import MOST_LEVELS, SpecError, read
from .file import shown as _shown

FORMATS = ("webdataset", "parquet", *stereotrace.LAYOUTS)
POSES = ("free", "orbit", "fixed")
DRAWS = ("uniform", "log_uniform", "choice")
"""Distributions of drawn values: ``{"uniform": [low, high]}``, ``{"log_uniform": [low, high]}`` or
``{"choice": [...]}``."""

PARALLEL_LAYOUTS = ("kitti", "sceneflow")
"""Layouts that accept parallel cameras only. Parallel cameras are the default of all layouts."""
ENDINGS = {"webdataset": ".tar", "parquet": ".parquet"}
"""File endings of shards, by format."""
ONE_ROOT = {"kitti": "training"}
"""Layouts that put the pairs of all shards into one folder, and its name."""
LARGEST_DISPARITY = {"kitti": 256.0}
"""Limit of disparities in a layout's files, in pixels."""
DISPARITY_SHARE = 0.2
"""Default limit of disparities, as a share of the width."""
MOST_PAIRS = 2**31 - 1
MOST_VALUES = 1_000_000
"""Maximum number of values of a spec. Each use of an alias counts."""


@dataclass(frozen=True)
class Spec:
    """The checked spec of a data set.

    ``values`` are its keys and values in plain JSON types, with defaults filled in. Paths of scene files are relative
    to ``folder``, which is not part of the data set's identity."""

    values: dict[str, Any]
    folder: Path = field(compare=False)

    @staticmethod
    def load(source: str | Path | Mapping[str, Any]) -> Spec:
        """Reads a spec from a YAML or JSON file, or takes a dict.

        Raises ``SpecError``, which names the key, for an invalid spec, and ``OSError`` if the file can't be read."""
        if isinstance(source, Mapping):
            return Spec(_checked(source), Path.cwd())
        path = Path(source)
        try:
            values = read(path)
            if not isinstance(values, Mapping):
                raise SpecError("it must be a mapping of keys to values")
            return Spec(_checked(values), path.resolve().parent)
        except SpecError as error:
            raise SpecError(f"{path}: {error}") from None

    def __getitem__(self, key: str) -> Any:
        return self.values[key]

    @property
    def shards(self) -> int:
        """Number of shards."""
        return -(-int(self["pairs"]) // int(self["shard_pairs"]))

    def shard_name(self, shard: int) -> str:
        """Returns the name of a shard, without its ending."""
        return f"{self['name']}-{shard:06d}"

    def data_name(self, shard: int) -> str:
        """Returns the name of a shard's file or folder, or of the folder that all shards share."""
        if self["format"] in ONE_ROOT:
            return ONE_ROOT[self["format"]]
        return self.shard_name(shard) + ENDINGS.get(self["format"], "")

    def shard_items(self, shard: int) -> range:
        """Returns the numbers of a shard's pairs."""
        begin = shard * int(self["shard_pairs"])
        return range(begin, min(begin + int(self["shard_pairs"]), int(self["pairs"])))

    def scene_name(self, scene: int) -> str:
        """Returns a scene's name in records."""
        entry = self["scenes"][scene]
        return str(entry.get("file") or f"builtin:{entry['builtin']}")

    def scene_path(self, scene: int) -> Path | None:
        """Returns a scene's file, or ``None`` for a built-in scene."""
        file = self["scenes"][scene].get("file")
        return None if file is None else self.folder / file

    @property
    def is_layout(self) -> bool:
        """Whether a shard is a folder of files rather than one file."""
        return self["format"] in stereotrace.LAYOUTS

    def sha256(self) -> str:
        """Returns a hash of all values of the spec."""
        return hashlib.sha256(canonical(self.values).encode()).hexdigest()


def canonical(value: Any) -> str:
    """Returns canonical JSON."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


# --- Checks: each takes a value and the key's path, and returns the value to keep ---

Check = Callable[[Any, str], Any]


def _keys(value: Any, at: str, known: Mapping[str, tuple[Check, Any]]) -> dict[str, Any]:
    """Checks a mapping of known keys. Missing keys get their defaults, or stay missing if the default is ``None``."""
    if not isinstance(value, Mapping):
        raise SpecError(f"{at or 'the spec'}: {_shown(value)} must be a mapping of keys to values")
    unknown = [key for key in value if key not in known]
    if unknown:
        prefix = f"{at}: " if at else ""
        raise SpecError(f"{prefix}unknown key {_shown(unknown[0])}; the keys are {', '.join(known)}")
    found: dict[str, Any] = {}
    for key, (check, default) in known.items():
        given = value.get(key, default)
        if given is _NEEDED:
            raise SpecError(f"{_join(at, key)} is missing")
        if given is not None:
            found[key] = check(given, _join(at, key))
    return found


_NEEDED = object()


def _join(at: str, key: str) -> str:
    return f"{at}.{key}" if at else key


def _number(value: Any, at: str) -> float:
    # The value may be a string, since YAML 1.1 loaders read 1e-3 as text.
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            pass
    try:
        number = math.nan if isinstance(value, (bool, str)) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if math.isnan(number):
        raise SpecError(f"{at}: {_shown(value)} must be a number")
    return number


def _finite(value: Any, at: str) -> float:
    number = _number(value, at)
    if math.isinf(number):
        raise SpecError(f"{at}: {_shown(value)} must be finite")
    return number


def _whole(low: int, high: int) -> Check:
    def check(value: Any, at: str) -> int:
        try:
            whole = operator.index(value)
        except TypeError:
            whole = low - 1
        if isinstance(value, bool) or not low <= whole <= high:
            raise SpecError(f"{at}: {_shown(value)} must be a whole number, {low} to {high}")
        return whole

    return check


def _within(low: float, high: float = math.inf) -> Check:
    def check(value: Any, at: str) -> float:
        number = _finite(value, at)
        if not low <= number <= high:
            raise SpecError(
                f"{at}: {_shown(value)} must be " + (f"{low:g} or more" if high == math.inf else f"{low:g} to {high:g}")
            )
        return number

    return check


def _above(low: float, high: float = math.inf) -> Check:
    """Returns a check for numbers strictly between two values."""

    def check(value: Any, at: str) -> float:
        number = _finite(value, at)
        if not low < number < high:
            raise SpecError(
                f"{at}: {_shown(value)} must be above {low:g}" + ("" if high == math.inf else f" and below {high:g}")
            )
        return number

    return check


def _one_of(*known: str) -> Check:
    def check(value: Any, at: str) -> str:
        if value not in known:
            raise SpecError(f"{at}: unknown {_shown(value)}; use one of {', '.join(known)}")
        return str(value)

    return check


def _list(count: int | None, of: Check) -> Check:
    def check(value: Any, at: str) -> list[Any]:
        if (
            isinstance(value, (str, Mapping))
            or not isinstance(value, Sequence)
            or (count is not None and len(value) != count)
        ):
            expected = "a list" if count is None else f"a list of {count}"
            raise SpecError(f"{at}: {_shown(value)} must be {expected}")
        return [of(item, f"{at}[{index}]") for index, item in enumerate(value)]

    return check


def _color(value: Any, at: str) -> list[float]:
    if isinstance(value, (int, float, str)) and not isinstance(value, bool):
        value = [_finite(value, at)] * 3
    return list(_list(3, _within(0))(value, at))


def _drawn(of: Check) -> Check:
    """Returns a check for a value or a distribution of values."""

    def check(value: Any, at: str) -> Any:
        if not isinstance(value, Mapping):
            return of(value, at)
        if len(value) != 1 or next(iter(value)) not in DRAWS:
            raise SpecError(f"{at}: {_shown(value)} must be a value, or a mapping of one key: {', '.join(DRAWS)}")
        ((kind, given),) = value.items()
        if kind == "choice":
            choices = _list(None, of)(given, f"{at}.choice")
            if not choices:
                raise SpecError(f"{at}.choice: there is nothing to choose from")
            return {kind: choices}
        low, high = given = _list(2, lambda end, _: end)(given, f"{at}.{kind}")
        if _finite(low, f"{at}.{kind}[0]") > _finite(high, f"{at}.{kind}[1]") or (
            kind == "log_uniform" and _finite(low, at) <= 0
        ):
            positive = " above 0" if kind == "log_uniform" else ""
            raise SpecError(f"{at}.{kind}: {_shown(given)} must be a low and a high number{positive}")
        # Both ends must be valid values.
        return {kind: [of(low, f"{at}.{kind}[0]"), of(high, f"{at}.{kind}[1]")]}

    return check


def _text(value: Any, at: str) -> str:
    if not isinstance(value, str):
        raise SpecError(f"{at}: {_shown(value)} must be text")
    return value


def _flag(value: Any, at: str) -> bool:
    if not isinstance(value, bool):
        raise SpecError(f"{at}: {_shown(value)} must be true or false")
    return value


def _name(value: Any, at: str) -> str:
    if not isinstance(value, str) or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", value):
        raise SpecError(f"{at}: {_shown(value)} must be at most 64 letters, digits, - and _")
    return value


def _distance(value: Any, at: str) -> Any:
    """Checks a length. Infinity is kept as ``"inf"``, since JSON has no infinity."""
    number = math.inf if isinstance(value, str) and value in ("inf", ".inf") else _number(value, at)
    return "inf" if number == math.inf else _above(0)(number, at)


def _camera(value: Any, at: str) -> dict[str, Any]:
    point = _list(3, _finite)
    known: dict[str, tuple[Check, Any]] = {
        "name": (_text, None),
        "eye": (point, None),
        "target": (point, None),
        "up": (point, None),
    }
    found = _keys(value, at, known)
    if ("eye" in found) != ("target" in found):
        raise SpecError(f"{at}: give both eye and target, or none of them")
    if "name" in found and "eye" in found:
        raise SpecError(f"{at}: name selects a camera of the file, which has its own eye and target; leave these out")
    if "eye" in found and found["eye"] == found["target"]:
        raise SpecError(f"{at}.target: {_shown(found['target'])} must differ from the eye")
    if "up" in found and not any(found["up"]):
        raise SpecError(f"{at}.up: it must not be 0")
    return found


def _light(value: Any, at: str) -> dict[str, Any]:
    known: dict[str, tuple[Check, Any]] = {
        "position": (_list(3, _finite), None),
        "towards": (_list(3, _finite), None),
        "intensity": (_color, _NEEDED),
        "radius": (_within(0), None),
    }
    found = _keys(value, at, known)
    if ("position" in found) == ("towards" in found):
        raise SpecError(f"{at}: give a position, or towards for a light at infinity")
    if "towards" in found and not any(found["towards"]):
        raise SpecError(f"{at}.towards: it must not be 0")
    if "towards" in found and found.get("radius", 0) > 1.5:
        raise SpecError(f"{at}.radius: {_shown(found['radius'])} must be an angle of 0 to 1.5 radians")
    return found


def _lights(value: Any, at: str) -> Any:
    if isinstance(value, int) and not isinstance(value, bool):
        return _whole(0, 1000)(value, at)
    return _list(None, _light)(value, at)


def _sky(value: Any, at: str) -> Any:
    """Checks a sky: a colour, a picture's file, or ``procedural``."""
    try:
        return _color(value, at)
    except SpecError:
        if isinstance(value, str):
            return value
        raise


def _origin(value: Any, at: str) -> Any:
    if isinstance(value, str):
        return _one_of("auto", "none")(value, at)
    return _list(3, _finite)(value, at)


# Options of scene files.
_OF_FILES = ("crease_angle", "missing_textures", "origin", "outside_files")


def _scene(value: Any, at: str) -> dict[str, Any]:
    known: dict[str, tuple[Check, Any]] = {
        "file": (_text, None),
        "builtin": (_one_of(*stereotrace.BUILTINS), None),
        "weight": (_within(0), 1),
        "crease_angle": (_within(0, 180), None),
        "missing_textures": (_one_of("error", "warn"), None),
        "outside_files": (_one_of("refuse", "allow"), None),
        "origin": (_origin, None),
        "camera": (_camera, None),
        "lights": (_lights, None),
        "ambient": (_color, None),
        "sky": (_sky, None),
    }
    found = _keys(value, at, known)
    if ("file" in found) == ("builtin" in found):
        raise SpecError(f"{at}: give a file, or the name of a built-in scene")
    if "builtin" in found and (refused := [key for key in _OF_FILES if key in found]):
        raise SpecError(f"{at}: {refused[0]} is an option for files, but this scene is built in")
    return found


def _scenes(value: Any, at: str) -> list[dict[str, Any]]:
    scenes: list[dict[str, Any]] = _list(None, _scene)(value, at)
    if not any(scene["weight"] for scene in scenes):
        raise SpecError(f"{at}: at least one scene must have a weight above 0")
    return scenes


def _poses(value: Any, at: str) -> dict[str, Any]:
    kind = value.get("kind", "free") if isinstance(value, Mapping) else "free"
    known: dict[str, tuple[Check, Any]] = {"kind": (_one_of(*POSES), "free")}
    if kind == "free":
        known |= {
            "clearance": (_drawn(_within(0)), None),
            "max_disparity": (_above(0), None),
            "min_surfaces": (_within(0, 1), None),
        }
    if kind == "orbit":
        known |= {
            "turn": (_drawn(_finite), {"uniform": [0, 360]}),
            "rise": (_drawn(_finite), 0),
            "distance": (_drawn(_above(0)), 1),
        }
    return _keys(value, at, known)


def _rig(value: Any, at: str) -> dict[str, Any]:
    known: dict[str, tuple[Check, Any]] = {
        "interaxial": (_drawn(_within(0)), None),
        "interaxial_px": (_drawn(_within(0)), None),
        "baseline": (_drawn(_within(0)), None),
        "screen_distance": (_drawn(_distance), None),
        "fov": (_drawn(_above(0, 180)), None),
        "fx": (_drawn(_above(0)), None),
        "fy": (_drawn(_above(0)), None),
        "cx": (_drawn(_finite), None),
        "cy": (_drawn(_finite), None),
    }
    found = _keys(value, at, known)
    for same in (("interaxial", "interaxial_px", "baseline"), ("fov", "fx")):
        given = [key for key in same if key in found]
        if len(given) > 1:
            raise SpecError(f"{at}: {' and '.join(given)} set the same value; give one of them")
    for key in ("fy", "cx", "cy"):
        if key in found and "fx" not in found:
            raise SpecError(f"{at}.{key}: it needs fx")
    return found


def _random_lights(value: Any, at: str) -> dict[str, Any]:
    known: dict[str, tuple[Check, Any]] = {
        "count": (_drawn(_whole(1, 16)), 3),
        "strength": (_drawn(_within(0)), 0.85),
        "tint": (_drawn(_within(0)), 1),
        "radius": (_drawn(_within(0)), None),
    }
    return _keys(value, at, known)


def _random_materials(value: Any, at: str) -> dict[str, Any]:
    known: dict[str, tuple[Check, Any]] = {
        "share": (_within(0, 1), 1),
        "albedo": (_drawn(_within(0, 1)), None),
        "tint": (_drawn(_within(0)), None),
        "specular": (_drawn(_within(0, 1)), None),
        "exponent": (_drawn(_within(0, 10_000)), None),
    }
    found = _keys(value, at, known)
    if "albedo" in found and "tint" in found:
        raise SpecError(f"{at}: albedo replaces the colour that tint multiplies; give one of them")
    return found


def _randomise(value: Any, at: str) -> dict[str, Any]:
    known: dict[str, tuple[Check, Any]] = {
        "lights": (_random_lights, None),
        "materials": (_random_materials, None),
        "ambient": (_drawn(_within(0)), None),
        "exposure": (_drawn(_within(-64, 64)), None),
    }
    return _keys(value, at, known)


def _render(value: Any, at: str) -> dict[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise SpecError(f"{at}: {_shown(value)} must be a mapping of options to values")
    for key, instead in (("outputs", "outputs"), ("exposure", "randomise.exposure"), ("count", None)):
        if key in value:
            raise SpecError(f"{at}.{key}: " + (f"use the key {instead}" if instead else "data sets have no counters"))
    try:
        stereotrace.check_options(**value)
    except (ValueError, TypeError) as error:
        raise SpecError(f"{at}: {error}") from None
    return dict(value)


EYES = ("left", "right")
_OF_RIGHT = ("source", "shadow_source")


def _outputs(value: Any, at: str) -> list[str]:
    names: list[str] = _list(None, _text)(value, at)
    for index, name in enumerate(names):
        eye, dot, output = name.rpartition(".")
        if output not in stereotrace.OUTPUTS or (dot and eye not in EYES):
            known = ", ".join(stereotrace.OUTPUTS)
            prefixes = "for one eye with the prefix left. or right."
            raise SpecError(f"{at}[{index}]: unknown {_shown(name)}; use one of {known}, {prefixes}")
        if output in _OF_RIGHT and eye == "left":
            raise SpecError(f"{at}[{index}]: {output} exists only for the right view")
    if not names:
        raise SpecError(f"{at}: it must not be empty")
    return names


def _check_extent(value: Any) -> None:
    """Refuses specs with too deep nesting or too many values, before anything else walks through them."""
    waiting, count = [(value, 1)], 0
    while waiting:
        part, level = waiting.pop()
        count += 1
        if count > MOST_VALUES:
            raise SpecError(f"it has over {MOST_VALUES} values")
        if isinstance(part, (str, bytes)) or not isinstance(part, (Mapping, Sequence)):
            continue
        if level > MOST_LEVELS:
            raise SpecError(f"its lists and mappings are nested more than {MOST_LEVELS} levels deep")
        if len(part) > MOST_VALUES - count - len(waiting):
            raise SpecError(f"it has over {MOST_VALUES} values")
        waiting += [(inner, level + 1) for inner in (part.values() if isinstance(part, Mapping) else part)]


def _checked(value: Mapping[str, Any]) -> dict[str, Any]:
    _check_extent(value)
    known: dict[str, tuple[Check, Any]] = {
        "name": (_name, "pairs"),
        "seed": (_whole(0, 2**32 - 1), 0),
        "pairs": (_whole(1, MOST_PAIRS), _NEEDED),
        "shard_pairs": (_whole(1, 100_000), 64),
        "format": (_one_of(*FORMATS), "webdataset"),
        "size": (_list(2, _whole(1, 2**17)), [640, 480]),
        "scenes": (_scenes, _NEEDED),
        "poses": (_poses, {}),
        "rig": (_rig, {}),
        "randomise": (_randomise, {}),
        "render": (_render, {}),
        "outputs": (_outputs, None),
        "compress": (_flag, None),
    }
    found = _keys(value, "", known)
    layout = found["format"] in stereotrace.LAYOUTS
    for key in ("outputs", "compress"):
        if layout and key in found:
            raise SpecError(f"{key}: the layout {found['format']} sets the files; leave this key out")
    if not layout:
        found = {"outputs": ["color", "disparity", "occlusion"], "compress": False, **found}
    _check_together(found)
    if found["format"] == "sceneflow" and found["pairs"] > 10_000:
        raise SpecError("pairs: sceneflow numbers its files with four digits: at most 10000")
    return found


EXACT_METHODS = ("auto", "naive", "bracket", "verified", "bracket-rays")
"""Methods whose pixels show the surfaces at their centres, to which ground truth belongs."""
_TRUTH = ("distance", "occlusion", "normal", "geometric_normal", "material")


def _check_together(found: Mapping[str, Any]) -> None:
    """Refuses valid values that contradict each other."""
    method = found["render"].get("method", "auto")
    outputs = [name.rpartition(".")[2] for name in found.get("outputs", ["occlusion"])]
    truth = [output for output in outputs if output in _TRUTH]
    if truth and method not in EXACT_METHODS:
        reason = f"{method} shows points up to half a pixel off, but {truth[0]} is for pixel centres"
        raise SpecError(f"render.method: {reason}; use one of {', '.join(EXACT_METHODS)}")
    if "shadow_source" in outputs and (method == "naive" or method not in EXACT_METHODS):
        raise SpecError(f"outputs: shadow_source needs a bracket method, not {method}")
    rig = found["rig"]
    # Cameras with one cx for both eyes are parallel, unless a screen distance is given.
    distance = rig.get("screen_distance", "inf" if found["format"] in stereotrace.LAYOUTS or "fx" in rig else None)
    distances = distance["choice"] if isinstance(distance, dict) and "choice" in distance else [distance]
    if found["format"] in PARALLEL_LAYOUTS and any(one != "inf" for one in distances):
        raise SpecError(
            f"rig.screen_distance: the cameras of {found['format']} are parallel: leave it out, or set it to inf"
        )
    if "interaxial_px" in rig and any(one == "inf" for one in distances):
        raise SpecError(
            "rig.interaxial_px: it is the parallax at infinity, which is 0 for parallel cameras; give interaxial"
        )


def eye_outputs(outputs: Sequence[str]) -> list[tuple[str, str]]:
    """Returns eye and output of each array, in order. A name without an eye means both eyes."""
    found: list[tuple[str, str]] = []
    for name in outputs:
        eye, _, output = name.rpartition(".")
        eyes = (eye,) if eye else ("right",) if output in _OF_RIGHT else EYES
        found += [(eye, output) for eye in eyes if (eye, output) not in found]
    return found
