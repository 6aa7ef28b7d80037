/* SPDX-License-Identifier: MIT */
#include "cli/shard.h"

#include <stdlib.h>

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

typedef struct item {
    uint64_t pixels;
    int index;
} item;

static int compare(const void *a, const void *b)
{
    const item *x = a, *y = b;

    return x->pixels != y->pixels
               ? (x->pixels < y->pixels ? 1 : -1)
               : (x->index > y->index) - (x->index < y->index);
}

bool ibl_shard_deal(const uint64_t *pixels, int count, int shards, int *owner)
{
    item *order = malloc((size_t)count * sizeof *order);
    uint64_t *load = calloc((size_t)shards, sizeof *load);
    const bool ok = order && load;

    for (int i = 0; i < count && ok; i++)
        order[i] = (item){pixels[i], i};
    if (ok)
        qsort(order, (size_t)count, sizeof *order, compare);
    for (int i = 0; i < count && ok; i++) {
        int least = 0;
        for (int s = 1; s < shards; s++)
            if (load[s] < load[least])
                least = s;
        load[least] += order[i].pixels;
        owner[order[i].index] = least + 1;
    }
    free(order);
    free(load);
    return ok;
}
