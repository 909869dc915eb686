"""Blender's Cycles through the `bpy` wheel: subsurface scattering of its Principled BSDF.

Cycles takes a colour and a radius. The colour is the scene's surface colour. The radius becomes a mean free path only
after a division by 4 pi (`bssrdf_setup_radius` in Cycles' `kernel/closure/bssrdf.h`), which is undone here.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from benchmarks.peers import measure, sky

_SKY = (1024, 512)


def prepare(scene: dict[str, Any], method: dict[str, Any]) -> measure.Renderer:
    """Build the scene; `method` has `subsurface`, Blender's name of a method, and `radius_scale`."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    blender = bpy.context.scene
    _settings(blender, scene["resolution"])
    _object(scene, method)
    if scene["floor"] is not None:
        _floor(scene["floor"], scene["floor_half_side"])
    for light in scene["lights"]:
        _light(blender, light)
    _world(blender, scene["sky"])
    _camera(blender, scene)
    file = Path(tempfile.mkdtemp()) / "picture.exr"

    def call(spp: int, seed: int) -> Any:
        blender.cycles.samples, blender.cycles.seed = spp, seed
        blender.render.filepath = str(file)
        bpy.ops.render.render(write_still=True)
        return _read(file)

    return measure.Renderer(call, f"Blender {bpy.app.version_string}", startup=True)


def _settings(blender: Any, resolution: list[int]) -> None:
    """Choose an unclamped, undenoised path tracer with a box filter and a linear picture."""
    blender.render.engine = "CYCLES"
    cycles = blender.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces, cycles.diffuse_bounces = 16, 8
    cycles.glossy_bounces = cycles.transmission_bounces = 8
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    render = blender.render
    render.resolution_x, render.resolution_y = resolution
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", measure.cores()
    render.use_persistent_data = True
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    blender.view_settings.view_transform = "Standard"


def _read(file: Path) -> Any:
    image = bpy.data.images.load(str(file))
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[::-1, :, :3]


def _object(scene: dict[str, Any], method: dict[str, Any]) -> None:
    # the mesh's own axes: y stays up
    bpy.ops.wm.ply_import(filepath=scene["mesh"], forward_axis="Y", up_axis="Z")
    data = bpy.context.object.data
    data.polygons.foreach_set("use_smooth", np.ones(len(data.polygons), bool))
    material = bpy.data.materials.new("medium")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.subsurface_method = method["subsurface"]
    values = {
        "Base Color": (*scene["color"], 1.0),
        "Subsurface Weight": 1.0,
        "Subsurface Radius": [method["radius_scale"] * radius for radius in scene["radius"]],
        "Subsurface Scale": 1.0,
        "IOR": scene["eta"],
        "Roughness": 0.0,
    }
    for name, value in values.items():
        shader.inputs[name].default_value = value
    if method["subsurface"] != "BURLEY":
        shader.inputs["Subsurface Anisotropy"].default_value = scene["g"]
    data.materials.clear()
    data.materials.append(material)


def _floor(grey: float, half_side: float) -> None:
    material = bpy.data.materials.new("floor")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (grey, grey, grey, 1.0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    bpy.ops.mesh.primitive_plane_add(size=2.0 * half_side, rotation=(-math.pi / 2, 0.0, 0.0))
    bpy.context.object.data.materials.append(material)


def _light(blender: Any, given: dict[str, Any]) -> None:
    """Add an area light, which shines from one side, and which Cycles samples better than a mesh."""
    data = bpy.data.lights.new("light", "AREA")
    side = 2.0 * given["half_side"]
    data.shape, data.size = "SQUARE", side
    data.energy = math.pi * side**2 * given["radiance"]
    light = bpy.data.objects.new("light", data)
    blender.collection.objects.link(light)
    position = Vector(given["position"])
    turn = (Vector(given["target"]) - position).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    light.matrix_world = Matrix.Translation(position) @ turn


def _world(blender: Any, given: dict[str, Any]) -> None:
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    blender.world = world
    tree = world.node_tree
    background = tree.nodes.get("Background") or tree.nodes.new("ShaderNodeBackground")
    output = tree.nodes.get("World Output") or tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    if not given["lobes"]:
        background.inputs["Color"].default_value = (*given["ambient"], 1.0)
        return
    width, height = _SKY
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    turn, up = -2 * np.pi * (u - 0.5), np.pi * (v - 0.5)  # rows from below; the picture's pole is z
    directions = np.stack([np.cos(turn) * np.cos(up), np.sin(turn) * np.cos(up), np.sin(up)], axis=-1)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = sky.radiance(given, directions)
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    node.interpolation = "Closest"  # others mix the picture's two poles, and one of them is in view
    tree.links.new(node.outputs["Color"], background.inputs["Color"])


def _camera(blender: Any, scene: dict[str, Any]) -> None:
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "HORIZONTAL", math.radians(scene["field_of_view"])
    data.clip_start, data.clip_end = 0.1, 1e5
    camera = bpy.data.objects.new("camera", data)
    blender.collection.objects.link(camera)
    blender.camera = camera
    eye, target = Vector(scene["eye"]), Vector(scene["target"])
    back = (eye - target).normalized()
    right = Vector((0.0, 1.0, 0.0)).cross(back).normalized()
    axes = Matrix((right, back.cross(right), back)).transposed().to_4x4()
    camera.matrix_world = Matrix.Translation(eye) @ axes


if __name__ == "__main__":
    measure.main(prepare)
