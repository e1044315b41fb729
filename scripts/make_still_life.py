#!/usr/bin/env python3
"""Writes scenes/still_life.obj and scenes/still_life.mtl: a table with a vase, a bowl of fruit and a few solids.

Plain Python 3, no packages, the same bytes each time. Units are decimetres, y is up.
Run it from anywhere: python3 scripts/make_still_life.py
"""

import math
from pathlib import Path

SCENES = Path(__file__).resolve().parent.parent / "scenes"
MATERIALS = {
    "wood": (0.36, 0.20, 0.10),
    "cloth": (0.70, 0.66, 0.58),
    "glaze": (0.07, 0.22, 0.40),
    "glaze_band": (0.78, 0.72, 0.55),
    "clay": (0.58, 0.27, 0.15),
    "apple": (0.62, 0.07, 0.05),
    "lemon": (0.86, 0.66, 0.10),
    "plum": (0.22, 0.06, 0.20),
    "plaster": (0.76, 0.73, 0.68),
    "brass": (0.66, 0.46, 0.14),
    "book": (0.10, 0.30, 0.22),
    "pages": (0.82, 0.77, 0.64),
}


class Obj:
    """An OBJ file that grows. Equal positions and normals of one object share a line."""

    def __init__(self):
        self.lines = ["# Made by scripts/make_still_life.py", "mtllib still_life.mtl"]
        self.counts = {"v": 0, "vn": 0}
        self.triangles = 0
        self.seen = {}

    def begin(self, name):
        self.lines.append(f"o {name}")
        self.seen = {}
        self.material = None

    def index(self, kind, vector):
        line = f"{kind} " + " ".join(f"{value + 0.0:.4f}".replace("-0.0000", "0.0000") for value in vector)
        if line not in self.seen:
            self.counts[kind] += 1
            self.seen[line] = self.counts[kind]
            self.lines.append(line)
        return self.seen[line]

    def polygon(self, corners, material, normals=None):
        points = [self.index("v", corner) for corner in corners]
        refs = [str(point) for point in points]
        if normals:
            refs = [f"{point}//{self.index('vn', normal)}" for point, normal in zip(points, normals)]
        # A quad with an edge of no length, at a pole, is a triangle.
        kept = [k for k in range(len(points)) if points[k] != points[k - 1]]
        if material != self.material:
            self.lines.append(f"usemtl {material}")
            self.material = material
        self.lines.append("f " + " ".join(refs[k] for k in kept))
        self.triangles += len(kept) - 2

    def box(self, low, high, material, turn=0.0):
        """A box along the axes, turned about its own vertical axis by `turn` degrees."""
        middle = [(a + b) / 2 for a, b in zip(low, high)]
        sin, cos = math.sin(math.radians(turn)), math.cos(math.radians(turn))

        def corner(bits):
            x, y, z = (high[k] if bits >> k & 1 else low[k] for k in range(3))
            x, z = x - middle[0], z - middle[2]
            return (middle[0] + cos * x + sin * z, y, middle[2] - sin * x + cos * z)

        for side in ((0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6), (0, 4, 6, 2), (1, 3, 7, 5)):
            self.polygon([corner(bits) for bits in side], material)

    def revolve(self, center, profile, around, material, smooth=True):
        """Turns `profile`, a list of (radius, height), about the vertical axis. A point given twice is a sharp edge;
        `material` is a name, or a function of the profile's segment."""
        slopes = []
        for (r0, h0), (r1, h1) in zip(profile, profile[1:]):
            length = math.hypot(r1 - r0, h1 - h0)
            slopes.append(((h1 - h0) / length, (r0 - r1) / length) if length > 0 else None)

        def normal(segment, neighbour):
            here, beside = slopes[segment], slopes[neighbour] if 0 <= neighbour < len(slopes) else None
            out, up = (here[0] + beside[0], here[1] + beside[1]) if beside else here
            if profile[segment + (neighbour > segment)][0] == 0:
                out, up = 0.0, math.copysign(1.0, up)
            length = math.hypot(out, up)
            return out / length, up / length

        def spin(radius, height, k):
            angle = math.tau * (k % around) / around
            return (radius * math.cos(angle), height, -radius * math.sin(angle))

        for segment, slope in enumerate(slopes):
            if slope is None:
                continue
            ends = (profile[segment], profile[segment + 1])
            tilts = (normal(segment, segment - 1), normal(segment, segment + 1))
            for k in range(around):
                turns = ((0, k), (0, k + 1), (1, k + 1), (1, k))
                corners = [tuple(a + b for a, b in zip(center, spin(*ends[end], turn))) for end, turn in turns]
                normals = [spin(*tilts[end], turn) for end, turn in turns] if smooth else None
                self.polygon(corners, material(segment) if callable(material) else material, normals)

    def ball(self, center, radius, squash, around, rows, material):
        profile = [
            (radius * math.sin(turn) if 0 < turn < math.pi else 0.0, -radius * squash * math.cos(turn))
            for turn in (math.pi * k / rows for k in range(rows + 1))
        ]
        self.revolve(center, profile, around, material)


def still_life():
    obj = Obj()
    obj.begin("table")
    obj.box((-4.9, -0.4, -3.1), (4.9, 0, 3.1), "wood")
    for x in (-4.7, 3.9):
        for z in (-2.9, 2.1):
            obj.box((x, -1.2, z), (x + 0.8, -0.35, z + 0.8), "wood")

    obj.begin("runner")
    obj.box((-1.7, -0.2, -3.16), (2.1, 0.04, 3.16), "cloth")
    obj.polygon([(-1.7, 0.03, 3.18), (-1.7, -1.0, 3.26), (2.1, -1.0, 3.26), (2.1, 0.03, 3.18)], "cloth")

    obj.begin("vase")
    outside = [
        (0.0, 0.06),
        (0.75, 0.06),
        (0.75, 0.06),
        (0.8, 0.2),
        (1.05, 0.6),
        (1.35, 1.1),
        (1.5, 1.65),
        (1.45, 2.2),
        (1.2, 2.75),
        (0.85, 3.2),
        (0.62, 3.6),
        (0.58, 3.95),
        (0.72, 4.3),
        (0.95, 4.5),
    ]
    inside = [(0.95, 4.5), (0.88, 4.5), (0.88, 4.5), (0.64, 4.25), (0.5, 3.9), (0.55, 3.5), (0.0, 2.9)]
    obj.revolve((-2.5, 0, -1.3), outside + inside, 18, lambda k: "glaze_band" if k in (5, 6, 11) else "glaze")

    obj.begin("bowl")
    bowl = [
        (0.0, 0.08),
        (0.8, 0.08),
        (0.8, 0.08),
        (0.8, 0.25),
        (1.4, 0.5),
        (1.9, 0.95),
        (2.15, 1.5),
        (2.15, 1.5),
        (2.05, 1.5),
        (2.05, 1.5),
        (1.78, 1.0),
        (1.3, 0.65),
        (0.0, 0.45),
    ]
    obj.revolve((0.2, 0, 0.7), bowl, 16, "clay")

    fruit = [
        ("apple_1", (-0.6, 1.35, 1.0), 0.68, 0.92, "apple"),
        ("apple_2", (0.75, 1.4, 1.25), 0.66, 0.92, "apple"),
        ("lemon_1", (0.25, 1.42, -0.15), 0.6, 1.2, "lemon"),
        ("apple_3", (0.1, 2.25, 0.75), 0.6, 0.92, "apple"),
        ("plum_1", (2.85, 0.48, 2.3), 0.45, 1.02, "plum"),
        ("plum_2", (2.6, 0.46, 1.35), 0.43, 1.02, "plum"),
        ("lemon_2", (-2.5, 0.63, 1.7), 0.52, 1.15, "lemon"),
    ]
    for name, center, radius, squash, material in fruit:
        obj.begin(name)
        obj.ball(center, radius, squash, 12, 7, material)

    obj.begin("book")
    obj.box((1.5, 0.06, -2.7), (4.5, 0.18, -0.7), "book", 14)
    obj.box((1.6, 0.16, -2.6), (4.4, 0.58, -0.8), "pages", 14)
    obj.box((1.5, 0.56, -2.7), (4.5, 0.7, -0.7), "book", 14)

    obj.begin("cube")
    obj.box((2.3, 0.72, -2.4), (3.7, 2.12, -1.0), "plaster", 38)

    obj.begin("cone")
    cone = [(0.0, 0.02), (0.95, 0.02), (0.95, 0.02), (0.0, 2.3)]
    obj.revolve((3.9, 0, 0.9), cone, 18, "plaster")

    obj.begin("octahedron")
    obj.revolve((-3.9, 0.02, 0.9), [(0.0, 0.0), (0.85, 0.85), (0.0, 1.7)], 4, "brass", smooth=False)

    return obj


def main():
    obj = still_life()
    mtl = ["# Made by scripts/make_still_life.py"]
    for name, color in MATERIALS.items():
        mtl += [f"newmtl {name}", "Kd " + " ".join(f"{channel:.2f}" for channel in color)]
    (SCENES / "still_life.obj").write_text("\n".join(obj.lines) + "\n", encoding="ascii", newline="\n")
    (SCENES / "still_life.mtl").write_text("\n".join(mtl) + "\n", encoding="ascii", newline="\n")
    print(f"{obj.triangles} triangles")


if __name__ == "__main__":
    main()
