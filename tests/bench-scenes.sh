#!/bin/sh
# SPDX-License-Identifier: MIT
# What --scene chooses for the controllers of npm's @webxr-input-profiles/assets
# in a map: a Markdown table of bytes of texels and rendered errors, without
# and with blocks (--pixel bc6h), and how many need an eighth and a twentieth of
# the default's bytes.
#   bench-scenes.sh [BUILD [MAP [FOLDER]]]
#                   build, data/forest.exr, the package's folder
set -eu
build=${1:-build}
map=${2:-data/forest.exr}
scenes=${3:-$build/scenes}
package=@webxr-input-profiles/assets@1.0.20

make -s DEPS=no BUILD="$build" bridge "$build/iblbake"
if [ $# -lt 3 ] && [ ! -d "$scenes/node_modules" ]; then
    mkdir -p "$scenes"
    npm install --no-save --no-package-lock --no-audit --no-fund \
        --ignore-scripts --loglevel=error --prefix "$scenes" "$package"
fi

# scene|bytes error|default's bytes error|bytes error of blocks|limit
choose() {
    for pixel in '' '--pixel bc6h'; do
        # shellcheck disable=SC2086
        "$build/iblbake" --scene "$1" "$map" --dry-run --rendered-error .01 $pixel
    done | awk -v name="$2" -v n=0 '
        /^ *limit / && !n { sub(/.*the least is [^ ]* %  /, ""); limit = $0 }
        /^bytes of texels/ { bytes[n] = $4; if (!n) usual = $5 }
        /^rendered error/ { error[n++] = $3; if (n == 1) least = $5 }
        END {
            printf "%s|%d|%s|%d|%s|%d|%s|%s\n", name, usual, least, bytes[0],
                   error[0], bytes[1], error[1], limit
        }'
}

echo "| scene | bytes | error, % | bc6h: bytes | error, % |" \
    "default: error, % | limit |"
echo '| --- | --- | --- | --- | --- | --- | --- |'
find "$scenes/" -name '*.glb' | sort | while read -r glb; do
    name=${glb#"$scenes"/}
    choose "$glb" "${name##*/profiles/}"
done | tee "$build/scenes.txt" | awk -F '|' '{
    printf "| %s | %d | %s | %d | %s | %s | %s |\n", $1, $4, $5, $6, $7, $3, $8
}'

# The median of a column, and the share of scenes at or below a part of the
# default's bytes.
share() {
    sort -t '|' -n -k "$2" "$build/scenes.txt" | awk -F '|' -v column="$2" \
        -v part="$3" -v name="$1" '
        { bytes[NR] = $column; few += $column * part <= $2 }
        END {
            printf "%s: median %d bytes; at most 1/%d of the default: %d of %d\n",
                   name, bytes[int((NR + 1) / 2)], part, few, NR
        }'
}
echo
share 'any format' 4 8
share bc6h 6 20
