"""The film for Blender and browsers, read by the book, shows the places of the file."""

import json
import struct

import h5py
import numpy as np
import pytest
import synthetic_result
from exported import HALF, RUN

from lumpedcable.export import export_result


class Glb:
    """A binary glTF, read by the book."""

    def __init__(self, path):
        data = path.read_bytes()
        magic, version, size = struct.unpack_from("<4sII", data)
        assert (magic, version, size) == (b"glTF", 2, len(data))
        length, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON"
        self.head = json.loads(data[20 : 20 + length], parse_constant=self.refuse)
        size, kind = struct.unpack_from("<I4s", data, 20 + length)
        assert (kind, size) == (b"BIN\0", self.head["buffers"][0]["byteLength"])
        self.blob = data[28 + length :]

    @staticmethod
    def refuse(text):
        raise AssertionError(f"{text} is not JSON")

    def array(self, index):
        accessor = self.head["accessors"][index]
        view = self.head["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        count = accessor["count"] * width
        values = np.frombuffer(self.blob, "<f4", count, view["byteOffset"])
        return values.reshape(accessor["count"], width).astype(float)

    def tracks(self, name):
        """Times, translations, rotations and scales of a node by its name."""
        (node,) = [k for k, n in enumerate(self.head["nodes"]) if n.get("name") == name]
        (film,) = self.head["animations"]
        found = {}
        for channel in film["channels"]:
            if channel["target"]["node"] == node:
                sampler = film["samplers"][channel["sampler"]]
                found["time"] = self.array(sampler["input"])[:, 0]
                found[channel["target"]["path"]] = self.array(sampler["output"])
        return found


def test_gltf_moves_every_segment_between_its_nodes(file, fields, tmp_path):
    (made,) = export_result(file, "gltf", tmp_path / "r.glb", RUN)
    glb = Glb(made)
    position = fields[0]
    # 200 ms are stretched to 4 s
    assert glb.head["animations"][0]["extras"]["seconds_per_second"] == pytest.approx(20)
    for j in (0, 7):
        track = glb.tracks(f"rope segment {j + 1}")
        assert track["time"] == pytest.approx(20 * synthetic_result.TIMES, rel=1e-6)
        turn, reach = track["rotation"], track["scale"][:, 1:2]
        assert np.linalg.norm(turn, axis=1) == pytest.approx(np.ones(201), rel=1e-6)
        # the mesh reaches from y = -1/2 to 1/2; y turned by q = (u, w) is y + 2 u x (u x y + w y)
        u, w, y = turn[:, :3], turn[:, 3:], np.array([0.0, 1.0, 0.0])
        half = 0.5 * reach * (y + 2.0 * np.cross(u, np.cross(u, y) + w * y))
        for sign, node in ((-1, j), (1, j + 1)):
            end = track["translation"] + sign * half
            x, z, minus_y = end.T  # y is up there
            assert np.allclose(np.stack([x, -minus_y, z], axis=1), position[:, node], atol=1e-4)
    assert glb.tracks("rope node 4")["translation"][:, 0] == pytest.approx(position[:, 4, 0])


def test_gltf_ends_where_a_run_went_wrong(blown, fields, tmp_path):
    (made,) = export_result(blown, "gltf", tmp_path / "r.glb", RUN)
    track = Glb(made).tracks("rope node 8")
    # 99 ms, the last time before half-way, stretched to 4 s
    assert track["time"] == pytest.approx(4.0 / 0.099 * synthetic_result.TIMES[:HALF], rel=1e-6)
    assert track["translation"][:, 0] == pytest.approx(fields[0][:HALF, 8, 0], rel=1e-6)


def test_gltf_of_a_run_that_went_wrong_has_its_keys_before(blown, fields, tmp_path, monkeypatch):
    monkeypatch.setattr("lumpedcable.export.gltf.MOST_KEYS", 10)
    (made,) = export_result(blown, "gltf", tmp_path / "r.glb", RUN)
    track = Glb(made).tracks("rope node 8")
    keys = np.linspace(0, HALF - 1, 10).round().astype(int)
    assert track["time"] == pytest.approx(4.0 / 0.099 * synthetic_result.TIMES[keys], rel=1e-6)
    assert track["translation"][:, 0] == pytest.approx(fields[0][keys, 8, 0], rel=1e-6)


def test_places_far_from_the_origin_keep_their_digits(file, fields, tmp_path):
    """A map's coordinates in m: single precision alone leaves a quarter of a metre."""
    path, shift = tmp_path / "far.h5", np.array([500_000.0, 4_000_000.25, -40.0])
    path.write_bytes(file.read_bytes())
    with h5py.File(path, "r+") as far:
        places = far["lines/rope/position"][()].astype(float) + shift
        del far["lines/rope/position"]
        far["lines/rope/position"] = places
    position = fields[0] + shift
    (made,) = export_result(path, "vtkhdf", tmp_path / "r.vtkhdf", RUN)
    with h5py.File(made) as grid:
        points = grid["VTKHDF/Points"][()].reshape(position.shape)
    np.testing.assert_array_equal(points, position)
    (made,) = export_result(path, "gltf", tmp_path / "r.glb", RUN)
    glb = Glb(made)
    (root,) = [node for node in glb.head["nodes"] if node.get("name") == "rope"]
    x, z, minus_y = (glb.tracks("rope node 4")["translation"] + root["translation"]).T
    np.testing.assert_allclose(
        np.stack([x, -minus_y, z], axis=1), position[:, 4], atol=1e-5, rtol=0
    )
