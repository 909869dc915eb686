"""The command line: `nephrite render | compare | materials | profile | atlas | doctor`."""

from __future__ import annotations


def main() -> None:
    """Run the command line; the entry point of the `nephrite` script."""
    from nephrite.cli.app import app

    app(prog_name="nephrite")
