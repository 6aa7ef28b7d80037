/* SPDX-License-Identifier: MIT */
/* Scenes of glTF and GLB: what is read must be safe to draw. */
#include <math.h>

#include "fuzz.h"
#include "scene/survey.h"

/* A buffer beside the scene, which seeds name: three vertices and indices. */
void fuzz_begin(void)
{
    static const struct {
        float position[9], texcoord[6];
        uint16_t index[4];
    } buffer = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 0, 1}, {0, 1, 2, 0}};

    fuzz_save("b.bin", &buffer, sizeof buffer);
}

static void check_texture(const ibl_scene *s, const ibl_scene_texture *t)
{
    FUZZ_NEED(t->image >= -1 && t->image < s->image_count);
    FUZZ_NEED(t->texcoord >= 0 && t->texcoord < IBL_SCENE_TEXCOORDS);
}

static void check_scene(const ibl_scene *s)
{
    FUZZ_NEED(s->material_count >= 1 && s->file_count >= 1);
    for (int i = 0; i < s->draw_count; i++)
        FUZZ_NEED(s->draws[i].primitive >= 0 &&
                  s->draws[i].primitive < s->primitive_count);
    for (int i = 0; i < s->primitive_count; i++) {
        const ibl_scene_primitive *p = &s->primitives[i];
        FUZZ_NEED(p->material >= 0 && p->material < s->material_count);
        FUZZ_NEED(p->index_count % 3 == 0);
        FUZZ_NEED(p->index_count > 0 && p->normal && !p->joints[0]);
        for (uint32_t k = 0; k < p->index_count; k++)
            FUZZ_NEED(p->index[k] < p->vertex_count);
        for (uint32_t k = 0; k < 3 * p->vertex_count; k++)
            FUZZ_NEED(isfinite(p->position[k]));
    }
    for (int i = 0; i < s->material_count; i++) {
        check_texture(s, &s->materials[i].base_colour_texture);
        check_texture(s, &s->materials[i].transmission_texture);
    }
}

void fuzz_one(fuzz_input in)
{
    const int choice = fuzz_choice(&in, 64);
    const bool survey = choice % 32 == 0, strict = choice / 32;
    ibl_scene_survey sum = {.scenes = 0};
    ibl_scene scene;

    const ibl_status status = ibl_scene_read(
        fuzz_ctx, fuzz_save("s.gltf", in.bytes, in.size), strict, &scene);
    fuzz_said(status);
    if (!status)
        check_scene(&scene);
    if (!status && survey)
        fuzz_said(ibl_scene_survey_add(fuzz_ctx, &scene, &sum));
    ibl_scene_free(&scene);
}
