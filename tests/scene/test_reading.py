"""Mesh files in: every format, and everything that can be wrong with a file."""

import gzip
import json
import time

import numpy as np
import pytest
import trimesh

from nephrite.errors import MeshError
from nephrite.scene import meshes

BALL = trimesh.creation.icosphere(subdivisions=2, radius=2.0)


def exported(folder, suffix, **options):
    path = folder / f"ball{suffix}"
    BALL.export(path, **options)
    return path


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".stl", ".off", ".glb"])
def test_every_format_gives_the_same_closed_ball(tmp_path, suffix):
    mesh = meshes.load(exported(tmp_path, suffix))
    assert mesh.closed
    assert mesh.report.parts == 1
    assert not mesh.report.findings
    assert len(mesh.faces) == len(BALL.faces)
    assert mesh.volume == pytest.approx(BALL.volume, rel=1e-5)
    assert mesh.name == f"ball{suffix}"


@pytest.mark.parametrize("suffix", [".ply", ".stl", ".obj"])
def test_gzipped_and_upper_case(tmp_path, suffix):
    path = tmp_path / f"BALL{suffix.upper()}.GZ"
    path.write_bytes(gzip.compress(exported(tmp_path, suffix).read_bytes()))
    assert meshes.load(path).closed


def test_ascii_ply(tmp_path):
    assert meshes.load(exported(tmp_path, ".ply", encoding="ascii")).closed


def test_ascii_stl(tmp_path):
    assert meshes.load(exported(tmp_path, ".stl", file_type="stl_ascii")).closed


def test_polygons_become_triangles(tmp_path):
    corners = "\n".join(f"v {x} {y} {z}" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    quads = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
    (tmp_path / "cube.obj").write_text(f"{corners}\n{quads}")
    mesh = meshes.load(tmp_path / "cube.obj")
    assert mesh.closed
    assert mesh.volume == pytest.approx(1)
    assert len(mesh.faces) == 12


def test_glb_scene_of_several_moved_meshes_becomes_one(tmp_path):
    scene = trimesh.Scene()
    scene.add_geometry(BALL)
    scene.add_geometry(BALL, transform=trimesh.transformations.translation_matrix([10, 0, 0]))
    scene.add_geometry(
        trimesh.creation.box(), transform=trimesh.transformations.translation_matrix([0, 9, 0])
    )
    scene.export(tmp_path / "three.glb")
    mesh = meshes.load(tmp_path / "three.glb")
    assert mesh.closed
    assert mesh.report.parts == 3
    assert mesh.volume == pytest.approx(2 * BALL.volume + 1, rel=1e-5)
    assert mesh.extents == pytest.approx([14, 11.5, 4], rel=1e-5)


def test_missing_file_is_named(tmp_path):
    with pytest.raises(MeshError, match=r"there is no mesh .*ghost\.ply"):
        meshes.load(tmp_path / "ghost.ply")


def test_folder(tmp_path):
    (tmp_path / "x.ply").mkdir()
    with pytest.raises(MeshError, match="not a file"):
        meshes.load(tmp_path / "x.ply")


@pytest.mark.parametrize("name", ["mesh.fbx", "mesh", "mesh.ply.zip"])
def test_unknown_format_lists_the_known(tmp_path, name):
    (tmp_path / name).write_bytes(b"data")
    with pytest.raises(MeshError, match=r"unknown mesh format.*\.ply, \.obj"):
        meshes.load(tmp_path / name)


@pytest.mark.parametrize("suffix", [*meshes.FORMATS, ".ply.gz"])
@pytest.mark.parametrize("content", [b"", b"\n \n"])
def test_empty(tmp_path, suffix, content):
    path = tmp_path / f"nothing{suffix}"
    path.write_bytes(gzip.compress(content) if suffix.endswith("gz") else content)
    with pytest.raises(MeshError, match=r"nothing.* is empty"):
        meshes.load(path)


@pytest.mark.parametrize("share", [0.01, 0.3, 0.7, 0.99])
@pytest.mark.parametrize("kind", [".ply", ".stl", ".off", ".glb", ".ply ascii", ".stl ascii", ".ply.gz"])
def test_truncated(tmp_path, kind, share):
    suffix = kind.split()[0]
    options = {}
    if kind == ".ply ascii":
        options = {"encoding": "ascii"}
    elif kind == ".stl ascii":
        options = {"file_type": "stl_ascii"}
    whole = exported(tmp_path, suffix.removesuffix(".gz"), **options).read_bytes()
    data = gzip.compress(whole) if suffix.endswith(".gz") else whole
    path = tmp_path / f"cut{suffix}"
    path.write_bytes(data[: int(len(data) * share)])
    with pytest.raises(MeshError, match=r"cut\."):
        meshes.load(path)


def test_truncated_obj_is_no_closed_ball_in_silence(tmp_path):
    lines = exported(tmp_path, ".obj").read_text().splitlines()
    (tmp_path / "cut.obj").write_text("\n".join(lines[:-9]))
    mesh = meshes.load(tmp_path / "cut.obj")
    assert "open" in mesh.report


@pytest.mark.parametrize("suffix", meshes.FORMATS)
def test_garbage(tmp_path, suffix):
    path = tmp_path / f"noise{suffix}"
    path.write_bytes(np.random.default_rng(1).bytes(5000))
    with pytest.raises(MeshError, match="noise"):
        meshes.load(path)


def test_header_that_promises_more_than_there_is(tmp_path):
    path = tmp_path / "bomb.ply"
    path.write_bytes(
        b"ply\nformat binary_little_endian 1.0\nelement vertex 900000000000\nproperty float x\n"
        b"property float y\nproperty float z\nelement face 900000000000\n"
        b"property list uchar int vertex_indices\nend_header\n" + bytes(100)
    )
    start = time.perf_counter()
    with pytest.raises(MeshError, match="bomb"):
        meshes.load(path)
    assert time.perf_counter() - start < 10


def test_points_without_faces(tmp_path):
    trimesh.PointCloud(BALL.vertices).export(tmp_path / "scan.ply")
    with pytest.raises(MeshError, match="no faces"):
        meshes.load(tmp_path / "scan.ply")


def test_faces_that_name_vertices_that_are_not_there(tmp_path):
    (tmp_path / "bad.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n")
    with pytest.raises(MeshError, match=r"bad\.off"):
        meshes.load(tmp_path / "bad.off")


def test_gltf_whose_data_is_missing(tmp_path):
    document = {"asset": {"version": "2.0"}, "buffers": [{"uri": "gone.bin", "byteLength": 9}]}
    (tmp_path / "part.gltf").write_text(json.dumps(document))
    with pytest.raises(MeshError, match=r"part\.gltf"):
        meshes.load(tmp_path / "part.gltf")


def test_coordinates_too_large_for_double_precision(tmp_path):
    (tmp_path / "far.obj").write_text("v 0 0 0\nv 1e200 0 0\nv 0 1e200 0\nf 1 2 3\n")
    with pytest.raises(MeshError, match="Scale it down"):
        meshes.load(tmp_path / "far.obj")
