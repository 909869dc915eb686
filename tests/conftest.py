"""What all tests share: Mitsuba loaded after nephrite, one variant for the whole session, `tests/support`."""

import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import nephrite  # noqa: F401 (before Mitsuba, which else takes the system's LLVM)

sys.path.insert(0, str(Path(__file__).parent))

VARIANT = "llvm_ad_rgb"

# a shell starts its background jobs with Ctrl-C ignored: the tests of Ctrl-C need Python's own handler
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def _one_variant() -> None:
    """Set the variant that the tests run in, whatever order they run in."""
    import mitsuba as mi

    if mi.variant() != VARIANT:
        mi.set_variant(VARIANT)


@pytest.fixture
def switching() -> Iterator[None]:
    """For tests that switch variants: set the session's again afterwards."""
    import mitsuba as mi

    yield
    mi.set_variant(VARIANT)


@pytest.fixture(autouse=True)
def shipped_materials():
    """Forget the materials that a test has registered, as `--material-file` does."""
    from nephrite import materials

    shipped = set(materials.names())
    yield
    for name in set(materials.names()) - shipped:
        materials.unregister(name)
