"""glTF 2.0 (binary, .glb): the moving lines for Blender, browsers and slides.

Every segment is a cylinder that is moved, turned and stretched from key to key; a ball covers each
node, so that bends show no gap. Core glTF cannot change a colour in time, so lines have one colour each.
glTF is y up: the scene's (x, y, z) stands as (x, z, -y). Source: Khronos, glTF 2.0 specification,
sections 3.5 (coordinates), 3.6 (buffers), 3.11 (animations).
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumpedcable.export.parts import lines_of, replacing
from lumpedcable.results import ResultFile
from lumpedcable.results.spread import even

__all__ = ["write_gltf"]

Array = NDArray[Any]

MOST_KEYS = 300  # of the saved times
SIDES = 10
SLOWEST, FASTEST = 4.0, 20.0  # s that a film may last; else time is stretched or pressed to fit
FAR = 1e4  # m from the origin, where single precision leaves millimetres; the roots of lines stand there
COLOURS = ((0.0, 0.168, 0.445), (0.665, 0.112, 0.0), (0.0, 0.342, 0.174), (0.604, 0.191, 0.386))


def write_gltf(result: ResultFile, target: Path, run: int | None) -> list[Path]:
    """Write one run with at most `MOST_KEYS` of its times as keys.

    Lines are at least 1/400 of the scene's extent thick. A run of less than 4 s or more than 20 s is
    played slower or faster; `extras` of the animation holds the factor.
    """
    lines = lines_of(result, run or 0)
    time = result.field_time
    good = np.all([np.isfinite(line.position).all(axis=(1, 2)) for line in lines], axis=0)
    good = np.flatnonzero(good)  # a run that failed ends there
    keys = good[even(good.size, MOST_KEYS)]
    places = [_y_up(line.position[keys]) for line in lines]
    origin = np.zeros(3)
    if any(np.abs(place).max(initial=0.0) > FAR for place in places):
        origin = places[0][0, 0].round()
        places = [place - origin for place in places]
    time = time[keys] - (time[keys[0]] if len(keys) else 0.0)
    last = float(time[-1]) if len(time) else 0.0
    pace = min(max(last, SLOWEST), FASTEST) / last if last > 0.0 else 1.0
    extent = max((float(np.ptp(p, axis=(0, 1)).max()) for p in places if p.size), default=1.0)
    built = _Builder(time * pace, extent / 800.0, origin)
    for number, (line, place) in enumerate(zip(lines, places, strict=True)):
        built.line(line.name, place, number)
    extras = {"seconds_per_second": pace, "source": result.path.name}
    with replacing(target, "glTF") as partial:
        partial.write_bytes(built.glb(str(result.attributes.get("title", "")), extras))
    return [target]


def _y_up(position: Array) -> Array:
    return np.stack([position[..., 0], position[..., 2], -position[..., 1]], axis=-1)


class _Builder:
    """The JSON and the buffer of a file while they grow."""

    def __init__(self, time: Array, radius: float, origin: Array) -> None:
        self.blob = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.materials: list[dict[str, Any]] = []
        self.nodes: list[dict[str, Any]] = []
        self.roots: list[int] = []
        self.samplers: list[dict[str, Any]] = []
        self.channels: list[dict[str, Any]] = []
        self.radius = radius
        self.origin = {"translation": origin.tolist()} if origin.any() else {}
        self.time = self.array(time, "SCALAR", bounds=True)
        self.tube = [self._shape(*_cylinder(), self.array), self._shape(*_ball(), self.array)]

    def array(self, values: Array, kind: str, *, index: bool = False, bounds: bool = False) -> int:
        """Put an array into the buffer; its accessor."""
        data = np.ascontiguousarray(values, "<u2" if index else "<f4")
        self.views.append({"buffer": 0, "byteOffset": len(self.blob), "byteLength": data.nbytes})
        self.blob += data.tobytes() + bytes(-data.nbytes % 4)
        count = data.shape[0]
        found = {"bufferView": len(self.views) - 1, "componentType": 5123 if index else 5126,
                 "count": count, "type": kind}  # fmt: skip
        if bounds:
            table = data.reshape(count, -1).astype(float)
            found |= {"min": table.min(axis=0).tolist(), "max": table.max(axis=0).tolist()}
        self.accessors.append(found)
        return len(self.accessors) - 1

    def _shape(self, points: Array, normals: Array, triangles: Array, put: Any) -> dict[str, Any]:
        return {
            "attributes": {
                "POSITION": put(points, "VEC3", bounds=True),
                "NORMAL": put(normals, "VEC3"),
            },
            "indices": put(triangles.ravel(), "SCALAR", index=True),
        }

    def line(self, name: str, place: Array, number: int) -> None:
        """A line whose nodes move along `place`, (key, node, 3)."""
        if not place.size:
            return
        colour = [*COLOURS[number % len(COLOURS)], 1.0]
        self.materials.append(
            {"name": name, "pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0.0,
                                                    "roughnessFactor": 0.6}}
        )  # fmt: skip
        first = len(self.meshes)
        for part, shape in zip(("segment", "node"), self.tube, strict=True):
            primitive = {**shape, "material": len(self.materials) - 1}
            self.meshes.append({"name": f"{name} {part}", "primitives": [primitive]})
        step = np.diff(place, axis=1)
        length = np.linalg.norm(step, axis=-1)
        children = []
        for j in range(step.shape[1]):
            scale = np.column_stack([np.full(len(length), self.radius)] * 3)
            scale[:, 1] = length[:, j]
            children.append(self._moved(f"{name} segment {j + 1}", first, {
                "translation": 0.5 * (place[:, j] + place[:, j + 1]),
                "rotation": _turned(step[:, j]), "scale": scale}))  # fmt: skip
        for i in range(place.shape[1]):
            node = self._moved(f"{name} node {i}", first + 1, {"translation": place[:, i]})
            self.nodes[node]["scale"] = [self.radius] * 3
            children.append(node)
        self.nodes.append({"name": name, **self.origin, "children": children})
        self.roots.append(len(self.nodes) - 1)

    def _moved(self, name: str, mesh: int, paths: dict[str, Array]) -> int:
        """A node that follows keys of translation, rotation, scale."""
        node: dict[str, Any] = {"name": name, "mesh": mesh}
        self.nodes.append(node)
        for path, values in paths.items():
            node[path] = np.asarray(values[0], "f4").astype(float).tolist()
            kind = "VEC4" if path == "rotation" else "VEC3"
            sampler = {"input": self.time, "output": self.array(values, kind)}
            self.samplers.append({**sampler, "interpolation": "LINEAR"})
            target = {"node": len(self.nodes) - 1, "path": path}
            self.channels.append({"sampler": len(self.samplers) - 1, "target": target})
        return len(self.nodes) - 1

    def glb(self, title: str, extras: dict[str, Any]) -> bytes:
        """The whole file."""
        head: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "lumpedcable"},
            "scene": 0,
            "scenes": [{"name": title or "scene", "nodes": self.roots}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": self.materials,
            "buffers": [{"byteLength": len(self.blob)}],
            "bufferViews": self.views,
            "accessors": self.accessors,
        }
        if self.channels:
            head["animations"] = [{"name": "run", "samplers": self.samplers,
                                   "channels": self.channels, "extras": extras}]  # fmt: skip
        text = json.dumps(head, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + 8 + len(self.blob)
        parts = [struct.pack("<4sII", b"glTF", 2, size), struct.pack("<I4s", len(text), b"JSON"), text,
                 struct.pack("<I4s", len(self.blob), b"BIN\0"), bytes(self.blob)]  # fmt: skip
        return b"".join(parts)


def _turned(step: Array) -> Array:
    """Unit quaternions x, y, z, w that turn +y into each step (key, 3), nearest sign to sign."""
    length = np.linalg.norm(step, axis=-1, keepdims=True)
    t = np.divide(step, length, out=np.tile([0.0, 1.0, 0.0], (len(step), 1)), where=length > 0.0)
    # halfway between y and t: q = (y x t, 1 + y.t), and any half turn where t points down
    q = np.column_stack([t[:, 2], np.zeros(len(t)), -t[:, 0], 1.0 + t[:, 1]])
    down = q[:, 3] < 1e-9
    q[down] = [1.0, 0.0, 0.0, 0.0]
    q /= np.linalg.norm(q, axis=-1, keepdims=True)
    signs = np.where(np.sum(q[1:] * q[:-1], axis=-1) < 0.0, -1.0, 1.0)
    q[1:] *= np.cumprod(signs)[:, None]
    return q


def _cylinder() -> tuple[Array, Array, Array]:
    """An open cylinder of radius 1 from y = -1/2 to 1/2: points, normals, triangles."""
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    ring = np.column_stack([np.cos(angle), np.zeros(SIDES), np.sin(angle)])
    half = np.array([0.0, 0.5, 0.0])
    points = np.concatenate([ring - half, ring + half])
    a = np.arange(SIDES)
    b = (a + 1) % SIDES
    triangles = np.concatenate([np.column_stack([a, a + SIDES, b]),
                                np.column_stack([b, a + SIDES, b + SIDES])])  # fmt: skip
    return points, np.concatenate([ring, ring]), triangles


def _ball() -> tuple[Array, Array, Array]:
    """A ball of radius 1."""
    rows = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 6)
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    points = np.array([[np.cos(r) * np.cos(a), np.sin(r), np.cos(r) * np.sin(a)]
                       for r in rows for a in angle])  # fmt: skip
    triangles = []
    for k in range(len(rows) - 1):
        for j in range(SIDES):
            a, b = k * SIDES + j, k * SIDES + (j + 1) % SIDES
            triangles += [[a, a + SIDES, b], [b, a + SIDES, b + SIDES]]
    return points, points, np.array(triangles)
