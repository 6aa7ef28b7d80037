/* SPDX-License-Identifier: MIT */
#include "cli/shard.h"

#include "common/option.h"

bool ibl_shard_parse(void *shard, const char *value)
{
    ibl_shard s;
    const char *end;

    if (!ibl_number_int(value, 1, IBL_MOST_SHARDS, &s.number, &end) ||
        *end != '/' ||
        !ibl_number_int(end + 1, s.number, IBL_MOST_SHARDS, &s.count, &end) ||
        *end)
        return false;
    *(ibl_shard *)shard = s;
    return true;
}

bool ibl_shard_has(const ibl_shard *shard, int i)
{
    return !shard->count || i % shard->count + 1 == shard->number;
}
