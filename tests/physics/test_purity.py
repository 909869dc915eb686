import subprocess
import sys


def test_physics_and_materials_import_neither_mitsuba_nor_drjit():
    code = (
        "import sys, nephrite.physics, nephrite.materials as m; m.find('jade').medium.diffuse_reflectance; "
        "loaded = {'mitsuba', 'drjit', 'scipy', 'trimesh'} & set(sys.modules); assert not loaded, loaded"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
