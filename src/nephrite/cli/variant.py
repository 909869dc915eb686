"""Which of Mitsuba's variants a command runs in: CUDA where a device really works, else LLVM."""

from __future__ import annotations

from nephrite.errors import MissingDependencyError, unknown_name

BACKENDS = ("cuda", "llvm")
LLVM_REMEDY = (
    "Install LLVM with `pip install karellen-llvm-core` (Linux), `brew install llvm` (macOS), or point "
    "DRJIT_LIBLLVM_PATH at a libLLVM of version 16 or later; `nephrite doctor` shows what there is."
)


def choose(wanted: str | None = None) -> str:
    """Set Mitsuba's variant and return its name.

    `wanted` is a variant (`llvm_ad_rgb`), or None for the fastest that works here. Raises ParameterError for
    an unknown one and MissingDependencyError where nothing, or not the one wanted, can run.
    """
    import mitsuba as mi

    known = [name for name in mi.variants() if name.startswith(BACKENDS) and "polarized" not in name]
    if wanted is not None:
        if wanted not in known:
            raise unknown_name("variant", wanted, known)
        problem = trouble(wanted)
        if problem is not None:
            raise MissingDependencyError(f"the variant {wanted} does not run on this machine: {problem}")
        return wanted
    problems = []
    for backend in BACKENDS:
        name = f"{backend}_ad_rgb"
        if name in known:
            problem = trouble(name)
            if problem is None:
                return name
            problems.append(problem)
    raise MissingDependencyError(f"nothing here can run Mitsuba: {'; '.join(problems)}")


def trouble(variant: str) -> str | None:
    """Set `variant` and trace one ray in it; return what went wrong, or None if it works."""
    import drjit as dr
    import mitsuba as mi

    on_cuda = variant.startswith("cuda")
    if not dr.has_backend(dr.JitBackend.CUDA if on_cuda else dr.JitBackend.LLVM):
        return "there is no usable NVIDIA driver" if on_cuda else f"Dr.Jit finds no LLVM. {LLVM_REMEDY}"
    try:
        mi.set_variant(variant)
        scene = mi.load_dict({"type": "scene", "shape": {"type": "sphere"}})
        assert isinstance(scene, mi.Scene)
        ray = mi.Ray3f(o=mi.Point3f(0, 0, -4), d=mi.Vector3f(0, 0, 1))
        distance = scene.ray_intersect(ray).t.numpy()
    except (RuntimeError, ImportError) as error:
        return str(error).strip().splitlines()[0]
    return None if abs(float(distance[0]) - 3) < 1e-3 else "a ray through a sphere misses it"
