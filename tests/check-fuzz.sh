#!/bin/bash
# SPDX-License-Identifier: MIT
# Seeds, finds of before and three seconds of random inputs for each harness of
# tests/fuzz, from the same seed: what `make fuzz` does for hours.
. tests/lib.sh

programs=$(ls "$build"/fuzz/fuzz_* 2>/dev/null)
[ -n "$programs" ] || skip_all 'no harnesses: make fuzzers'
for program in $programs; do
    harness=${program##*/fuzz_}
    picked "$harness" || continue
    ok "$harness" env SEED=1 bash tests/fuzz/run.sh "$build" "${TIME:-3}" \
        "$harness"
done
end
