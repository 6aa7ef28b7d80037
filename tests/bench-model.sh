#!/bin/bash
# SPDX-License-Identifier: MIT
# The error of models as the viewer draws them with the sets that
# `iblbake --scene` chooses, beside the one that it states: a Markdown table.
#   bench-model.sh BUILD MAP... -- MODEL...
# PICTURES, COPIES, EDGE and SAMPLES are those of tests/bench_model.c.
set -eu
build=$1
shift
maps=()
while [ "$1" != -- ]; do
    maps+=("$1")
    shift
done
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
echo '| model | map | stated, % | measured, % | ratio |'
echo '| --- | --- | --- | --- | --- |'
for model; do
    for map in "${maps[@]}"; do
        rm -rf "${work:?}"/*
        stated=$("$build/iblbake" --scene "$model" "$map" -o "$work/set" |
            awk '/^rendered error/ { print $3 }')
        "$build/tests/bench_model" "$work/set" "$model" ${PICTURES:-48} \
            ${COPIES:-16} ${EDGE:-32} ${SAMPLES:-64} 2>"$work/log" |
            awk -v name="$(basename "$(dirname "$model")")/${model##*/}" \
                -v map="${map##*/}" -v stated="$stated" '{
                    printf "| %s | %s | %.2f | %.2f +- %.2f | %.2f |\n", name,
                        map, stated, $1, $3, $1 / stated
                }'
        [ "${PIPESTATUS[0]}" -eq 0 ] || cat "$work/log" >&2
    done
done
