#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs the Debian packages that a step needs and that are missing.
#   deps.sh build    what compiling needs
#   deps.sh check    what the tests need besides
#   deps.sh bench    what comparing with other programs needs besides
#   deps.sh deb      what Debian's packages need besides build, and their test
#   deps.sh windows  what the program for Windows needs, and its test
#   deps.sh npm      what the package of npm needs
#   deps.sh page     what the page needs besides, and the tests of both
#   deps.sh arm64    what the test on aarch64 needs besides build
#   deps.sh name     names those of build, and fails if any is missing
# DEPS=no: does nothing; the compiler or the test says what it misses.
set -eu

build='
gcc:C_compiler
g++:C++_compiler_of_the_bridges
libc6-dev:C_library
make:make
pkg-config:finds_the_libraries
libopenexr-dev:reads_EXR
libdeflate-dev:inflates_EXR
libzstd-dev:supercompresses_KTX2
libopenimageio-dev:image_bridge,_reads_other_formats
libpng-dev:writes_previews,_reads_textures_of_models
libjpeg-dev:reads_textures_of_models
libwebp-dev:reads_WebP_of_models
libmeshoptimizer-dev:reads_models_that_it_packed
libdraco-dev:reads_models_that_it_packed
libjansson-dev:reads_and_writes_JSON
libxxhash-dev:tells_probes_that_changed
libglfw3-dev:window_of_the_viewer
libgl-dev:its_OpenGL
libimgui-dev:its_controls
fonts-dejavu-core:its_letters
libosmesa6:its_pictures_without_a_display
'
case ${CC:-cc} in
clang*) build="$build clang:C_compiler_asked_for libclang-rt-dev:sanitizers" ;;
esac
check="$build"'
clang:second_compiler
libclang-rt-dev:sanitizers_of_clang
lld:links_what_it_compiles
clang-format:make_lint
mandoc:make_lint
cmake:tests_the_CMake_example
glslang-tools:reads_the_shaders
spirv-cross:turns_HLSL_into_GLSL
man-db:tests_the_manual
file:recognises_containers
openimageio-tools:makes_test_images
libjpeg-turbo-progs:makes_a_JPEG
assimp-testmodels:models_by_others
astcenc:decodes_ASTC
nodejs:runs_the_KTX_reader
npm:fetches_the_KTX_reader
chromium:runs_the_engines_of_check-clients
procps:finds_what_runs_on
slurm-wlm:a_cluster_of_one_machine
munge:its_authentication
parallel:runs_an_example_of_the_manual
time:measures_in_another
xvfb:display_of_the_window_test
xdotool:presses_its_keys
libx11-dev:drops_files_on_it
'
bench="$check"'
libfilament-tools:cmgen_to_compare_with
gnuplot-nox:draws_the_plot_of_MEASURED
'
deb="$build"'
debhelper:builds_packages
dpkg-dev:the_same
lintian:looks_at_them
debootstrap:a_root_to_install_them_in
'
windows='
make:make
gcc-mingw-w64-x86-64-posix:C_compiler_for_Windows
dpkg-dev:unpacks_the_sources_of_libraries
mandoc:manuals_as_pages
zip:packs_it
unzip:its_test
wine:runs_it
wine64:the_same
nodejs:its_test
'
npm='
make:make
emscripten:compiles_to_WebAssembly
clang:its_compiler
dpkg-dev:unpacks_sources_of_libraries
nodejs:runs_the_package
npm:packs_it
'
page="$npm"'
brotli:measures_the_package
chromium:shows_the_page
openimageio-tools:makes_test_images
'
arm64="$build"'
gcc-aarch64-linux-gnu:compiles_for_aarch64
qemu-user:runs_that
'

case ${1:-} in
build | name) wanted=$build ;;
npm) wanted=$npm ;;
page) wanted=$page ;;
arm64) wanted=$arm64 ;;
check) wanted=$check ;;
bench) wanted=$bench ;;
deb) wanted=$deb ;;
windows) wanted=$windows ;;
*) echo 'usage: deps.sh build|check|bench|deb|windows|npm|page|arm64|name' >&2; exit 2 ;;
esac
[ "${DEPS:-yes}" != no ] || exit 0
command -v dpkg-query >/dev/null 2>&1 || {
    echo 'deps: no dpkg here: install the packages of tests/deps.sh by hand' >&2
    exit 0
}

missing=
for entry in $wanted; do
    package=${entry%%:*}
    # Node.js often comes from elsewhere than Debian.
    case $package in
    nodejs) command -v node >/dev/null 2>&1 && continue ;;
    npm) command -v npm >/dev/null 2>&1 && continue ;;
    esac
    # A line for each architecture that it is known for.
    dpkg-query -W -f '${db:Status-Status}\n' "$package" 2>/dev/null |
        grep -qx installed && continue
    echo "deps: $package is missing ($(echo "${entry#*:}" | tr _ ' '))"
    missing="$missing $package"
done
[ -n "$missing" ] || exit 0
[ "$1" != name ] || {
    echo 'deps: "make deps" installs what is missing;' \
        '"make DEPS=no" builds with what is there' >&2
    exit 1
}

sudo=
if [ "$(id -u)" != 0 ]; then
    sudo=sudo
    command -v sudo >/dev/null 2>&1 || {
        echo "deps: there is no sudo to install them with; as root run" >&2
        echo "    apt-get install$missing" >&2
        echo 'or build with what is there: DEPS=no' >&2
        exit 1
    }
fi
echo "deps: installing$missing (DEPS=no turns this off)"
export DEBIAN_FRONTEND=noninteractive
$sudo apt-get update -qq
# shellcheck disable=SC2086
$sudo apt-get install -y -qq --no-install-recommends $missing >/dev/null
