"""`python -m benchmarks.growth`: see `run`."""

from benchmarks.growth.run import main

main()
