/* SPDX-License-Identifier: MIT */
#include "cli/judge_picks.h"

#include <math.h>
#include <stdlib.h>

#include "cli/faces.h"
#include "cli/lookup.h"

enum {
    BLOCKS = 32 /* along a row of the map; half as many along a column */
};

/* Kinds of texels; REST is split by the cells of a grid. */
typedef enum kind {
    LIGHT,
    CORNER,
    NEAR,
    EDGE,
    DARK,
    REST,
    KINDS
} kind;

/* ---- the brightest pixels -------------------------------------------- */

typedef struct pixel {
    float value; /* R + G + B */
    int x, y;
} pixel;

/* Direction of a pixel by ibl/ibl.h's convention, turned about +Y. */
static void pixel_direction(const ibl_image *env, double yaw_deg, pixel at,
                            double dir[3])
{
    const double phi =
        ((at.x + 0.5) / env->width - 0.5) * 2 * M_PI - yaw_deg * M_PI / 180;
    const double theta = M_PI * (at.y + 0.5) / env->height;
    dir[0] = sin(theta) * cos(phi);
    dir[1] = cos(theta);
    dir[2] = sin(theta) * sin(phi);
}

/* Finds the brightest pixel of each block. Blocks without pixels, in a small
 * map, keep a value below 0. */
static void find_brightest(const ibl_image *env,
                           pixel blocks[BLOCKS / 2][BLOCKS])
{
    const int columns = env->width < BLOCKS ? env->width : BLOCKS;
    const int rows = env->height < BLOCKS / 2 ? env->height : BLOCKS / 2;
    const float *p = env->data;

    for (int b = 0; b < BLOCKS * BLOCKS / 2; b++)
        blocks[b / BLOCKS][b % BLOCKS].value = -1;
    for (long long y = 0; y < env->height; y++)
        for (long long x = 0; x < env->width; x++, p += 3) {
            pixel *best = &blocks[((y + 1) * rows - 1) / env->height]
                                 [((x + 1) * columns - 1) / env->width];
            const float value = p[0] + p[1] + p[2];
            if (value > best->value)
                *best = (pixel){value, (int)x, (int)y};
        }
}

static bool is_far(const double dir[3], double dirs[][3], int count)
{
    for (int i = 0; i < count; i++)
        if (dir[0] * dirs[i][0] + dir[1] * dirs[i][1] + dir[2] * dirs[i][2] >
            cos(10 * M_PI / 180))
            return false;
    return true;
}

int ibl_find_lights(const ibl_image *env, double yaw_deg, int most,
                    double dirs[][3])
{
    pixel grid[BLOCKS / 2][BLOCKS], *const blocks = grid[0];
    int count = 0;

    find_brightest(env, grid);
    while (count < most) {
        pixel *best = NULL;
        double dir[3];
        for (int b = 0; b < BLOCKS * BLOCKS / 2; b++)
            if (blocks[b].value >= 0 &&
                (!best || blocks[b].value > best->value))
                best = &blocks[b];
        if (!best)
            break;
        pixel_direction(env, yaw_deg, *best, dir);
        best->value = -1;
        if (!is_far(dir, dirs, count))
            continue;
        for (int k = 0; k < 3; k++)
            dirs[count][k] = dir[k];
        count++;
    }
    return count;
}

/* ---- kinds ----------------------------------------------------------- */

/* A group of texels; `quota` members are chosen, evenly and at random. */
typedef struct stratum {
    size_t members, quota;
    size_t seen, taken;
} stratum;

typedef struct picker {
    const ibl_pick_scene *scene;
    ibl_level_shape shape;
    int grid; /* cells along an edge for REST */
    int light_count;
    ibl_texel lights[IBL_JUDGE_LIGHTS];
    stratum *strata; /* one for each kind before REST, then one for each cell */
} picker;

static size_t cell_of(const picker *p, ibl_texel t, int grid)
{
    const long long i = t.x, j = t.y;
    const size_t x = (size_t)(i * grid / p->shape.width);
    const size_t y = (size_t)(j * grid / p->shape.height);
    return ((size_t)t.face * (size_t)grid + y) * (size_t)grid + x;
}

static bool is_near(const picker *p, ibl_texel t)
{
    const double *l = p->scene->lights[0];
    double d[3];

    ibl_level_direction(&p->shape, t.face, t.x, t.y, d);
    return d[0] * l[0] + d[1] * l[1] + d[2] * l[2] > cos(20 * M_PI / 180);
}

static kind kind_of(const picker *p, ibl_texel t)
{
    const bool x_edge = t.x == 0 || t.x == p->shape.width - 1;
    const bool y_edge = t.y == 0 || t.y == p->shape.height - 1;

    for (int i = 0; i < p->light_count; i++)
        if (t.face == p->lights[i].face && abs(t.x - p->lights[i].x) <= 1 &&
            abs(t.y - p->lights[i].y) <= 1)
            return LIGHT;
    if (x_edge && y_edge)
        return CORNER;
    if (is_near(p, t))
        return NEAR;
    if (x_edge || y_edge)
        return EDGE;
    return p->scene->dark[cell_of(p, t, IBL_DARK_CELLS)] ? DARK : REST;
}

/* ---- the choice ------------------------------------------------------ */

static ibl_texel texel_at(const picker *p, size_t i)
{
    const size_t w = (size_t)p->shape.width, h = (size_t)p->shape.height;
    return (ibl_texel){(int)(i / (w * h)), (int)(i % w), (int)(i / w % h)};
}

static size_t stratum_of(const picker *p, ibl_texel t)
{
    const kind k = kind_of(p, t);
    return k == REST ? REST + cell_of(p, t, p->grid) : k;
}

static void set_grid(picker *p, const ibl_judge_options *opts)
{
    const int lights = opts->texels / 36, known = p->scene->light_count;

    p->light_count = lights < 1 ? 1 : lights < known ? lights : known;
    for (int i = 0; i < p->light_count; i++)
        p->lights[i] = ibl_level_hit(&p->shape, p->scene->lights[i]);
    const double rest = fmax(6, opts->texels - 9.0 * p->light_count - 24 -
                                    3.0 * (opts->texels / 8));
    p->grid = (int)sqrt(rest / p->shape.faces + 0.5);
    if (p->grid < opts->grid)
        p->grid = opts->grid;
    if (p->grid > p->shape.height)
        p->grid = p->shape.height;
}

/* Sets how many texels of each stratum are chosen; returns the sum. */
static size_t set_quotas(const picker *p, const ibl_judge_options *opts,
                         size_t texels, size_t cells)
{
    const bool all =
        opts->all || texels <= (size_t)opts->texels || texels <= cells;
    size_t sum = 0;

    for (size_t i = 0; i < REST + cells; i++) {
        stratum *s = &p->strata[i];
        s->quota = i >= REST ? 1 : (size_t)opts->texels / 8;
        if (all || i == LIGHT || i == CORNER || s->quota > s->members)
            s->quota = s->members;
        sum += s->quota;
    }
    return sum;
}

/* Whether the next member of a stratum is chosen. The members form `quota`
 * equal stretches; one random member of each is chosen. */
static bool is_chosen(stratum *s, size_t index, int seed)
{
    const size_t seen = s->seen++;

    if (s->taken == s->quota)
        return false;
    const double stretch = (double)s->members / (double)s->quota;
    const double u = index < REST ? ibl_pick_random(seed, index, s->taken)
                                  : ibl_pick_random(seed, KINDS, index - REST);
    const double i = (double)s->taken;
    if ((double)seen < fmax(floor((i + u) * stretch), ceil(i * stretch)))
        return false;
    s->taken++;
    return true;
}

bool ibl_picks(const ibl_pick_scene *scene, const ibl_judge_options *opts,
               ibl_judged_texel **list, size_t *count)
{
    picker p = {.scene = scene, .shape = scene->shape};
    const size_t images = (size_t)p.shape.faces;
    const size_t texels =
        images * (size_t)p.shape.width * (size_t)p.shape.height;

    set_grid(&p, opts);
    const size_t cells = images * (size_t)p.grid * (size_t)p.grid;
    p.strata = calloc(REST + cells, sizeof *p.strata);
    if (!p.strata)
        return false;
    for (size_t i = 0; i < texels; i++)
        p.strata[stratum_of(&p, texel_at(&p, i))].members++;
    *list = malloc(set_quotas(&p, opts, texels, cells) * sizeof **list);
    *count = 0;
    for (size_t i = 0; i < texels && *list; i++) {
        const ibl_texel t = texel_at(&p, i);
        const size_t index = stratum_of(&p, t);
        stratum *s = &p.strata[index];
        if (is_chosen(s, index, opts->seed))
            (*list)[(*count)++] = (ibl_judged_texel){
                .at = t, .weight = (double)s->members / (double)s->quota};
    }
    free(p.strata);
    return *list;
}
