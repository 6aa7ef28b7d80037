#!/bin/bash
# SPDX-License-Identifier: MIT
if BUILD=${BUILD:-build} sh tests/lint.sh; then
    echo '1 passed, 0 failed'
else
    echo '0 passed, 1 failed'
    exit 1
fi
