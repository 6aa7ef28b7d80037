# iblbake. `make list` prints the targets; the variables users set are these:
#   config=release|debug|asan|cov|tsan   CC, CXX, CFLAGS, CXXFLAGS, LDFLAGS
#   DEPS=no      build and test with the system packages that are there
#   BUILD=DIR    where everything is built
#   DEFLATE=zlib reads EXR without libdeflate
#   LARGE=1      tests also bake a map of 16384x8192 (1.6 GB)
#   DESTDIR, PREFIX, BINDIR, LIBDIR, INCLUDEDIR, DATADIR, MANDIR for install
config ?= release
ifeq ($(config),release)
BUILD ?= build
else
BUILD ?= build/$(config)
endif
PREFIX ?= /usr/local
BINDIR ?= $(PREFIX)/bin
LIBDIR ?= $(PREFIX)/lib
INCLUDEDIR ?= $(PREFIX)/include
DATADIR ?= $(PREFIX)/share
MANDIR ?= $(DATADIR)/man
DEPS ?= yes
INSTALL ?= install
LARGE ?=
export IBL_TEST_LARGE := $(LARGE)

OPT_release := -O2 -g1 -DNDEBUG
OPT_debug := -O0 -g
# Undefined behaviour traps: the texts that would describe it are 5 MB of a
# program, which each start relocates and each search for leaks reads.
OPT_asan := -O0 -g1 -fsanitize=address,undefined,float-cast-overflow \
            -fsanitize=fuzzer-no-link -fsanitize-undefined-trap-on-error \
            -fno-omit-frame-pointer
OPT_cov := -O1 -g1 --coverage -fprofile-update=atomic
OPT_tsan := -O0 -g1 -fsanitize=thread
# The second compiler, whose libFuzzer shares the objects.
ifeq ($(config),asan)
CC := clang
CXX := clang++
endif
$(if $(OPT_$(config)),,$(error config=$(config): must be release, debug, asan, cov or tsan))
WARN := -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion \
        -Wvla -Wundef $(WERROR)
CWARN := -Wstrict-prototypes -Wmissing-prototypes
CFLAGS ?= $(OPT_$(config))
CXXFLAGS ?= $(OPT_$(config))
SANITIZE := $(filter -fsanitize=% --coverage,$(OPT_$(config)))
LINK = $(CXX)
# These take half as long as bfd, which counts for a hundred programs; of clang's
# list of symbols gold would warn without end.
FAST_LD := $(if $(filter asan,$(config)),lld,gold)
LINKER := $(if $(shell command -v ld.$(FAST_LD)),-fuse-ld=$(FAST_LD))
ifneq ($(filter -fsanitize=%,$(SANITIZE)),)
SANITIZE += $(LINKER)
endif
# Programs that load C++: the sanitizer looks for its exceptions at the start, and
# must leave memory to the operators of the bridge of models.
ifeq ($(config),asan)
LINK = $(CC)
SANITIZE += -Wl,--push-state,--no-as-needed -lstdc++ -Wl,--pop-state
endif

# libOpenEXRCore alone, not what pkg-config lists for the C++ library. EXR's ZIP
# is inflated by libdeflate, or by OpenEXRCore, which takes longer.
DEFLATE := $(shell pkg-config --exists libdeflate 2>/dev/null && \
             echo libdeflate || echo zlib)
DEFLATE_CFLAGS := $(shell pkg-config --cflags $(DEFLATE) 2>/dev/null) \
                 -DIBL_LIBDEFLATE=$(if $(filter libdeflate,$(DEFLATE)),1,0)
EXR_CFLAGS := $(shell pkg-config --cflags OpenEXR 2>/dev/null)
ZSTD_CFLAGS := $(shell pkg-config --cflags libzstd 2>/dev/null)
JSON_CFLAGS := $(shell pkg-config --cflags jansson 2>/dev/null)
IO_LIBS := $(shell pkg-config --variable=libdir OpenEXR 2>/dev/null | \
            sed 's/^/-L/') -lOpenEXRCore \
          $(shell pkg-config --libs $(DEFLATE) libzstd jansson libpng zlib \
              2>/dev/null)
CLI_CFLAGS := $(shell pkg-config --cflags libpng libjpeg zlib jansson libxxhash \
               libzstd 2>/dev/null)
CLI_LIBS := $(shell pkg-config --libs libjpeg libxxhash 2>/dev/null)
HAVE_VIEW := $(shell pkg-config --exists glfw3 gl imgui 2>/dev/null && echo yes)
VIEW_CFLAGS := $(shell pkg-config --cflags glfw3 gl libpng jansson 2>/dev/null)
VIEW_LIBS := $(shell pkg-config --libs glfw3 imgui 2>/dev/null)
HAVE_OIIO := $(shell pkg-config --exists OpenImageIO 2>/dev/null && echo yes)

# What libiblscene.so is built with: of each library that is there its macro and
# its name.
hash := \#
ask = '$(hash)if __has_include(<$(1)>)' '-DIBL_HAS_$(2)=1 -l$(3)' '$(hash)endif'
SCENE_HAS := $(shell printf '%s\n' $(call ask,meshoptimizer.h,MESHOPT,meshoptimizer) \
               $(call ask,draco/compression/decode.h,DRACO,draco) \
               $(call ask,webp/decode.h,WEBP,webp) | \
               $(CXX) -std=c++17 -E -P -x c++ - 2>/dev/null)
HAVE_CXX := $(shell command -v $(firstword $(CXX)) 2>/dev/null)

# The system's file of src/port/, and what its libraries and threads take.
PORT ?= posix
PORT_FLAGS ?= -pthread -fPIC -fno-semantic-interposition
REQUIRED := -std=c11 -D_XOPEN_SOURCE=700 -Iinclude -Isrc $(PORT_FLAGS) \
            -ffp-contract=off -fno-math-errno -fvisibility=hidden \
            '-ffile-prefix-map=$(CURDIR)=.' -MMD -MP
# Of the shared library; see CONTRIBUTING.md.
SOVERSION := 1
VERSION := $(shell sed -n 's/^.define IBL_VERSION "\(.*\)"/\1/p' \
             include/ibl/ibl.h)
# Of git, not of one that has this folder in it; `make dist` writes it down.
export GIT_CEILING_DIRECTORIES := $(CURDIR)/..
REVISION := $(shell git describe --always --dirty 2>/dev/null || cat REVISION 2>/dev/null)

comma := ,
blank := $(subst ,, )
PORT_SRC := src/port/$(PORT).c src/port/shared.c $(if $(filter-out posix,$(PORT)), \
              src/port/plain.c src/io/bridge/openexr_core.c)
# Vector versions; none for other CPUs.
ISAS_x86_64 := sse2 avx2
ISAS_aarch64 := neon
ISAS := $(ISAS_$(firstword $(subst -, ,$(shell $(CC) -dumpmachine 2>/dev/null))))
LIB_SRC := $(wildcard src/core/*.c src/image/*.c src/brdf/*.c src/kern/*.c \
                      src/bake/*.c src/bake/spectral/*.c src/probe/*.c \
                      src/io/*.c src/json/*.c src/engine/*.c src/set/*.c) \
           src/common/names.c src/common/path.c $(PORT_SRC)
# Each of these is compiled for every instruction set, and for any CPU if it has
# no plain version beside it: see src/kern/isa.h.
SIMD_SRC := $(filter %_simd.c,$(LIB_SRC))
PLAIN_SRC := $(filter-out $(patsubst %.c,%_simd.c, \
               $(shell grep -l ^IBL_KERNEL src/kern/*.c)),$(SIMD_SRC))
LIB_SRC := $(filter-out %_simd.c,$(LIB_SRC))
COMMON_SRC := $(filter-out $(LIB_SRC),$(wildcard src/common/*.c src/scene/*.c))
CLI_SRC := $(COMMON_SRC) $(wildcard src/cli/*.c)
LIB := $(BUILD)/libiblbake.a
SHARED := $(BUILD)/libiblbake.so
HLSL := $(BUILD)/gen/ibl.hlsl
BIN := $(BUILD)/iblbake
BRIDGE := $(BUILD)/libiblbridge.so
EXR_BRIDGE := $(BUILD)/libiblexr.so
SCENE_BRIDGE := $(BUILD)/libiblscene.so
VIEW_SRC := $(COMMON_SRC) $(wildcard src/view/*.c)
SHADERS := $(sort $(wildcard src/view/shaders/* include/ibl/*.glsl))
VIEW := $(BUILD)/iblview
obj = $(patsubst %.c,$(BUILD)/obj/%.o,$(1))
TESTS := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/check_*.c))
# What starts threads, and only once what bakes with them.
ifeq ($(config),tsan)
TESTS := $(patsubst %,$(BUILD)/tests/check_%,context environment level0 levels \
           read reference view_set)
endif
# Without what judges numbers and pixels by code that others run, too.
ifeq ($(config),asan)
TESTS := $(filter-out $(patsubst %,$(BUILD)/tests/check_%,axes brdf \
           disc_lights lobe_coefficients lut overflow point_lights \
           probe_parallax probes reference rendered sh transform truth view_ibl \
           view_controls view_inspect view_probe_set view_probes view_room \
           view_scene view_set view_shade view_stage view_steady view_tone \
           view_truth),$(TESTS))
endif
ifneq ($(HAVE_VIEW),yes)
TESTS := $(filter-out $(BUILD)/tests/check_view_%,$(TESTS))
endif
LIB_OBJ := $(call obj,$(LIB_SRC)) $(PLAIN_SRC:%.c=$(BUILD)/obj/%_plain.o) \
           $(foreach isa,$(ISAS),$(SIMD_SRC:%.c=$(BUILD)/obj/%_$(isa).o)) \
           $(BUILD)/obj/gen/lobe_tables.o
VIEW_OBJ := $(filter-out %/main.o,$(call obj,$(VIEW_SRC))) \
            $(BUILD)/obj/gen/shaders.o $(BUILD)/obj/src/view/ui.o
# Kernels and drawing know no threads: with ThreadSanitizer they are those of
# the release. With AddressSanitizer one of two vector versions is.
RELEASED_tsan := $(BUILD)/obj/src/kern/% $(BUILD)/obj/src/view/%
RELEASED_asan := %_sse2.o
ifneq ($(RELEASED_$(config)),)
RELEASED := $(filter $(RELEASED_$(config)), \
              $(filter-out %/baked_set.o,$(LIB_OBJ) $(VIEW_OBJ)))
LIB_OBJ := $(filter-out $(RELEASED),$(LIB_OBJ)) \
           $(patsubst $(BUILD)/%,build/%,$(filter $(RELEASED),$(LIB_OBJ)))
VIEW_OBJ := $(filter-out $(RELEASED),$(VIEW_OBJ)) \
            $(patsubst $(BUILD)/%,build/%,$(filter $(RELEASED),$(VIEW_OBJ)))
RELEASED := $(RELEASED:$(BUILD)/%=build/%)
endif
BENCHES := $(patsubst tests/%.c,$(BUILD)/tests/%,$(wildcard tests/bench_*.c))

.DELETE_ON_ERROR:
.SECONDARY:
.PHONY: all lib deps deps-named tests benches demo check check-run check-quick try \
        check-arm64 check-ports check-clients check-pairs mutants coverage check-cycles soak bench \
        npm page fuzz fuzzers lint lobe-tables format install uninstall deb windows dist \
        clean list budget FORCE

## all: the programs and the parts that they load (default)
ifeq ($(DEPS),no)
all: $(BIN) $(SHARED) $(HLSL) bridge exr-bridge scene-bridge view
else
all: deps-named
	+@$(MAKE) --no-print-directory DEPS=no all
endif

## lib: the library alone, static and shared
lib: $(LIB) $(SHARED) $(HLSL)

deps-named:
	@CC="$(CC)" sh tests/deps.sh name

## deps: install the system packages that are missing (DEPS=no: none)
deps:
	@DEPS=$(DEPS) CC="$(CC)" sh tests/deps.sh build

# Options of what a bake takes its time in, where the rest is built small, or, with
# sanitizers, compiled quickly.
HOT_asan := -O1
HOT_tsan := -O1
HOT ?= $(HOT_$(config))
ISA = $(if $(filter src/core/% src/image/% src/kern/% src/bake/% src/brdf/% \
           src/io/rgbe.c src/io/texture.c src/io/exr.c src/scene/survey.c,$<),$(HOT))
%_plain.o: ISA = -DIBL_PLAIN $(HOT)
%_sse2.o: ISA := -DIBL_SUFFIX=_sse2 $(HOT)
%_avx2.o: ISA := -DIBL_SUFFIX=_avx2 -mavx2 -mfma -mf16c $(HOT)
%_neon.o: ISA := -DIBL_SUFFIX=_neon $(HOT)
$(BUILD)/obj/src/io/exr.o: LOCAL = $(EXR_CFLAGS) $(DEFLATE_CFLAGS)
$(BUILD)/obj/src/io/zstd_frames.o: LOCAL = $(ZSTD_CFLAGS)
$(addprefix $(BUILD)/obj/src/,json/%.o io/probe_index.o \
    io/sidecar_text.o): LOCAL = $(JSON_CFLAGS)
$(BUILD)/obj/src/io/bridge.o: LOCAL = -DIBL_BRIDGE='"$(LIBDIR)/iblbake/libiblbridge.so"'
$(BUILD)/obj/src/view/%.o: LOCAL = $(VIEW_CFLAGS)
$(BUILD)/obj/src/engine/picture.o: LOCAL = $(CLI_CFLAGS) $(EXR_CFLAGS)
$(BUILD)/obj/src/common/%.o: LOCAL = $(CLI_CFLAGS)
$(BUILD)/obj/src/engine/%.o: LOCAL = $(CLI_CFLAGS)
$(BUILD)/obj/src/set/%.o: LOCAL = $(JSON_CFLAGS)
$(BUILD)/obj/src/scene/%.o: LOCAL = $(CLI_CFLAGS)
$(BUILD)/obj/src/scene/gltf_packed.o: LOCAL = $(CLI_CFLAGS) \
    -DIBL_SCENE_BRIDGE='"$(LIBDIR)/iblbake/libiblscene.so"'
$(BUILD)/obj/src/cli/%.o: LOCAL = $(CLI_CFLAGS) -DIBL_REVISION='"$(REVISION)"'

# What else was built with is built again: these files hold what was used and
# change with it alone. They come before what is compiled, and make its folders.
FOLDERS := $(addprefix $(BUILD)/,tests fuzz $(addprefix obj/,$(sort $(dir \
             $(wildcard src/*/*.c src/*/*/*.c tests/*.c tests/*/*.c)))))
$(BUILD)/used-cc: export USED = $(CC) $(subst $(CURDIR),,$(REQUIRED)) $(CPPFLAGS) $(CFLAGS)
$(BUILD)/used-libdir: export USED = $(LIBDIR)
$(BUILD)/used-revision: export USED = $(REVISION)
$(BUILD)/used-deflate: export USED = $(DEFLATE)
$(BUILD)/used-scene: export USED = $(SCENE_HAS)
$(BUILD)/used-cc $(BUILD)/used-libdir $(BUILD)/used-revision \
    $(BUILD)/used-deflate $(BUILD)/used-scene: FORCE
	@mkdir -p $(FOLDERS)
	@echo "$$USED" | cmp -s - $@ || echo "$$USED" >$@
$(BUILD)/obj/src/io/bridge.o $(BUILD)/obj/src/scene/gltf_packed.o: \
    $(BUILD)/used-libdir
$(addprefix $(BUILD)/obj/src/,io/exr.o engine/png.o): \
    $(BUILD)/used-deflate
$(addprefix $(BUILD)/obj/src/cli/,bake_write.o bench.o common_options.o \
    probes_bake.o): $(BUILD)/used-revision

$(RELEASED): released ;
.PHONY: released
released:
	+@$(MAKE) config=release BUILD=build $(RELEASED)

define COMPILE
$(CC) $(REQUIRED) $(WARN) $(CWARN) $(LOCAL) $(CPPFLAGS) $(CFLAGS) $(ISA) \
    -c -o $@ $<
endef
$(BUILD)/obj/%_simd_plain.o: %_simd.c $(BUILD)/used-cc
	$(COMPILE)
$(BUILD)/obj/%_simd_sse2.o: %_simd.c $(BUILD)/used-cc
	$(COMPILE)
$(BUILD)/obj/%_simd_avx2.o: %_simd.c $(BUILD)/used-cc
	$(COMPILE)
$(BUILD)/obj/%_simd_neon.o: %_simd.c $(BUILD)/used-cc
	$(COMPILE)
$(BUILD)/obj/%.o: %.c $(BUILD)/used-cc
	$(COMPILE)

$(LIB): $(LIB_OBJ)
	@rm -f $@
	$(AR) rcs $@ $^

$(SHARED): $(LIB_OBJ)
	$(CC) $(SANITIZE) $(LDFLAGS) -shared -Wl,-soname,$(@F).$(SOVERSION) \
	    $(if $(SANITIZE),,-Wl$(comma)-z$(comma)defs) -pthread -o $@ $^ \
	    $(IO_LIBS) -lm -ldl $(LDLIBS)

CLI_GEN := $(BUILD)/obj/gen/bench_page.o $(BUILD)/obj/gen/targets.o
$(BIN): $(call obj,$(CLI_SRC)) $(CLI_GEN) $(LIB)
	$(CC) $(SANITIZE) $(LDFLAGS) -pthread -o $@ $^ $(IO_LIBS) $(CLI_LIBS) \
	    -lm -ldl $(LDLIBS)

# The same for WebAssembly, by the libraries of libraries.sh: make npm.
WASM_LIBS := $(BUILD)/deps/libdeps.a
$(BUILD)/iblbake.wasm: $(call obj,$(CLI_SRC)) $(CLI_GEN) $(LIB) $(WASM_LIBS)
	emcc -O2 -sALLOW_MEMORY_GROWTH -sMAXIMUM_MEMORY=4GB -sINITIAL_MEMORY=64MB \
	    -sTOTAL_STACK=1MB -sERROR_ON_UNDEFINED_SYMBOLS=0 -sWASM_BIGINT \
	    -sEXPORTED_FUNCTIONS=_main,_setThrew,stackSave,stackRestore \
	    -o $@ $^ $(LDLIBS)

# C++. Left out, with a word, where OpenImageIO is not installed.
.PHONY: bridge
ifeq ($(HAVE_OIIO),yes)
bridge: $(BRIDGE)
else
bridge:
	@echo "iblbake: built without the image bridge: package" \
	    "libopenimageio-dev is missing (TIFF, PNG, ...)"
endif
$(BRIDGE): src/io/bridge/bridge.cpp src/io/bridge/bridge.h
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Iinclude -Isrc -fPIC -shared -fvisibility=hidden \
	    '-ffile-prefix-map=$(CURDIR)=.' \
	    $(WARN) $$(pkg-config --cflags OpenImageIO | sed "s/-I/-isystem /g") \
	    $(CPPFLAGS) $(CXXFLAGS) $(LDFLAGS) -o $@ $< \
	    $$(pkg-config --libs OpenImageIO)

# EXR's compressions but ZIP, by the library of which OpenEXRCore is a part.
.PHONY: exr-bridge
exr-bridge: $(if $(HAVE_CXX),$(EXR_BRIDGE))
$(EXR_BRIDGE): src/io/bridge/openexr.cpp src/io/bridge/openexr.h
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Isrc -fPIC -shared -fvisibility=hidden \
	    '-ffile-prefix-map=$(CURDIR)=.' $(WARN) \
	    $$(pkg-config --cflags OpenEXR | sed "s/-I/-isystem /g") \
	    $(CPPFLAGS) $(CXXFLAGS) $(LDFLAGS) -o $@ $< \
	    $$(pkg-config --libs OpenEXR)

# Decoders of models, without those that are not installed.
.PHONY: scene-bridge
scene-bridge: $(if $(HAVE_CXX),$(SCENE_BRIDGE))
	@case '$(SCENE_HAS)' in *MESHOPT*DRACO*WEBP*) ;; *) \
	    echo "iblbake: built without decoders of models: package" \
	        "libmeshoptimizer-dev, libdraco-dev or libwebp-dev is missing";; esac
$(SCENE_BRIDGE): src/io/bridge/models.cpp \
    src/io/bridge/models.h $(BUILD)/used-scene
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Isrc -fPIC -shared -fvisibility=hidden \
	    '-ffile-prefix-map=$(CURDIR)=.' $(WARN) \
	    $(filter -D%,$(SCENE_HAS)) $(CPPFLAGS) $(CXXFLAGS) $(LDFLAGS) -o $@ \
	    $< $(filter -l%,$(SCENE_HAS))

# The viewer, with its shaders inside. Left out, with a word, without GLFW,
# OpenGL's header or Dear ImGui.
.PHONY: view
ifeq ($(HAVE_VIEW),yes)
view: $(VIEW)
else
view:
	@echo "iblbake: built without iblview: package libglfw3-dev, libgl-dev or" \
	    "libimgui-dev is missing"
endif
$(BUILD)/gen/bench_page.c: src/cli/bench_page.html
	@mkdir -p $(@D)
	{ echo 'extern const char ibl_bench_page[];'; \
	    echo 'const char ibl_bench_page[] ='; \
	    sed 's/[\\"]/\\&/g; s/.*/"&\\n"/' $<; echo ';'; } >$@
$(BUILD)/gen/lobe_tables.c: src/bake/lobe_tables.f16
	@mkdir -p $(@D)
	{ echo '#include "bake/lobe_fit.h"'; \
	    echo 'const unsigned char ibl_lobe_tables[] = {'; \
	    od -An -v -tu1 $< | sed 's/[0-9][0-9]*/&,/g'; echo '};'; } >$@
$(HLSL): include/ibl/hlsl.sed include/ibl/ibl.glsl
	@mkdir -p $(@D)
	sed -E -f $^ >$@
$(BUILD)/gen/targets.c: src/cli/targets.awk include/ibl/ibl.glsl \
                        man/iblbake-engines.7
	@mkdir -p $(@D)
	awk -f $^ >$@
$(BUILD)/gen/shaders.c: src/view/embed.awk $(SHADERS)
	@mkdir -p $(@D)
	awk -f src/view/embed.awk $(SHADERS) >$@
$(BUILD)/obj/gen/%.o: $(BUILD)/gen/%.c
	@mkdir -p $(@D)
	$(CC) $(REQUIRED) $(WARN) $(CPPFLAGS) $(CFLAGS) -c -o $@ $<
$(BUILD)/obj/src/view/ui.o: src/view/ui.cpp
	@mkdir -p $(@D)
	$(CXX) -std=c++17 -Iinclude -Isrc -fPIC -fvisibility=hidden -MMD -MP \
	    '-ffile-prefix-map=$(CURDIR)=.' $(WARN) \
	    $$(pkg-config --cflags imgui | sed "s/-I/-isystem /g") \
	    $(VIEW_CFLAGS) $(CPPFLAGS) $(CXXFLAGS) -c -o $@ $<
$(VIEW): $(call obj,src/view/main.c) $(VIEW_OBJ) $(LIB)
	$(LINK) $(SANITIZE) $(LDFLAGS) -pthread -o $@ $^ $(VIEW_LIBS) $(IO_LIBS) \
	    $(CLI_LIBS) -lm -ldl $(LDLIBS)

TEST_OBJ := $(call obj,tests/test.c tests/truth.c tests/files.c \
                       tests/maps.c tests/textures.c tests/reference.c \
                       tests/kern.c tests/float_exr.c)
$(BUILD)/tests/%: $(BUILD)/obj/tests/%.o $(TEST_OBJ) $(LIB)
	$(CC) $(SANITIZE) $(LINKER) $(LDFLAGS) -pthread -o $@ $^ $(TEST_LIBS) $(IO_LIBS) \
	    $(CLI_LIBS) -lm -ldl $(LDLIBS)

# Judges, as the program does. The library serves them, too.
$(BUILD)/tests/check_rendered: TEST_LIBS = $(LIB)
$(BUILD)/tests/check_rendered: $(addprefix $(BUILD)/obj/src/, cli/figures.o \
    cli/lookup.o cli/rendered.o common/signals.o common/process.o)

$(BUILD)/tests/check_engine: TEST_LIBS = $(LIB)

$(BUILD)/tests/check_scene: TEST_LIBS = $(LIB)
$(BUILD)/tests/check_scene: $(call obj,$(wildcard src/scene/*.c) \
    src/common/signals.c)

# A file system that cannot flush, or is used by others.
$(BUILD)/tests/check_outputs: TEST_LIBS = -Wl,--wrap=fsync -Wl,--wrap=mkdir
# Reads that come short or fail.
$(BUILD)/tests/check_read: TEST_LIBS = -Wl,--wrap=pread

# Counts what our own code asks the C library for.
$(BUILD)/tests/check_view_steady: TEST_LIBS = -Wl,--wrap=malloc \
    -Wl,--wrap=calloc -Wl,--wrap=realloc -Wl,--wrap=aligned_alloc \
    -Wl,--wrap=posix_memalign -Wl,--wrap=strdup

# Frames that take as long as a test says.
$(BUILD)/tests/check_view_truth: \
    TEST_LIBS = -Wl,--wrap=ibl_now

VIEW_TESTS := $(filter $(BUILD)/tests/check_view_%,$(TESTS)) \
              $(BUILD)/tests/cycles
$(VIEW_TESTS): $(BUILD)/tests/%: $(BUILD)/obj/tests/%.o \
        $(call obj,tests/view.c tests/shade.c tests/room.c tests/sets.c \
                   src/cli/lookup.c) \
        $(TEST_OBJ) $(VIEW_OBJ) $(LIB)
	$(LINK) $(SANITIZE) $(LINKER) $(LDFLAGS) -pthread -o $@ $^ $(TEST_LIBS) \
	    $(VIEW_LIBS) $(IO_LIBS) $(CLI_LIBS) -lm -ldl $(LDLIBS)

# Harnesses of libFuzzer.
FUZZERS := $(patsubst tests/fuzz/%.c,$(BUILD)/fuzz/%, \
             $(wildcard tests/fuzz/fuzz_*.c))
ifneq ($(HAVE_VIEW),yes)
FUZZERS := $(filter-out %_json %_options,$(FUZZERS))
endif
FUZZ_WRAP = read pread ibl_print_line
$(BUILD)/fuzz/fuzz_image: FUZZ_WRAP += ibl_bridge_rows
$(BUILD)/fuzz/fuzz_json: FUZZ_WRAP += view_upload
$(call obj,$(wildcard tests/fuzz/*.c)): LOCAL = $(CLI_CFLAGS) $(VIEW_CFLAGS)
$(BUILD)/fuzz/librest.a: $(filter-out %/main.o,$(call obj,$(wildcard \
    src/cli/*.c))) $(VIEW_OBJ) $(CLI_GEN)
	@mkdir -p $(@D)
	@rm -f $@
	$(AR) rcs $@ $^
$(FUZZERS): $(BUILD)/fuzz/%: $(BUILD)/obj/tests/fuzz/fuzz.o \
    $(BUILD)/obj/tests/fuzz/%.o $(BUILD)/fuzz/librest.a $(LIB)
	$(LINK) $(SANITIZE) -fsanitize=fuzzer $(LDFLAGS) -pthread -o $@ \
	    $(patsubst %,-Wl$(comma)--wrap=%,$(FUZZ_WRAP)) $(filter %.o,$^) \
	    -Wl,--start-group $(filter %.a,$^) -Wl,--end-group $(VIEW_LIBS) \
	    $(IO_LIBS) $(CLI_LIBS) -lm -ldl $(LDLIBS)
$(BUILD)/fuzz/seeds: tests/fuzz/seeds.sh | $(BIN) $(VIEW)
	bash $< $(BUILD) $@

tests: $(TESTS) exr-bridge scene-bridge
benches: $(BENCHES)
fuzzers: $(FUZZERS) exr-bridge scene-bridge $(BUILD)/fuzz/seeds

## demo: set up, bake data/forest.exr, leave the README's pictures in build/demo
DEMO = build/demo
demo: deps
	@echo "iblbake: building"
	+@$(MAKE) -s $(JOBS) DEPS=no all
	+@$(MAKE) --no-print-directory DEPS=no demo-pictures
	@ls -l $(DEMO) $(DEMO)/forest
	@echo "iblbake: look at the pictures in $(DEMO), or run" \
	    "$(VIEW) $(DEMO)/forest"

# By the programs as they are: check-readme.sh runs these lines.
.PHONY: demo-pictures
demo-pictures:
	$(BIN) data/forest.exr -o $(DEMO)/forest -v --preview $(DEMO)/preview.png
ifeq ($(HAVE_VIEW),yes)
	$(VIEW) $(DEMO)/forest --offscreen $(DEMO)/iblview.png $(SPHERES)
	$(VIEW) $(DEMO)/forest --contact-sheet $(DEMO)/sheet.png
	$(BIN) data/sky.exr -q -o $(DEMO)/sky --sun
	$(VIEW) $(DEMO)/sky --offscreen $(DEMO)/scene-parallax.png $(ROOM)
	$(VIEW) $(DEMO)/sky --offscreen $(DEMO)/scene-infinite.png $(ROOM) \
	    --parallax none
	$(VIEW) $(DEMO)/forest -q --offscreen $(DEMO)/view-levels.png \
	    --size 640x360 --mode levels --level 3 --filter
	$(VIEW) $(DEMO)/sky -q --offscreen $(DEMO)/view-model.png \
	    --size 640x360 --model data/knot.glb --ground --pitch 14 --yaw 20 \
	    --distance 4.2 --turn 215 --blur 0.4 --antialias 3
	$(VIEW) $(DEMO)/forest -q --offscreen $(DEMO)/view-panel.png --panel \
	    --size 1080x608 --grid 3x5 --turn 250 --parts diffuse \
	    --against "--parts specular"
else
	@echo "iblbake: there are no spheres, because iblview was not built"
endif
SPHERES = -q --size 896x504 --grid 4x8 --turn 250 --pitch 4 --no-labels
ROOM = -q --mode scene --size 480x270 --turn 215 --distance 4.6 --fov 65 \
       --seconds 3 --pitch 16 --probe-size 128 --no-labels

## pictures: the README's, those of the demo and rough metals, into data/
.PHONY: pictures
pictures: demo
	cd $(DEMO) && cp preview.png iblview.png scene-*.png view-*.png \
	    $(CURDIR)/data
	sh tests/pictures.sh $(BUILD)

# Every build that must pass, then everything in it.
CHECKED := build build/asan build/tsan
## check: set up, then every test (release, sanitizers, lint)
check:
	@DEPS=$(DEPS) sh tests/deps.sh check
	+@$(MAKE) --no-print-directory DEPS=no check-run
JOBS = $(if $(filter -j%,$(MAKEFLAGS)),,-j$(shell nproc))
STRICT = $(MAKE) -s $(JOBS) DEPS=no WERROR=-Werror all tests
check-run:
	@echo "iblbake: building with gcc, and with clang's and gcc's sanitizers," \
	    "some minutes"
	+@$(STRICT)
	+@$(STRICT) config=asan fuzzers
	+@$(STRICT:all=build/tsan/iblbake) config=tsan
	@bash tests/run.sh $(CHECKED)

## fuzz: libFuzzer on all that reads files, and command lines; TIME=600 s each
TIME ?= 600
fuzz:
	@DEPS=$(DEPS) sh tests/deps.sh check
	+@$(MAKE) -s $(JOBS) DEPS=no config=asan fuzzers
	@bash tests/fuzz/run.sh build/asan $(TIME)

## check-quick: the tests of one build without the slow ones (a minute)
check-quick:
	+@$(STRICT)
	@bash tests/run.sh --quick $(BUILD)

## try: one test after a change: make try T=check_mips, or T=check-cli ONLY=zstd
try:
	@ls tests/$(T:.sh=).c tests/$(T:.sh=).sh 2>/dev/null | grep -q check || { \
	    echo "iblbake: make try T=check_mips or T=check-cli: T is no test" >&2; \
	    exit 2; }
	+@$(MAKE) -s $(JOBS) DEPS=no all $(TRIED)
	@$(if $(TRIED),$(TRIED) $(ONLY), \
	    BUILD=$(BUILD) ONLY='$(ONLY)' bash tests/$(T:.sh=).sh)
TRIED = $(patsubst %,$(BUILD)/tests/%,$(filter check_%,$(T)))

## check-arm64: kernels, bakes and containers for aarch64, by qemu-user (minutes)
check-arm64:
	@DEPS=$(DEPS) sh tests/deps.sh arm64
	+@$(MAKE) -s $(JOBS) DEPS=no $(BUILD)/iblbake $(BUILD)/tests/write_textures
	@BUILD=$(BUILD) bash tests/check-arm64.sh

## check-ports: packages, other systems, installation, engines (ten minutes)
check-ports:
	@DEPS=$(DEPS) sh tests/deps.sh check
	-@for of in page windows deb arm64; do \
	    DEPS=$(DEPS) sh tests/deps.sh $$of; done
	+@$(MAKE) -s $(JOBS) DEPS=no all $(BUILD)/tests/write_textures
	@BUILD=$(BUILD) bash tests/check-ports.sh

## check-clients: our files in three, Babylon, Filament, PlayCanvas (two minutes)
MAPS ?= quarry royal dusk blaze
check-clients:
	@DEPS=$(DEPS) sh tests/deps.sh check
	+@$(MAKE) -s $(JOBS) DEPS=no $(BUILD)/iblbake
	@BUILD=$(BUILD) MAPS='$(MAPS)' bash tests/check-clients.sh

## check-pairs: all pairs of options, gcc and asan (half an hour)
check-pairs:
	@DEPS=$(DEPS) sh tests/deps.sh check
	+@$(STRICT)
	+@$(STRICT) config=asan
	@BUILD=build bash tests/check-pairs.sh all
	@BUILD=build/asan bash tests/check-pairs.sh all

## bench: set up, then compare with stb_image and cmgen (minutes)
bench:
	@DEPS=$(DEPS) sh tests/deps.sh bench
	+@$(MAKE) -s $(JOBS) DEPS=no all benches
	bash tests/bench-spectral.sh $(BUILD)
	bash tests/bench-peers.sh $(BUILD)

## mutants: break the program in 161 ways, and 200 lines at random by SEED; which
## do the tests see? (three hours)
SEED ?= 1
mutants:
	@DEPS=$(DEPS) sh tests/deps.sh check
	@bash tests/mutants/run.sh
	@bash tests/mutants/run.sh --random $(SEED) 200

## coverage: the share of lines of each folder that the tests reach (minutes)
coverage:
	@DEPS=$(DEPS) sh tests/deps.sh check
	+@$(MAKE) -s $(JOBS) DEPS=no config=cov all tests
	-@bash tests/run.sh build/cov
	@find build/cov -name '*.gcda' -exec gcov --json-format --stdout {} + | \
	    node tests/coverage.mjs

## soak: 2,000 bakes, probes and pictures in one process; memory stays flat
soak:
	+@$(MAKE) -s $(JOBS) DEPS=no $(BUILD)/tests/check_view_steady
	@IBL_TEST_SOAK=2000 $(BUILD)/tests/check_view_steady soak

## check-cycles: the viewer against Blender's Cycles, if there is one; MAP=FILE
check-cycles: deps
	+@$(MAKE) -s $(JOBS) DEPS=no $(BUILD)/iblbake $(BUILD)/tests/cycles
	@bash tests/cycles.sh $(BUILD) $(if $(MAP),'$(MAP)')

## lint: formatting, headers alone, symbol prefix, layers, man pages
lint: $(LIB) $(SHARED)
	@BUILD=$(BUILD) sh tests/lint.sh
## budget: count lines anew, which lint then allows of each folder
budget:
	sh tests/budget.sh >tests/budget.new && mv tests/budget.new tests/budget.txt
## lobe-tables: compute the tables of lobes that are not computed in bakes anew
lobe-tables: $(BUILD)/tests/write_lobe_tables
	$< >$(BUILD)/lobe_tables && cp $(BUILD)/lobe_tables src/bake/lobe_tables.f16
format:
	clang-format -i $$(git ls-files '*.c' '*.h' '*.cpp')

# A file of the library's users: pkg-config wants blanks of paths escaped.
STATIC_LIBS = $(strip $(IO_LIBS)) -lm -ldl -pthread
path = $(if $(filter %.pc,$(2)),$(subst $(blank),\\$(blank),$(1)),$(1))

FILL = sed -e 's|@LIBDIR@|$(call path,$(LIBDIR),$(2))|' \
	    -e 's|@INCLUDEDIR@|$(call path,$(INCLUDEDIR),$(2))|' \
	    -e 's|@PREFIX@|$(call path,$(PREFIX),$(2))|' \
	    -e 's|@VERSION@|$(VERSION)|' -e 's|@SOVERSION@|$(SOVERSION)|' \
	    -e 's|@STATIC_LIBS@|$(STATIC_LIBS)|' \
	    -e 's|@STATIC_LIST@|$(subst $(blank),;,$(STATIC_LIBS))|' \
	    $(1) >"$(DESTDIR)$(LIBDIR)/$(2)"

COMPLETIONS := $(addprefix bash-completion/completions/,iblbake iblview) \
    zsh/site-functions/_iblbake \
    $(addprefix fish/vendor_completions.d/,iblbake.fish iblview.fish)
## install: DESTDIR, PREFIX, BINDIR, LIBDIR, INCLUDEDIR, DATADIR, MANDIR
install: all
	$(INSTALL) -d "$(DESTDIR)$(BINDIR)" "$(DESTDIR)$(LIBDIR)/pkgconfig" \
	    "$(DESTDIR)$(LIBDIR)/iblbake" "$(DESTDIR)$(LIBDIR)/cmake/iblbake" \
	    "$(DESTDIR)$(INCLUDEDIR)/ibl" "$(DESTDIR)$(MANDIR)/man1" \
	    "$(DESTDIR)$(MANDIR)/man7"
	$(INSTALL) -m 755 $(BIN) "$(DESTDIR)$(BINDIR)/iblbake"
	$(INSTALL) -m 644 man/iblbake*.1 "$(DESTDIR)$(MANDIR)/man1"
	for file in $(COMPLETIONS); do \
	    case $$file in bash*) from=iblbake.bash ;; zsh*) from=_iblbake ;; \
	    *) from=iblbake.fish ;; esac; \
	    $(INSTALL) -d "$(DESTDIR)$(DATADIR)/$${file%/*}" && \
	    $(INSTALL) -m 644 src/completion/$$from \
	        "$(DESTDIR)$(DATADIR)/$$file" || exit 1; done
	if [ -e $(VIEW) ]; then \
	    $(INSTALL) -m 755 $(VIEW) "$(DESTDIR)$(BINDIR)/iblview"; \
	    $(INSTALL) -m 644 man/iblview.1 "$(DESTDIR)$(MANDIR)/man1"; \
	    $(INSTALL) -d "$(DESTDIR)$(DATADIR)/iblbake"; \
	    $(INSTALL) -m 644 data/forest.exr "$(DESTDIR)$(DATADIR)/iblbake"; fi
	$(INSTALL) -m 644 $(LIB) "$(DESTDIR)$(LIBDIR)/libiblbake.a"
	$(INSTALL) -m 644 include/ibl/*.h include/ibl/*.glsl $(HLSL) \
	    "$(DESTDIR)$(INCLUDEDIR)/ibl"
	$(INSTALL) -m 644 man/*.7 "$(DESTDIR)$(MANDIR)/man7"
	for part in $(wildcard $(BRIDGE) $(EXR_BRIDGE) $(SCENE_BRIDGE)); do \
	    $(INSTALL) -m 755 $$part "$(DESTDIR)$(LIBDIR)/iblbake" || exit 1; done
	$(INSTALL) -m 755 $(SHARED) "$(DESTDIR)$(LIBDIR)/libiblbake.so.$(VERSION)"
	ln -sf libiblbake.so.$(VERSION) "$(DESTDIR)$(LIBDIR)/libiblbake.so.$(SOVERSION)"
	ln -sf libiblbake.so.$(SOVERSION) "$(DESTDIR)$(LIBDIR)/libiblbake.so"
	$(call FILL,src/iblbake.pc.in,pkgconfig/iblbake.pc)
	$(call FILL,src/iblbakeConfig.cmake.in,cmake/iblbake/iblbakeConfig.cmake)
	$(call FILL,src/iblbakeConfigVersion.cmake.in,cmake/iblbake/iblbakeConfigVersion.cmake)

## uninstall: remove what install put there
uninstall:
	rm -f "$(DESTDIR)$(BINDIR)/iblbake" "$(DESTDIR)$(BINDIR)/iblview" \
	    "$(DESTDIR)$(LIBDIR)/libiblbake.a" \
	    "$(DESTDIR)$(LIBDIR)/libiblbake.so" \
	    "$(DESTDIR)$(LIBDIR)/libiblbake.so.$(SOVERSION)" \
	    "$(DESTDIR)$(LIBDIR)/libiblbake.so.$(VERSION)" \
	    "$(DESTDIR)$(LIBDIR)/cmake/iblbake/iblbakeConfig.cmake" \
	    "$(DESTDIR)$(LIBDIR)/cmake/iblbake/iblbakeConfigVersion.cmake" \
	    "$(DESTDIR)$(LIBDIR)/iblbake/libiblbridge.so" \
	    "$(DESTDIR)$(LIBDIR)/iblbake/libiblexr.so" \
	    "$(DESTDIR)$(LIBDIR)/iblbake/libiblscene.so" \
	    "$(DESTDIR)$(LIBDIR)/pkgconfig/iblbake.pc" \
	    $(patsubst include/%,"$(DESTDIR)$(INCLUDEDIR)"/%,include/ibl/ibl.hlsl $(wildcard include/ibl/*.h include/ibl/*.glsl)) \
	    $(patsubst man/%,"$(DESTDIR)$(MANDIR)/man1"/%,$(wildcard man/*.1)) \
	    $(patsubst man/%,"$(DESTDIR)$(MANDIR)/man7"/%,$(wildcard man/*.7)) \
	    $(patsubst %,"$(DESTDIR)$(DATADIR)"/%,$(COMPLETIONS)) \
	    "$(DESTDIR)$(DATADIR)/iblbake/forest.exr"
	-rmdir "$(DESTDIR)$(LIBDIR)/iblbake" "$(DESTDIR)$(LIBDIR)/cmake/iblbake" \
	    "$(DESTDIR)$(INCLUDEDIR)/ibl" "$(DESTDIR)$(DATADIR)/iblbake" \
	    2>/dev/null || true

## page: the page that bakes in browsers, build/page: files for any web host
THREE := three@0.187.0
page: npm
	@[ "$$(cat $(BUILD)/npm-page/fetched 2>/dev/null)" = $(THREE) ] || { \
	    npm install --no-save --no-package-lock --no-audit --no-fund \
	        --ignore-scripts --loglevel=error --prefix $(BUILD)/npm-page \
	        $(THREE) && echo $(THREE) >$(BUILD)/npm-page/fetched; }
	node src/npm/page/build.mjs $(BUILD)/page \
	    $(BUILD)/npm-page/node_modules $(BUILD)/npm/package
## deb: Debian's packages, in build/deb
deb:
	@DEPS=$(DEPS) sh tests/deps.sh deb
	@sh packaging/deb.sh $(BUILD) $(VERSION)

## windows: build/windows/iblbake-VERSION-windows.zip, by mingw
windows:
	@DEPS=$(DEPS) sh tests/deps.sh windows
	+@sh packaging/windows.sh $(BUILD) $(VERSION)

## npm: the package of npm, build/npm/iblbake-VERSION.tgz, by emscripten
npm:
	@DEPS=$(DEPS) sh tests/deps.sh npm
	+@MAKE='$(MAKE)' sh packaging/npm.sh $(BUILD) $(VERSION)
	@ls -l $(BUILD)/npm/iblbake-$(VERSION).tgz

# Of what is committed, so that the tarball is the same wherever it is made.
DIST := iblbake-$(VERSION)
## dist: the tarball of a release, build/iblbake-VERSION.tar.gz
dist:
	@git diff --quiet HEAD || { echo "iblbake: dist packs what is committed:" \
	    "commit the changes, or run it in a clone" >&2; exit 1; }
	mkdir -p $(BUILD)
	git archive --format=tar.gz --prefix=$(DIST)/ \
	    --add-virtual-file='$(DIST)/REVISION:$(REVISION)' \
	    -o $(BUILD)/$(DIST).tar.gz HEAD

-include $(shell find $(BUILD)/obj $(BUILD)/fuzz/obj -name '*.d' 2>/dev/null)

## clean: remove everything that was built
clean:
	rm -rf build $(BUILD)

## list: this list
list:
	@sed -n 's/^## //p' $(MAKEFILE_LIST)
