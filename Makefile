# Each target works alone on a fresh machine: it calls `setup`, which exits immediately if everything is installed.

CARGO := scripts/cargo
SHELL := /bin/bash

VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)

# What `make demo` runs; any other shot and options will do as well: make demo DEMO="render my.obj"
DEMO ?= compare scenes/court/court.toml --backend embree --frames 1-24 --size 560x315 --paths 4 --audit --denoise --png -o out/court/court.\#\#\#\#.exr --report out/court/report.html
# and then, for one line: a shot of which reuse saves little
HARD ?= $(if $(filter file,$(origin DEMO)),compare scenes/city/city.toml --backend embree --samples 1 --frames 1-24 --progress none)

.PHONY: help setup build demo test test-blender bench compare-peers quality paper package wheel blender crates clean
.DEFAULT_GOAL := help

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):[a-z ]*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 16

setup: ## install missing dependencies: build tools, Rust, OpenEXR, Embree, Open Image Denoise
	@scripts/setup

build: setup ## build the program: target/release/afterimage
	$(CARGO) build --release --locked

demo: setup ## render a shot with reuse and in full, and compare: out/court/
	$(CARGO) run --release --locked -- $(DEMO)
ifneq ($(HARD),)
	@echo; echo "The hard case, one hard light, mirrors and a camera that travels (scenes/city/city.toml):"
	@set -o pipefail; $(CARGO) run --quiet --release --locked -- $(HARD) | grep "^in short"
endif

# cargo-nextest runs the tests faster, but no doctests. USD files are tested where Rust is new enough for them.
test: setup ## run all tests
	@features=$$($(CARGO) --features); \
	[ -n "$$features" ] || echo "USD files are not tested: that needs a newer Rust (docs/usd.md)"; \
	if $(CARGO) nextest --version >/dev/null 2>&1; then \
		set -x; $(CARGO) nextest run --workspace $$features --locked --no-fail-fast && $(CARGO) test --workspace $$features --locked --doc; \
	else \
		set -x; $(CARGO) test --workspace $$features --locked --no-fail-fast; \
	fi
	@scripts/test-python
	@$(MAKE) --no-print-directory test-blender

# skipped, and said so, where BPY_PYTHON (python3) has no bpy
test-blender: ## test the Blender extension, where a Python with bpy is installed (BPY_PYTHON)
	$(or $(BPY_PYTHON),python3) integrations/blender/tests

# `make bench SHOTS=--quick` is small, to see that it works; `cargo bench --bench shots -- --help` lists all options.
CHAINS ?= $(filter --quick,$(SHOTS))
GATHERED ?= $(CHAINS)

bench: setup ## benchmark each kind of shot, long chains, gathered light and each phase
	$(CARGO) bench --locked --bench shots -- $(SHOTS)
	$(CARGO) bench --locked --bench shots -- chains $(CHAINS)
	$(CARGO) bench --locked --bench shots -- gathered $(GATHERED)
	$(CARGO) bench --locked --bench phases

# `make compare-peers PEERS="--quick --depths 3"` is small; `scripts/compare-peers --help` says what it needs.
compare-peers: build ## measure Mitsuba and Cycles on the same work, where they are installed (PEERS_PYTHON)
	$(or $(PEERS_PYTHON),python3) scripts/compare-peers $(PEERS)

# `make quality QUALITY=--quick` is small; `cargo bench --bench quality -- --help` lists all options.
quality: setup ## measure how good pictures of reused samples are
	$(CARGO) bench --locked --bench quality -- $(QUALITY)

# `make paper PAPER="--frames 1-24"` is small; `scripts/paper --help` lists all options.
paper: build ## rerun the paper's three animations, beside its figures: docs/paper.md
	scripts/paper $(PAPER)

package: setup ## make an archive that runs where it is unpacked, and test it: target/package/
	scripts/package
	scripts/test-package target/package/afterimage-$(VERSION)-$(shell uname -m)-linux.tar.gz

wheel: package ## make a Python wheel of the module and the program, and test it: target/package/
	scripts/wheel
	scripts/test-package target/package/afterimage_renderer-$(VERSION)-*.whl

# The wheel in target/package is carried if there is one: run `make wheel` first.
blender: ## make Blender's extension, and validate it: target/blender/ (needs blender, or BPY_PYTHON with bpy)
	python3 integrations/blender/scripts/build.py target/blender $(lastword $(wildcard target/package/afterimage_renderer-*.whl))

# Needs cargo 1.90 or later. The crates are built in a folder from which .deps is not found.
crates: setup ## check that the crates can be published: packed, and built of what was packed
	EMBREE_DIR=$${EMBREE_DIR:-$(wildcard $(CURDIR)/.deps/embree)} $(CARGO) publish --workspace --dry-run --locked

clean: ## remove what was built and rendered; what `setup` fetched stays
	rm -rf target out
