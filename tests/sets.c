/* SPDX-License-Identifier: MIT */
#include "sets.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "maps.h"
#include "textures.h"
#include "truth.h"
#include "view.h"

ibl_image sets_map(ibl_ctx *ctx, int width, double sun)
{
    const int height = width / 2;
    ibl_image map = map_constant(ctx, width, height, 0.1F);

    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            double d[3];
            truth_latlong_direction(width, height, x, y, d);
            map_set(&map, x, y, (float)(1 + 0.5 * d[1] + 0.2 * d[0]),
                    (float)(1 + 0.4 * d[1] * d[2]),
                    (float)(1.5 - 0.7 * d[2] + 0.3 * d[0] * d[1]));
        }
    }
    if (sun > 0)
        map_set(&map, width / 5, height / 4, (float)sun, (float)sun,
                (float)(sun / 2));
    return map;
}

static void free_set(void *set)
{
    view_set_free(set);
}

bool sets_bake_image(ibl_ctx *ctx, const char *name, const ibl_image *map,
                     const ibl_specular_options *opts, baked_set *set)
{
    const ibl_environment env = {.image = map};

    *set = (baked_set){.baked.name = strdup(name)};
    return view_set_bake_environment(ctx, &env, opts, set);
}

void sets_white(baked_set *set)
{
    ibl_ctx *ctx = view_test_ctx(1);
    ibl_image map = map_constant(ctx, 8, 4, 1);
    ibl_specular_options opts = ibl_specular_options_default();

    opts.size = 16;
    opts.levels = 3;
    NEED(sets_bake_image(ctx, "map", &map, &opts, set));
    test_defer(free_set, set);
}

const char *sets_file(void)
{
    static char path[512];

    if (*path)
        return path;
    snprintf(path, sizeof path, "%s/sky.exr", test_dir());
    const ibl_image map = sets_map(view_test_ctx(2), 64, 60);
    if (!file_save_exr(path, &map, NULL)) {
        printf("%s: cannot be written\n", path);
        exit(1);
    }
    return path;
}

bool sets_bake(const char *directory, const char *options)
{
    static const char *const alone[] = {"--only", "env ", "gltf ",
                                        "playcanvas "};
    const char *others = "--irradiance-size 8 --lut-size 16";

    /* Sizes of what is not made are refused. */
    for (int i = 0; i < 4; i++)
        if (strstr(options, alone[i]))
            others = "";
    return file_run("'%s' -q '%s' --size 32 %s -o %s %s", file_built("iblbake"),
                    sets_file(), others, directory, options);
}

const char *sets_open(ibl_ctx *ctx, const char *name, baked_set *set)
{
    const view_request what = {.path = file_path(name)};

    view_test_catch();
    const bool ok = view_set_open(ctx, &what, set);
    const char *said = view_test_caught();
    CHECK_MSG(ok, "%s: %s", name, said);
    if (!ok)
        test_leave();
    test_defer_copy(free_set, set, sizeof *set);
    return said;
}

int sets_lines(const char *text)
{
    int count = 0;
    for (; *text; text++)
        count += *text == '\n';
    return count;
}

void sets_check_same(const baked_set *a, const baked_set *b, const char *what)
{
    const ibl_set_facts *p = &a->baked.file[IBL_CONTENT_SPECULAR].facts;
    const ibl_set_facts *q = &b->baked.file[IBL_CONTENT_SPECULAR].facts;

    for (int i = 0; i < IBL_CONTENTS; i++) {
        const ibl_set_file *f = &a->baked.file[i], *g = &b->baked.file[i];
        const ibl_texture *s = &f->texture, *t = &g->texture;
        CHECK_MSG(s->pixel == t->pixel && s->width == t->width &&
                      s->levels == t->levels && s->bytes == t->bytes &&
                      (!s->bytes || !memcmp(s->data, t->data, s->bytes)),
                  "%s: texture %d is another", what, i);
        CHECK_MSG(f->facts.geometry == g->facts.geometry &&
                      (i != IBL_CONTENT_IRRADIANCE ||
                       f->facts.irradiance_scale == g->facts.irradiance_scale),
                  "%s: facts of %d differ", what, i);
    }
    CHECK_MSG(!strcmp(a->baked.name, b->baked.name) &&
                  p->mapping == q->mapping && p->lobe == q->lobe &&
                  p->levels == q->levels && a->sh_degree == b->sh_degree,
              "%s: facts differ", what);
    CHECK_NEAR(p->lod_scale, q->lod_scale, 1e-7);
    CHECK_NEAR(p->lod_offset, q->lod_offset, 1e-7);
    for (int l = 0; l < p->levels; l++)
        CHECK_NEAR(p->roughness[l], q->roughness[l], 1e-8);
    for (int i = 0; i < 3 * (a->sh_degree + 1) * (a->sh_degree + 1); i++)
        CHECK_NEAR(a->sh[i], b->sh[i], 1e-12);
}

ibl_image sets_read_map(ibl_ctx *ctx)
{
    ibl_image map = {0};
    if (ibl_image_read(ctx, sets_file(), NULL, &map, NULL))
        exit(1);
    return test_image(map);
}

void sets_check_refused(ibl_ctx *ctx, const view_request *what,
                        const char *file, const char *words)
{
    baked_set set, zero;

    memset(&set, 1, sizeof set);
    memset(&zero, 0, sizeof zero);
    view_test_catch();
    const bool ok = view_set_open(ctx, what, &set);
    const char *said = view_test_caught();
    const char *line = said;
    int errors = 0;
    for (; *line; line = strchr(line, '\n') + 1)
        errors += strncmp(line, "iblview: note: ", 15) != 0;
    CHECK_MSG(!ok && errors == 1 && strstr(said, words) && strstr(said, file),
              "%s: wanted one line with \"%s\" and \"%s\", got %d: %s",
              what->path, file, words, ok, said);
    CHECK(!memcmp(&set, &zero, sizeof set));
    if (ok)
        view_set_free(&set);
}

void sets_refused(ibl_ctx *ctx, const char *path, const char *words)
{
    const view_request what = {.path = path};
    sets_check_refused(ctx, &what, path, words);
}
