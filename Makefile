# Each target works alone on a fresh machine: it calls `setup`, which is quick when all is there.

CARGO := scripts/cargo
SHELL := /bin/bash

# What `make demo` runs; any other shot and options will do as well: make demo DEMO="render my.obj"
DEMO ?= compare scenes/city/city.toml --backend embree --samples 1 --audit --png -o out/city/city.\#\#\#\#.exr --report out/city/report.html

.PHONY: help setup build demo test bench clean
.DEFAULT_GOAL := help

help: ## say what there is
	@sed -n 's/^\([a-z]*\):[a-z ]*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 8

setup: ## install what is missing: build tools, Rust, OpenEXR, Embree
	@scripts/setup

build: setup ## build the program: target/release/afterimage
	$(CARGO) build --release --locked

demo: setup ## render the city, reprojected and in full, and compare: out/city/
	$(CARGO) run --release --locked -- $(DEMO)

# cargo-nextest runs the tests faster, but no doctests.
test: setup ## run all tests
	@if $(CARGO) nextest --version >/dev/null 2>&1; then \
		set -x; $(CARGO) nextest run --workspace --locked --no-fail-fast && $(CARGO) test --workspace --locked --doc; \
	else \
		set -x; $(CARGO) test --workspace --locked --no-fail-fast; \
	fi

# `make bench SHOTS=--quick` is small, to see that it works; `cargo bench --bench shots -- --help` lists all options.
bench: setup ## measure: each kind of shot, each phase
	$(CARGO) bench --locked --bench shots -- $(SHOTS)
	$(CARGO) bench --locked --bench phases

clean: ## remove what was built and rendered; what `setup` fetched stays
	rm -rf target out
