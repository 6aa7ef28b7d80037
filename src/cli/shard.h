/* SPDX-License-Identifier: MIT */
/* --shard K/N: a part of the work of one command, for N runs on any machines.
 */
#ifndef CLI_SHARD_H
#define CLI_SHARD_H

#include <stdbool.h>
#include <stdint.h>

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

/* Deals items to shards: the largest first, each to the shard with the fewest
 * pixels so far, of equals to the first. owner gets the number of each item's
 * shard, from 1. False: no memory. */
bool ibl_shard_deal(const uint64_t *pixels, int count, int shards, int *owner);

#endif
