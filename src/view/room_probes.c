/* SPDX-License-Identifier: MIT */
#include "view/room_parts.h"

#include "view/program.h"

enum {
    MOST = IBL_INDEX_PROBES,
    FLOATS = (MOST + 1) * IBL_PROBE_FLOATS /* the dynamic one is the last */
};

/* ---- resources --------------------------------------------------------- */

static void make_buffer(view_room_probes *p)
{
    p->buffer = view_gl_buffer(GL_TEXTURE_BUFFER, FLOATS * sizeof(float), NULL);
    gl.GenTextures(1, &p->texels);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, p->texels);
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, p->buffer);
}

static void make_black(view_room_probes *p)
{
    static const float black[4 * 6];

    gl.GenTextures(1, &p->none);
    view_gl_bind(VIEW_ROOM_UNIT_LOCALS, GL_TEXTURE_CUBE_MAP_ARRAY, p->none);
    view_gl_filter(GL_TEXTURE_CUBE_MAP_ARRAY, GL_LINEAR, 1);
    gl.TexImage3D(GL_TEXTURE_CUBE_MAP_ARRAY, 0, GL_RGBA16F, 1, 1, 6, 0, GL_RGBA,
                  GL_FLOAT, black);
}

/* Enlarges the texture of masks if it is too small. */
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

bool view_room_probes_make(view_room_probes *p)
{
    p->program = view_program("full.vert", "room_tiles.frag");
    gl.GenTextures(1, &p->masks);
    gl.GenFramebuffers(1, &p->framebuffer);
    make_masks(p, 1, 1);
    make_buffer(p);
    make_black(p);
    return p->program;
}

void view_room_probes_free(view_room_probes *p)
{
    const GLuint textures[] = {p->texels, p->none, p->masks};

    gl.DeleteTextures(3, textures);
    gl.DeleteBuffers(1, &p->buffer);
    gl.DeleteFramebuffers(1, &p->framebuffer);
    gl.DeleteProgram(p->program);
}

/* ---- uniforms ---------------------------------------------------------- */

/* Tiles along an edge of the picture. */
static int tiles_of(int pixels)
{
    return (pixels + VIEW_ROOM_TILE - 1) / VIEW_ROOM_TILE;
}

/* Culling of tiles needs a projection; a paraboloid is none. */
static bool has_masks(const view_room_draw *d)
{
    return d->locals.count > 0 && !d->untiled && !d->paraboloid;
}

/* Number of local probes that come before the dynamic one. */
static int dynamic_place(const view_room_draw *d)
{
    int before = 0, order[2] = {0};

    for (; before < d->locals.count && d->dynamic.count; before++) {
        const ibl_probe pair[2] = {d->locals.probe[before], *d->dynamic.probe};
        ibl_probes_order(pair, 2, order);
        if (order[0] == 1)
            break;
    }
    return before;
}

static void fill_lod(float lod[4], const view_probe_maps *m)
{
    lod[0] = m->lod_scale;
    lod[1] = m->lod_offset;
    lod[2] = m->last_level;
    lod[3] = m->filament;
}

void view_room_probes_block(view_room_probe_block *b, const view_room_draw *d,
                            const GLint size[2])
{
    *b = (view_room_probe_block){
        .picture_size = {size[0], size[1], has_masks(d) ? VIEW_ROOM_TILE : 0,
                         d->locals.count},
        .order = {dynamic_place(d), tiles_of(size[1])},
        .scales = {d->locals.irradiance_scale, d->dynamic.irradiance_scale,
                   (float)d->dynamic.count}};
    fill_lod(b->local_lod, &d->locals);
    fill_lod(b->dynamic_lod, &d->dynamic);
}

/* ---- bindings ---------------------------------------------------------- */

static void upload(view_room_probes *p, const view_room_draw *d)
{
    float packed[FLOATS] = {0};
    int order[MOST]; /* as they are */

    for (int i = 0; i < MOST; i++)
        order[i] = i;
    ibl_probes_pack(d->locals.probe, d->locals.count, order, packed);
    ibl_probes_pack(d->dynamic.probe, d->dynamic.count, order,
                    packed + d->locals.count * IBL_PROBE_FLOATS);
    for (int i = 0; d->sharp && i < FLOATS; i += IBL_PROBE_FLOATS)
        packed[i + 3] = 0; /* blend */
    gl.BindBuffer(GL_TEXTURE_BUFFER, p->buffer);
    gl.BufferSubData(GL_TEXTURE_BUFFER, 0, sizeof packed, packed);
}

/* Renders masks, a texel per tile and 64 probes, into p->framebuffer. */
static void cull(view_room_probes *p, const view_room_draw *d,
                 const GLint size[2])
{
    const int groups = (d->locals.count + 63) / 64;
    const int columns = tiles_of(size[0]), rows = groups * tiles_of(size[1]);

    make_masks(p, columns, rows);
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, p->framebuffer);
    gl.FramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                            GL_TEXTURE_2D, p->masks, 0);
    gl.Viewport(0, 0, columns, rows);
    view_gl_draw_full(p->program);
}

/* Unused samplers get a black cube: drivers warn about empty ones, or recompile
 * once they are filled. */
static void bind_maps(const view_room_probes *p, const view_probe_maps *m,
                      int unit)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;

    view_gl_bind(unit, target, m->count ? m->specular : p->none);
    view_gl_bind(unit + 1, target, m->count ? m->irradiance : p->none);
}

void view_room_probes_use(view_room_probes *p, const view_room_draw *d,
                          const GLint size[2])
{
    upload(p, d);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, p->texels);
    if (has_masks(d))
        cull(p, d, size);
    bind_maps(p, &d->dynamic, VIEW_ROOM_UNIT_DYNAMIC);
    bind_maps(p, &d->locals, VIEW_ROOM_UNIT_LOCALS);
    view_gl_bind(VIEW_ROOM_UNIT_MASKS, GL_TEXTURE_2D, p->masks);
}
