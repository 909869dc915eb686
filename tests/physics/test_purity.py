"""What importing the package loads is Mitsuba alone; that physics knows nothing of it, `test_package.py` reads."""

import subprocess
import sys


def test_physics_and_materials_load_nothing_slow():
    code = (
        "import sys, nephrite.physics, nephrite.materials as m; m.find('jade').medium.diffuse_reflectance; "
        "loaded = {'scipy', 'trimesh'} & set(sys.modules); assert not loaded, loaded"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
