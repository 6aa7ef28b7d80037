/* SPDX-License-Identifier: MIT */
/*
 * A round matte ground below a model, which takes its shadows: of the set's
 * main light by a map of depth, and of the rest of the sky, as if that were
 * even, by another from below, whose texels are patches that hide it.
 * shaders/sky.frag draws it with what is behind the model: seen from above, the
 * model is before all of it.
 */
#ifndef VIEW_GROUND_H
#define VIEW_GROUND_H

#include "view/frame.h"
#include "view/model.h"

/* Half the width of the maps, whose edges are free of the model; GROUND of
 * shaders. */
#define VIEW_GROUND_HALF 1.02

typedef struct view_ground {
    GLuint framebuffer, depth[2]; /* from the light, from below */
    bool known;                   /* whether light is that of the set */
    ibl_light light;              /* irradiance 0: there is none */
} view_ground;

/* Finds the main light of a set: the first that was taken out of it, or would
 * be out of its map, if that is at hand (ibl_image_take_lights). */
void view_ground_load(view_ground *g, const baked_set *set);
/* Fills the members of the frame. */
void view_ground_fill(const view_ground *g, const view_settings *s,
                      const baked_set *set, const view_model *model,
                      view_frame *f);
/* Draws the maps of depth for a frame, and binds them; changes viewport,
 * framebuffer and the block "Frame". False, with a message. */
bool view_ground_draw(view_ground *g, const view_frame *f, view_model *model);

#endif
