"""Nephrite's command line in a process that tells how long it took, and how much memory.

    python -m benchmarks.growth.command JOB.json

JOB.json holds `arguments`, those of `nephrite`, and `folder`, where `told.json` is written.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from benchmarks.peers.measure import peak_memory
from nephrite import cli


def main() -> None:
    """Do the job that the command line names; exits as the command does where that fails."""
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    sys.argv = ["nephrite", *job["arguments"]]
    start = time.perf_counter()
    try:
        cli.main()
    except SystemExit as ended:
        if ended.code:
            raise
    told = {"seconds": time.perf_counter() - start, "peak": peak_memory()}
    (Path(job["folder"]) / "told.json").write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    main()
