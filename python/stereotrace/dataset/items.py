"""Draws the values of a pair. A value depends only on the spec, the pair's number and the value's name."""

from __future__ import annotations

import hashlib
import math
from typing import Any, Mapping

import numpy as np

import stereotrace
from stereotrace import Camera, Light, Material, Scene

from .spec import DISPARITY_SHARE, LARGEST_DISPARITY, Spec

PLACES = 16
"""Number of places that random lights are chosen from."""


class Item:
    """The draws of one pair."""

    def __init__(self, spec: Spec, number: int) -> None:
        self.spec = spec
        self.number = number

    def unit(self, name: str) -> float:
        """Returns the random number of this name, from 0 up to but not including 1. Other draws do not affect it."""
        text = f"{self.spec['seed']}/{self.number}/{name}"
        return (int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big") >> 11) / 2**53

    def draw(self, value: Any, name: str) -> Any:
        """Returns a value of the spec, drawn if the spec gives a distribution."""
        if not isinstance(value, Mapping):
            return value
        ((kind, given),) = value.items()
        unit = self.unit(name)
        if kind == "choice":
            return given[int(unit * len(given))]
        low, high = given
        if isinstance(low, int):  # the spec's checks keep whole numbers as int
            drawn = low + unit * (high + 1 - low) if kind == "uniform" else low * ((high + 1) / low) ** unit
            return min(int(drawn), high)
        drawn = (
            low + unit * (high - low) if kind == "uniform" else math.exp(math.log(low) + unit * math.log(high / low))
        )
        # Rounded to f32's digits, since the last bits of exp and log differ between machines.
        return float(f"{drawn:.7g}")

    def scene(self) -> int:
        """Draws the scene by the scenes' weights, and returns its index."""
        weights = [scene["weight"] for scene in self.spec["scenes"]]
        left = self.unit("scene") * sum(weights)
        for index, weight in enumerate(weights):
            if left < weight:
                return index
            left -= weight
        return max(index for index, weight in enumerate(weights) if weight)

    @staticmethod
    def camera_of(spec: Spec, place: int, scene: Scene) -> Camera:
        """Returns the camera that the spec gives for a scene, or the scene's own."""
        given = spec["scenes"][place].get("camera", {})
        camera = scene.camera(given.get("name"), size=spec["size"])
        if "eye" in given:
            camera = Camera(given["eye"], given["target"], size=spec["size"])
        return camera.replace(up=given["up"]) if "up" in given else camera

    def given_camera(self, scene: Scene) -> Camera:
        """Returns the scene's camera with the item's rig, from which poses are drawn."""
        rig = self.spec["rig"]
        camera = self.camera_of(self.spec, self.scene(), scene)
        fields = {name: self.draw(value, f"rig.{name}") for name, value in rig.items()}
        if "baseline" in fields:
            fields["interaxial"] = fields.pop("baseline")
        lens = {name: fields.pop(name) for name in ("fx", "fy", "cx", "cy") if name in fields}
        if lens:
            width, height = self.spec["size"]
            cx, cy = lens.pop("cx", width / 2), lens.pop("cy", height / 2)
            fields["intrinsics"] = {**lens, "cx0": cx, "cy": cy}
            if "interaxial_px" not in fields:
                fields.setdefault("interaxial", camera.interaxial)  # pixels would depend on the focal length
        if self.spec.is_layout:
            fields.setdefault("screen_distance", "inf")
        if fields.get("screen_distance") == "inf":
            fields["screen_distance"] = math.inf
        return camera.replace(**fields) if fields else camera

    def camera(self, renderer: stereotrace.Renderer, scene: Scene) -> tuple[Camera, int]:
        """Returns the item's camera, and the number of tries to find it."""
        given, poses = self.given_camera(scene), self.spec["poses"]
        if poses["kind"] == "fixed":
            return given, 1
        if poses["kind"] == "orbit":
            return self._orbited(given), 1
        limit = poses.get("max_disparity", DISPARITY_SHARE * self.spec["size"][0])
        return renderer.free_camera(
            scene,
            given,
            self.spec["seed"],
            self.number,
            clearance=self.draw(poses.get("clearance"), "poses.clearance"),
            max_disparity=min(limit, LARGEST_DISPARITY.get(self.spec["format"], math.inf)),
            min_surfaces=poses.get("min_surfaces"),
        )

    def _orbited(self, camera: Camera) -> Camera:
        """Orbits the camera about its target by ``turn`` and ``rise`` in degrees, and scales its distance."""
        poses = self.spec["poses"]
        turn, rise, distance = (self.draw(poses[name], f"poses.{name}") for name in ("turn", "rise", "distance"))
        eye, target = (np.array(point, np.float64) for point in (camera.eye, camera.target))
        up = np.array(camera.up_direction, np.float64)
        up /= np.linalg.norm(up)
        turned = _turned(eye - target, up, math.radians(turn))
        side = np.cross(up, turned)
        if np.linalg.norm(side) > 0:
            turned = _turned(turned, side / np.linalg.norm(side), -math.radians(rise))
        return camera.replace(eye=_rounded(target + distance * turned))

    def lights(self, scene: Scene, own: list[Light], camera: Camera) -> list[Light]:
        """Returns the lights: drawn ones, or those that the spec gives for the scene, or the scene's own.

        Without any of these it places three lights around the camera."""
        drawn, given = self.spec["randomise"].get("lights"), self.spec["scenes"][self.scene()].get("lights")
        if drawn is not None:
            return self._drawn_lights(drawn, scene, camera)
        if isinstance(given, list):
            return [_light(light) for light in given]
        if given is None and own:
            return own
        return scene.lights_around(3 if given is None else given, camera)

    def _drawn_lights(self, drawn: Mapping[str, Any], scene: Scene, camera: Camera) -> list[Light]:
        placed = scene.lights_around(PLACES, camera)
        count = self.draw(drawn["count"], "lights.count")
        order = sorted(range(PLACES), key=lambda place: self.unit(f"lights.place.{place}"))
        lights = []
        for index, place in enumerate(order[:count]):
            strength = self.draw(drawn["strength"], f"lights.{index}.strength") / count
            tints = [self.draw(drawn["tint"], f"lights.{index}.tint.{channel}") for channel in "rgb"]
            light = {"position": list(placed[place].position), "intensity": [strength * tint for tint in tints]}
            if "radius" in drawn:
                light["radius"] = self.draw(drawn["radius"], f"lights.{index}.radius")
            lights.append(_light(light))
        return lights

    def ambient(self) -> Any:
        """Returns the ambient light, or ``None`` for the scene's own."""
        drawn = self.draw(self.spec["randomise"].get("ambient"), "ambient")
        return self.spec["scenes"][self.scene()].get("ambient") if drawn is None else drawn

    def exposure(self) -> float:
        """Returns the exposure in stops."""
        return float(self.draw(self.spec["randomise"].get("exposure", 0), "exposure"))

    def material(self, place: int, own: Material) -> Material:
        """Returns the scene's material ``place``, with its drawn fields."""
        drawn = self.spec["randomise"].get("materials")
        if drawn is None or self.unit(f"materials.{place}.share") >= drawn["share"]:
            return own
        fields: dict[str, Any] = {}
        if "albedo" in drawn:
            fields["albedo"] = tuple(
                self.draw(drawn["albedo"], f"materials.{place}.albedo.{channel}") for channel in "rgb"
            )
        if "tint" in drawn:
            tints = (self.draw(drawn["tint"], f"materials.{place}.tint.{channel}") for channel in "rgb")
            fields["albedo"] = tuple(min(1.0, tint * value) for tint, value in zip(tints, own.albedo))
        for name in ("specular", "exponent"):
            if name in drawn:
                fields[name] = self.draw(drawn[name], f"materials.{place}.{name}")
        return own.replace(**fields)


def _light(given: Mapping[str, Any]) -> Light:
    if "towards" in given:
        return Light.directional(given["towards"], given.get("radius", 0.0), given["intensity"])
    if given.get("radius"):
        return Light.sphere(given["position"], given["radius"], given["intensity"])
    return Light.point(given["position"], given["intensity"])


def _turned(vector: Any, axis: Any, angle: float) -> Any:
    """Rotates a vector about an axis of unit length, by an angle in radians (Rodrigues' formula)."""
    cos, sin = math.cos(angle), math.sin(angle)
    return vector * cos + np.cross(axis, vector) * sin + axis * np.dot(axis, vector) * (1 - cos)


def _rounded(point: Any) -> list[float]:
    """Rounds to f32's digits, since the last bits of sine and cosine differ between machines."""
    return [float(f"{value:.7g}") for value in point]
