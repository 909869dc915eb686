"""What the tests of the plugins and benchmarks/accuracy.py share: small scenes, and statistics of pictures."""
