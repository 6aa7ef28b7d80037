/* SPDX-License-Identifier: MIT */
#include "view/room_probes.h"

#include <stdlib.h>
#include <string.h>

#include "view/message.h"
#include "view/program.h"

enum {
    MOST = IBL_MAX_TILE_PROBES,
    DYNAMIC = MOST, /* its place in the buffer, as in room.glsl */
    FLOATS = (MOST + 1) * IBL_PROBE_FLOATS
};

struct view_room_probes {
    GLuint program;
    GLuint buffer, texels; /* what is packed, and the texture of it */
    GLuint none;           /* array of one black cube */
    GLuint masks, framebuffer;
    int columns, rows;       /* of masks */
    int last_size[2];        /* of the last draw's, in tiles */
    int order[MOST];         /* as they come */
    float packed[2][FLOATS]; /* what the buffer has, what it should have */
};

/* ---- what is kept ------------------------------------------------------ */

static void make_buffer(view_room_probes *p)
{
    p->buffer =
        view_gl_buffer(GL_TEXTURE_BUFFER, sizeof p->packed[0], p->packed[0]);
    gl.GenTextures(1, &p->texels);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, p->texels);
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, p->buffer);
}

static void make_none(view_room_probes *p)
{
    static const float black[4 * 6];

    gl.GenTextures(1, &p->none);
    view_gl_bind(VIEW_ROOM_UNIT_LOCALS, GL_TEXTURE_CUBE_MAP_ARRAY, p->none);
    view_gl_filter(GL_TEXTURE_CUBE_MAP_ARRAY, GL_LINEAR, 1);
    gl.TexImage3D(GL_TEXTURE_CUBE_MAP_ARRAY, 0, GL_RGBA16F, 1, 1, 6, 0, GL_RGBA,
                  GL_FLOAT, black);
}

/* Room for a picture's, if there is not yet. */
static void make_masks(view_room_probes *p, int columns, int rows)
{
    if (columns <= p->columns && rows <= p->rows)
        return;
    p->columns = columns > p->columns ? columns : p->columns;
    p->rows = rows > p->rows ? rows : p->rows;
    view_gl_bind(VIEW_ROOM_UNIT_MASKS, GL_TEXTURE_2D, p->masks);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RG32UI, p->columns, p->rows, 0,
                  GL_RG_INTEGER, GL_UNSIGNED_INT, NULL);
}

view_room_probes *view_room_probes_create(void)
{
    view_room_probes *p = calloc(1, sizeof *p);

    if (!p) {
        view_fail("no memory for the room's probes");
        return NULL;
    }
    for (int i = 0; i < MOST; i++)
        p->order[i] = i;
    p->program = view_program("full.vert", "room_tiles.frag");
    gl.GenTextures(1, &p->masks);
    gl.GenFramebuffers(1, &p->framebuffer);
    make_masks(p, 1, 1);
    make_buffer(p);
    make_none(p);
    if (p->program && view_gl_check("making the room's probes"))
        return p;
    view_room_probes_free(p);
    return NULL;
}

void view_room_probes_free(view_room_probes *p)
{
    if (!p)
        return;
    const GLuint textures[] = {p->texels, p->none, p->masks};

    gl.DeleteTextures(3, textures);
    gl.DeleteBuffers(1, &p->buffer);
    gl.DeleteFramebuffers(1, &p->framebuffer);
    gl.DeleteProgram(p->program);
    free(p);
}

/* ---- what a draw is told ----------------------------------------------- */

static bool has_dynamic(const view_room_draw *d)
{
    return d->dynamic.specular && d->dynamic.irradiance;
}

/* Paraboloids are no projection, which is what tiles are culled by. */
static bool has_masks(const view_room_draw *d)
{
    return d->locals.count > 0 && !d->untiled && !d->paraboloid;
}

/* How many local ones come before the dynamic one. */
static int dynamic_place(const view_room_draw *d)
{
    int before = 0, order[2] = {0};

    for (; before < d->locals.count && order[0] == 0; before++) {
        const ibl_probe pair[2] = {d->locals.probe[before], d->dynamic.probe};
        ibl_probes_order(pair, 2, order);
    }
    return order[0] == 0 ? before : before - 1;
}

/* The first count bits. */
static void fill_mask(unsigned mask[2], int count)
{
    for (int word = 0; word < 2; word++) {
        const int bits = count - 32 * word;
        mask[word] = bits >= 32 ? ~0U : bits > 0 ? (1U << bits) - 1 : 0;
    }
}

void view_room_probes_block(view_room_probe_block *b, const view_room_draw *d,
                            const GLint size[2])
{
    const view_room_locals *l = &d->locals;
    const view_room_dynamic *dynamic = &d->dynamic;

    *b = (view_room_probe_block){
        .picture_size = {size[0], size[1], has_masks(d) ? VIEW_ROOM_TILE : 0,
                         l->count},
        .local_lod = {l->lod_scale, l->lod_offset, l->last_level,
                      l->irradiance_scale},
        .dynamic_lod = {dynamic->lod_scale, dynamic->lod_offset,
                        dynamic->last_level, has_dynamic(d)}};
    fill_mask(b->masks, l->count);
    fill_mask(b->masks + 2, has_dynamic(d) ? dynamic_place(d) : l->count);
}

/* ---- what is bound ----------------------------------------------------- */

static void upload(view_room_probes *p, const view_room_draw *d)
{
    static const int first = 0;
    float *wanted = p->packed[1];

    ibl_probes_pack(d->locals.probe, d->locals.count, p->order, wanted);
    ibl_probes_pack(&d->dynamic.probe, 1, &first,
                    wanted + DYNAMIC * IBL_PROBE_FLOATS);
    for (int i = 0; d->sharp && i < FLOATS; i += IBL_PROBE_FLOATS)
        wanted[i + 3] = 0; /* blend */
    if (!memcmp(p->packed[0], wanted, sizeof p->packed[0]))
        return;
    memcpy(p->packed[0], wanted, sizeof p->packed[0]);
    gl.BindBuffer(GL_TEXTURE_BUFFER, p->buffer);
    gl.BufferSubData(GL_TEXTURE_BUFFER, 0, sizeof p->packed[0], wanted);
}

/* A texel for each tile, in a framebuffer of its own. */
static void cull(view_room_probes *p, const GLint viewport[4])
{
    GLint framebuffer;

    p->last_size[0] = (viewport[2] + VIEW_ROOM_TILE - 1) / VIEW_ROOM_TILE;
    p->last_size[1] = (viewport[3] + VIEW_ROOM_TILE - 1) / VIEW_ROOM_TILE;
    make_masks(p, p->last_size[0], p->last_size[1]);
    gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, p->framebuffer);
    gl.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                            GL_TEXTURE_2D, p->masks, 0);
    gl.Viewport(0, 0, p->last_size[0], p->last_size[1]);
    view_gl_draw_full(p->program);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)framebuffer);
    gl.Viewport(viewport[0], viewport[1], viewport[2], viewport[3]);
}

/* Drivers warn about empty samplers, or compile anew when they are filled:
 * unused ones have other cubes. */
void view_room_probes_use(view_room_probes *p, const view_room_draw *d,
                          const GLint viewport[4])
{
    const bool moving = has_dynamic(d), some = d->locals.count > 0;
    const view_room_environment *e = &d->environment;

    upload(p, d);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, p->texels);
    if (has_masks(d))
        cull(p, viewport);
    view_gl_bind(VIEW_ROOM_UNIT_DYNAMIC, GL_TEXTURE_CUBE_MAP,
                 moving ? d->dynamic.specular : e->specular);
    view_gl_bind(VIEW_ROOM_UNIT_DYNAMIC + 1, GL_TEXTURE_CUBE_MAP,
                 moving ? d->dynamic.irradiance : e->irradiance);
    view_gl_bind(VIEW_ROOM_UNIT_LOCALS, GL_TEXTURE_CUBE_MAP_ARRAY,
                 some ? d->locals.specular : p->none);
    view_gl_bind(VIEW_ROOM_UNIT_LOCALS + 1, GL_TEXTURE_CUBE_MAP_ARRAY,
                 some ? d->locals.irradiance : p->none);
    view_gl_bind(VIEW_ROOM_UNIT_MASKS, GL_TEXTURE_2D, p->masks);
}

GLuint view_room_probes_masks(const view_room_probes *p, int *columns,
                              int *rows)
{
    *columns = p->last_size[0];
    *rows = p->last_size[1];
    return p->masks;
}
