"""`python -m benchmarks.levers`: see `run`."""

from benchmarks.levers.run import main

main()
