"""What all tests share."""

import nephrite  # noqa: F401 (before Mitsuba, which else takes the system's LLVM)
