/* SPDX-License-Identifier: MIT */
/* --shard K/N: a part of the work of one command, for N runs on any machines.
 */
#ifndef CLI_SHARD_H
#define CLI_SHARD_H

#include <stdbool.h>

enum {
    IBL_MOST_SHARDS = 65536
};
#define IBL_SHARD_ALLOWED "1/1 to 65536/65536, K at most N"

typedef struct ibl_shard {
    int number; /* 1..count */
    int count;  /* 0: no --shard was given */
} ibl_shard;

/* Parses "K/N" into an ibl_shard. */
bool ibl_shard_parse(void *shard, const char *value);

/* Whether a shard has item i of a command: every count-th, from the number-th
 * on; all without --shard. */
bool ibl_shard_has(const ibl_shard *shard, int i);

#endif
