/* SPDX-License-Identifier: MIT */
#include "cli/judge.h"

#include <string.h>

static bool take_lights(ibl_ctx *ctx, int most, ibl_judged_map *map)
{
    const ibl_image *env = &map->env;

    if (ibl_image_alloc(ctx, env->width, env->height, &map->rest))
        return false;
    memcpy(map->rest.data, env->data,
           3 * sizeof *env->data * (size_t)env->width * (size_t)env->height);
    return !ibl_image_take_lights(ctx, &map->rest, map->yaw_deg, most,
                                  map->lights, &map->light_count);
}

size_t ibl_judged_map_bytes(const ibl_source *source, int most)
{
    const size_t pixels =
        (size_t)ibl_source_width(source) * (size_t)ibl_source_height(source);

    return ibl_source_memory(source) +
           pixels * 3 * sizeof(float) * (most > 0 ? 2 : 1);
}

bool ibl_judged_map_read(ibl_ctx *ctx, ibl_source *source, double yaw_deg,
                         int most, ibl_judged_map *map)
{
    *map = (ibl_judged_map){.yaw_deg = yaw_deg};
    return !ibl_source_image(source, &map->env) &&
           (most <= 0 || take_lights(ctx, most, map));
}

bool ibl_judged_map_prepare(ibl_ctx *ctx, const ibl_judge_options *opts,
                            ibl_judged_map *map)
{
    map->by_env = ibl_judge_create(ctx, &map->env, map->yaw_deg, opts);
    if (map->rest.data)
        map->by_rest = ibl_judge_create(ctx, &map->rest, map->yaw_deg, opts);
    return map->by_env && (map->by_rest || !map->rest.data);
}

void ibl_judged_map_free(ibl_judged_map *map)
{
    ibl_judge_free(map->by_env);
    ibl_judge_free(map->by_rest);
    ibl_image_free(&map->env);
    ibl_image_free(&map->rest);
    *map = (ibl_judged_map){0};
}

const ibl_image *ibl_judged_map_rest(const ibl_judged_map *map)
{
    return map->rest.data ? &map->rest : &map->env;
}

ibl_judge *ibl_judged_map_judge(const ibl_judged_map *map, ibl_output_kind kind)
{
    return map->by_rest && kind != IBL_OUTPUT_SKYBOX ? map->by_rest
                                                     : map->by_env;
}
