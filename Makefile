# The commands that people and continuous integration share. Everything goes into .venv and out.
PYTHON ?= python3
PEER_PYTHON ?= $(PYTHON)
BIN := .venv/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet
INSTALLED := .venv/.installed
DEVELOPED := .venv/.developed

PEERS := .venv-bench/.installed

.PHONY: help install dragon figures bench growth test lint clean
.DELETE_ON_ERROR:

help:
	@echo "make dragon    install, fetch the Stanford dragon, render it in jade: out/dragon.png, out/dragon.exr"
	@echo "make figures   the paper's results on the dragon: out/figures"
	@echo "make bench     beside Cycles, LuxCore and Mitsuba, some two hours: docs/benchmark.md; BENCH=--quick: some minutes"
	@echo "make growth    time and memory as scenes grow, some 12 minutes: docs/growth.md; GROWTH=--quick: a few"
	@echo "make install   the package alone, into .venv: run $(BIN)/nephrite"
	@echo "make test      the tests; make test PYTEST='-m \"not slow\"' for the quick ones"
	@echo "make lint      ruff and pyright"
	@echo "make clean     remove what was built and rendered (the fetched dragon stays in your cache folder)"

install: $(INSTALLED)

# pip runs again only when pyproject.toml has changed, so everything works without a network afterwards.
$(INSTALLED): pyproject.toml
	@start=$$(date +%s); echo "Installing into .venv (a minute or so) ..."; \
	  { [ -x $(BIN)/pip ] || $(PYTHON) -m venv .venv; } && $(PIP) --editable . && touch $@ && \
	  echo "installed in $$(( $$(date +%s) - start )) s"

$(DEVELOPED): pyproject.toml $(INSTALLED)
	@echo "Installing what tests need ..."; $(PIP) --editable '.[dev]' && touch $@

dragon: $(INSTALLED)
	@mkdir -p out
	$(BIN)/nephrite render dragon --material jade --resolution 800x600 --time 24s -o out/dragon.png -o out/dragon.exr

figures: $(INSTALLED)
	@mkdir -p out/figures
	$(BIN)/nephrite compare dragon --material skimmilk --light benchmark --models 'brdf | dipole | walk' \
	  --resolution 640x480 -o out/figures/brdf-bssrdf.png
	$(BIN)/nephrite compare dragon --material skimmilk --light benchmark --terms 'reduced | single | multiple | all' \
	  --resolution 640x480 -o out/figures/single-multiple.png
	$(BIN)/nephrite render dragon --material jade --resolution 960x720 --time 90s -o out/figures/jade-dragon.png
	$(BIN)/nephrite profile "skim milk" --models tabulated,photon_beam,normalized,dipole \
	  -o out/figures/profile-skim-milk.png

bench: $(INSTALLED) $(PEERS)
	$(BIN)/python -m benchmarks.bench $(BENCH)

growth: $(INSTALLED) $(PEERS)
	$(BIN)/python -m benchmarks.growth $(GROWTH)

# Each peer that has a wheel for this Python; one that has none is left out of the benchmark.
$(PEERS): Makefile
	@echo "Installing the benchmark's peers into .venv-bench (1.4 GB) ..."
	@[ -x .venv-bench/bin/pip ] || $(PEER_PYTHON) -m venv .venv-bench
	@for peer in bpy pyluxcore; do \
	  .venv-bench/bin/python -m pip --disable-pip-version-check install --quiet --only-binary :all: numpy $$peer || \
	  echo "left out: there is no $$peer for $$($(PEER_PYTHON) --version). Blender 5.0 wants PEER_PYTHON=python3.11"; done
	@touch $@

test: $(DEVELOPED)
	$(BIN)/python -m pytest $(PYTEST)

lint: $(DEVELOPED)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright

clean:
	rm -rf .venv .venv-bench out build dist .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
