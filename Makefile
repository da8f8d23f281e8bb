# The front door: `make demo` and `make test` do everything from a bare Debian on. The work is done by
# tools/ and Meson; `make help` lists the targets.

BUILD ?= build
# Where Debian's GStreamer looks for plug-ins: with it, installing is all there is to do.
PREFIX ?= /usr
JOBS ?= $(shell nproc)
FUZZ_SECONDS ?= 60
SOAK_SECONDS ?= 600
# Where `make demo-faces` shows what it draws: a window where there is a display.
SHOW ?= $(if $(DISPLAY)$(WAYLAND_DISPLAY),--show)
# For example --no-engines, or --yes.
SETUP_FLAGS ?=
# Further options of Meson, for example -Donnxruntime=disabled.
MESON_FLAGS ?=

export DESTDIR
# ccache: what was compiled in one folder serves in another one, also from precompiled headers.
export CCACHE_BASEDIR := $(CURDIR)
export CCACHE_NOHASHDIR := 1
export CCACHE_SLOPPINESS := pch_defines,time_macros

.PHONY: help needs-input setup setup-to-use configure configure-to-use build test demo demo-faces bench bench-mtcnn bench-street bench-ars install uninstall deb wheel clean distclean fuzz fuzz-keep asan tsan soak docs format lint models-table
.NOTPARALLEL:

help:
	@sed -n 's/^#: //p' $(firstword $(MAKEFILE_LIST))

# The demos and `make install` need no package of the tests and compile only what they use.
#: make demo        set up, build, read the clock in a live picture and the text of a board; INPUT=photo-or-video MODEL=model: classify that
demo: configure-to-use
	@ninja -C $(BUILD) -j $(JOBS) $(if $(INPUT)$(MODEL),demo-input,demo)
	@tools/demo --build $(BUILD) --input "$(INPUT)" --model "$(MODEL)"

#: make demo-faces  find faces in a video, draw them, write BUILD/demo/faces.mkv, show it where a display is (SHOW=: not); INPUT=clip FRAMEWORK=onnxruntime
demo-faces: needs-input configure-to-use
	@ninja -C $(BUILD) -j $(JOBS) demo-faces $(if $(FRAMEWORK),demo-input)
	@mkdir -p $(BUILD)/demo
	@examples/mtcnn/run --build $(BUILD) --output $(BUILD)/demo/faces.mkv $(SHOW) $(if $(FRAMEWORK),--framework $(FRAMEWORK)) \
	  "$(INPUT)" && echo "$(BUILD)/demo/faces.mkv"

needs-input:
	@test -n "$(INPUT)" || { echo "make $(firstword $(MAKECMDGOALS)): no video is named; give one: make $(firstword $(MAKECMDGOALS)) INPUT=clip.mp4" >&2; exit 1; }

#: make test        set up, build, and run every test
test: build
	@tools/run-tests $(BUILD)

bench bench-mtcnn bench-street bench-ars: MESON_FLAGS += -Dbenchmarks=true
#: make bench       set up, build, and measure: a table of ratios
bench: build
	@tools/bench $(BUILD)

#: make bench-mtcnn the face detection example against its control; INPUT=clip, tables into BUILD/mtcnn
bench-mtcnn: needs-input build
	@benchmarks/mtcnn/bench --build $(BUILD) --output $(BUILD)/mtcnn "$(INPUT)"

#: make bench-street the street example against its control; INPUT=clip, a table into BUILD/street
bench-street: needs-input build
	@benchmarks/street/bench --build $(BUILD) --output $(BUILD)/street "$(INPUT)"

#: make bench-ars   the activity recognition example against its control, a table into BUILD/ars
bench-ars: build
	@benchmarks/ars/bench --build $(BUILD) --output $(BUILD)/ars

#: make setup       install what is missing: packages and engines (SETUP_FLAGS=--check looks only)
setup:
	@tools/setup $(SETUP_FLAGS)

setup-to-use:
	@tools/setup --no-tests $(TO_CROSS) $(SETUP_FLAGS)

configure: setup
configure-to-use: setup-to-use
configure configure-to-use:
	@tools/configure $(BUILD) -Dprefix=$(PREFIX) $(MESON_FLAGS)

#: make build       set up and build
build: configure
	@ninja -C $(BUILD) -j $(JOBS)

#: make install     build and install (PREFIX=/usr, DESTDIR=)
install: configure-to-use
	@tools/install --jobs $(JOBS) $(BUILD) "$(PREFIX)"

#: make deb         build Debian packages into dist/deb; KEY=your-key signs the folder as a source for apt, ARCH=arm64 cross-compiles
deb: TO_CROSS = $(if $(ARCH),--arch "$(ARCH)")
deb: setup-to-use
	@tools/deb --jobs $(JOBS) $(TO_CROSS) $(if $(KEY),--key "$(KEY)")

#: make wheel       pack the package for Python with all that it needs of Weir into dist/weir-*.whl
wheel: configure-to-use
	@tools/wheel --jobs $(JOBS) $(BUILD) dist

#: make uninstall   remove what make install put there, and nothing else (same PREFIX and DESTDIR)
uninstall:
	@tools/uninstall "$(PREFIX)"

#: make fuzz        run each fuzz target for FUZZ_SECONDS=60, starting from the corpus
fuzz: setup
	@tools/fuzz build-fuzz $(FUZZ_SECONDS) $(JOBS)

#: make fuzz-keep   add to tests/fuzz/corpus what make fuzz found
fuzz-keep: setup
	@tools/fuzz --keep build-fuzz

#: make asan        run the tests in C++ and the fuzz corpora under AddressSanitizer and UndefinedBehaviorSanitizer; ASAN_FLAGS=--all: every test
asan: setup
	@tools/asan build-asan $(ASAN_FLAGS)

#: make tsan        run every test under ThreadSanitizer, which knows GLib's locks (TSAN_FLAGS='--suite library')
tsan: setup
	@tools/tsan build-tsan $(TSAN_FLAGS)

#: make soak        edit playing pipelines for SOAK_SECONDS=600, then run 16 streams with random faults as long: lost frames, growth of memory
soak: build
	@tools/soak $(BUILD) $(SOAK_SECONDS)

#: make docs        write docs/elements/ anew from the built plug-in
docs: build
	@tools/gen-docs

#: make models-table write docs/models.md: the catalogue of models, and what those that are here find
models-table: build
	@tools/models-table --build $(BUILD)

#: make format      lay the sources out as .clang-format says
format: setup
	@tools/sources cxx | xargs -0 -r clang-format -i

#: make lint        clang-tidy over the sources of the product, as .clang-tidy says (LINT_FLAGS='--changed 30' or --analyze)
lint: build
	@tools/lint --jobs $(JOBS) $(LINT_FLAGS) $(BUILD)

#: make clean       remove what was built; distclean: the engines too
clean:
	rm -rf $(BUILD) build-asan build-deb build-tsan build-fuzz

distclean: clean
	rm -rf .engines
