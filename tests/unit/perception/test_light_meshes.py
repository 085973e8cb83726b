"""Meshes with fewer triangles: the largest lose them first, colours stay apart."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from skiros_py.open3d import pybind as o3d
from skiros_py.perception.light_meshes import MeshLightener, MeshPiece


def sphere(path: Path, resolution: int) -> Path:
    o3d.io.write_triangle_mesh(str(path), o3d.geometry.TriangleMesh.create_sphere(0.1, resolution))
    return path


@pytest.fixture
def out(tmp_path: Path) -> Path:
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


def triangles(piece: MeshPiece, folder: Path) -> int:
    (count,) = struct.unpack("<I", (folder / piece.file).read_bytes()[80:84])
    assert count == piece.triangles
    return int(count)


def test_large_meshes_are_simplified_and_small_ones_are_unchanged(tmp_path: Path, out: Path) -> None:
    large, small = sphere(tmp_path / "large.obj", 60), sphere(tmp_path / "small.obj", 5)

    made = MeshLightener().light([large, small, small], out, 1000)

    assert triangles(made[small][0], out) == 80
    assert 0.9 * 840 <= triangles(made[large][0], out) <= 840
    assert {path.name for path in out.iterdir()} == {made[large][0].file, made[small][0].file}


def test_a_simplified_mesh_keeps_its_size(tmp_path: Path, out: Path) -> None:
    source = sphere(tmp_path / "ball.obj", 60)

    (piece,) = MeshLightener().light([source], out, 500)[source]

    box = o3d.io.read_triangle_mesh(str(out / piece.file)).get_axis_aligned_bounding_box()
    assert np.allclose(box.get_extent(), 0.2, atol=0.004)


def test_meshes_with_few_triangles_are_unchanged(tmp_path: Path, out: Path) -> None:
    source = sphere(tmp_path / "ball.obj", 10)

    (piece,) = MeshLightener().light([source], out, 10_000)[source]

    assert triangles(piece, out) == 360


def test_a_mesh_has_one_piece_per_colour(tmp_path: Path, out: Path) -> None:
    (tmp_path / "two.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl grey\nKd 0.5 0.5 0.5\n")
    source = tmp_path / "two.obj"
    corners = "".join(f"v {x} {y} {z}\n" for x, y, z in [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    source.write_text(f"mtllib two.mtl\n{corners}usemtl red\nf 1 2 3\nusemtl grey\nf 1 2 4\nf 2 3 4\n")

    pieces = MeshLightener().light([source], out, 100)[source]

    assert {piece.colour[:3]: piece.triangles for piece in pieces} == {(1.0, 0.0, 0.0): 1, (0.5, 0.5, 0.5): 2}


def test_a_file_that_is_not_a_mesh_has_no_pieces(tmp_path: Path, out: Path) -> None:
    source = tmp_path / "none.obj"
    source.write_text("nothing\n")

    assert MeshLightener().light([source, tmp_path / "gone.obj"], out, 100) == {source: (), tmp_path / "gone.obj": ()}
