/* SPDX-License-Identifier: MIT */
#include "view/room.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "common/signals.h"
#include "view/frame.h"
#include "view/message.h"
#include "view/program.h"
#include "view/room_parts.h"
#include "view/vector.h"

/* Boxes that hide what is behind them, as in room.glsl: the floor is one. */
#define HIDING (VIEW_ROOM_BOXES - VIEW_ROOM_TILES + 1)

enum {
    MOST = IBL_MAX_PROBES,
    FLOATS = (MOST + 1) * IBL_PROBE_FLOATS /* the dynamic one is the last */
};

typedef struct room_probes {
    GLuint program;
    GLuint buffer, texels; /* packed probes, and their buffer texture */
    GLuint none;           /* array of one black cube */
    GLuint masks, framebuffer;
    int columns, rows; /* size of masks */
} room_probes;

/* The last members of the uniform block "Room", std140. */
typedef struct room_probe_block {
    int picture_size[4]; /* width, height, tile edge or 0: no masks, locals */
    int order[4];        /* locals before the dynamic one, rows of tiles */
    float local_lod[4], dynamic_lod[4]; /* as view_frame.lod */
    float scales[4]; /* irradiance: locals, dynamic one; then 1 with dynamic */
} room_probe_block;

/* Uniform block "Room" (shaders/room.glsl), std140. */
typedef struct room_block {
    float picture[16];
    float paraboloid[4]; /* x: 1 for a paraboloid */
    float flags[4]; /* parallax; number of boxes that hide probes, of boxes and
                       of spheres that hide lights */
    float boxes[2 * HIDING][4]; /* low and high of each; w: thickness. Those
                                   that hide probes come first */
    float spheres[VIEW_ROOM_SPHERES][4]; /* centre, radius */
    room_probe_block probes;
} room_block;

/* Attributes of room.vert, all but CENTRE_RADIUS from vertices. */
enum {
    POSITION,
    CENTRE_RADIUS,
    MATERIAL, /* three attributes */
    NORMAL = MATERIAL + 3
};

struct view_room {
    GLuint surfaces, sky; /* programs */
    room_probes probes;
    GLuint array, vertices, indices;
    view_room_mesh mesh; /* only its ranges */
    GLuint frame_buffer, room_buffer;
};

/* ---- resources of probes ----------------------------------------------- */

static void make_buffer(room_probes *p)
{
    p->buffer = view_gl_buffer(GL_TEXTURE_BUFFER, FLOATS * sizeof(float), NULL);
    gl.GenTextures(1, &p->texels);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, p->texels);
    gl.TexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, p->buffer);
}

static void make_black(room_probes *p)
{
    static const float black[4 * 6];

    gl.GenTextures(1, &p->none);
    view_gl_bind(VIEW_ROOM_UNIT_LOCALS, GL_TEXTURE_CUBE_MAP_ARRAY, p->none);
    view_gl_filter(GL_TEXTURE_CUBE_MAP_ARRAY, GL_LINEAR, 1);
    gl.TexImage3D(GL_TEXTURE_CUBE_MAP_ARRAY, 0, GL_RGBA16F, 1, 1, 6, 0, GL_RGBA,
                  GL_FLOAT, black);
}

/* Enlarges the texture of masks if it is too small. */
static void make_masks(room_probes *p, int columns, int rows)
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

static bool make_probes(room_probes *p)
{
    p->program = view_program("full.vert", "room_tiles.frag");
    gl.GenTextures(1, &p->masks);
    gl.GenFramebuffers(1, &p->framebuffer);
    make_masks(p, 1, 1);
    make_buffer(p);
    make_black(p);
    return p->program;
}

/* ---- uniforms of probes ------------------------------------------------ */

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

static void fill_probes(room_probe_block *b, const view_room_draw *d,
                        const GLint size[2])
{
    *b = (room_probe_block){
        .picture_size = {size[0], size[1], has_masks(d) ? VIEW_ROOM_TILE : 0,
                         d->locals.count},
        .order = {dynamic_place(d), tiles_of(size[1])},
        .scales = {d->locals.irradiance_scale, d->dynamic.irradiance_scale,
                   (float)d->dynamic.count}};
    fill_lod(b->local_lod, &d->locals);
    fill_lod(b->dynamic_lod, &d->dynamic);
}

/* ---- bindings of probes ------------------------------------------------ */

static void upload(room_probes *p, const view_room_draw *d)
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
static void cull(room_probes *p, const view_room_draw *d, const GLint size[2])
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
static void bind_probes(const room_probes *p, const view_probe_maps *m,
                        int unit)
{
    const GLenum target = GL_TEXTURE_CUBE_MAP_ARRAY;

    view_gl_bind(unit, target, m->count ? m->specular : p->none);
    view_gl_bind(unit + 1, target, m->count ? m->irradiance : p->none);
}

/* Renders masks if the draw uses them, which changes framebuffer and viewport.
 */
static void use_probes(room_probes *p, const view_room_draw *d,
                       const GLint size[2])
{
    upload(p, d);
    view_gl_bind(VIEW_ROOM_UNIT_BUFFER, GL_TEXTURE_BUFFER, p->texels);
    if (has_masks(d))
        cull(p, d, size);
    bind_probes(p, &d->dynamic, VIEW_ROOM_UNIT_DYNAMIC);
    bind_probes(p, &d->locals, VIEW_ROOM_UNIT_LOCALS);
    view_gl_bind(VIEW_ROOM_UNIT_MASKS, GL_TEXTURE_2D, p->masks);
}

/* ---- create and free --------------------------------------------------- */

static bool make_programs(view_room *r)
{
    r->surfaces = view_program("room.vert", "room.frag");
    r->sky = view_program("full.vert", "room_sky.frag");
    return r->surfaces && r->sky && make_probes(&r->probes);
}

static bool make_mesh(view_room *r)
{
    const size_t stride = sizeof(view_room_vertex);
    const size_t material = offsetof(view_room_vertex, material);
    view_room_mesh *m = &r->mesh;

    view_room_mesh_make(m);
    gl.GenVertexArrays(1, &r->array);
    gl.BindVertexArray(r->array);
    r->indices =
        view_gl_buffer(GL_ELEMENT_ARRAY_BUFFER,
                       (size_t)m->index_count * sizeof *m->indices, m->indices);
    r->vertices = view_gl_buffer(GL_ARRAY_BUFFER,
                                 (size_t)m->vertex_count * stride, m->vertices);
    view_gl_attribute(POSITION, 3, stride, 0, 0);
    view_gl_attribute(NORMAL, 3, stride, offsetof(view_room_vertex, normal), 0);
    view_gl_attribute(MATERIAL, 4, stride, material, 0);
    view_gl_attribute(MATERIAL + 1, 3, stride,
                      material + offsetof(view_room_material, f0), 0);
    view_gl_attribute(MATERIAL + 2, 3, stride,
                      material + offsetof(view_room_material, emission), 0);
    view_room_mesh_free(m);
    return true;
}

static bool make(view_room *r)
{
    if (!make_programs(r) || !make_mesh(r))
        return false;
    r->frame_buffer =
        view_gl_buffer(GL_UNIFORM_BUFFER, sizeof(view_frame), NULL);
    r->room_buffer =
        view_gl_buffer(GL_UNIFORM_BUFFER, sizeof(room_block), NULL);
    gl.BindVertexArray(0);
    return view_gl_check("making the room");
}

view_room *view_room_create(void)
{
    view_room *r = ibl_need(calloc(1, sizeof *r));

    if (!view_gl_has_cube_arrays())
        view_fail("the scene needs OpenGL 4.0 or ARB_texture_cube_map_array, "
                  "for its probes");
    else if (make(r))
        return r;
    view_room_free(r);
    return NULL;
}

void view_room_free(view_room *r)
{
    free(r);
}

/* ---- uniforms ---------------------------------------------------------- */

/* Rows of the projection: right, up, depth (divisor or z of a paraboloid). */
static void picture_rows(const view_room_draw *d, double rows[3][3])
{
    for (int k = 0; k < 3; k++) {
        rows[0][k] = d->clip[4 * k];
        rows[1][k] = d->clip[4 * k + 1];
        rows[2][k] = d->clip[4 * k + (d->paraboloid ? 2 : 3)];
    }
}

/* Writes the inverse as columns of 4. Returns the determinant: below 0 for a
 * picture that is not mirrored, since depth grows away from the eye. */
static double invert_rows(const double rows[3][3], float columns[16])
{
    double c[3][3], det = 0;

    for (int i = 0; i < 3; i++)
        cross3(rows[(i + 1) % 3], rows[(i + 2) % 3], c[i]);
    for (int k = 0; k < 3; k++)
        det += rows[0][k] * c[0][k];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            columns[4 * i + k] = (float)(c[i][k] / det);
    return det;
}

static void fill_frame(view_frame *f, const view_room_draw *d)
{
    const double turn = d->environment.turn * (M_PI / 180);

    *f = d->environment.frame;
    for (int i = 0; i < 16; i++)
        f->clip[i] = (float)d->clip[i];
    for (int k = 0; k < 3; k++)
        f->eye[k] = (float)d->eye[k];
    f->turn[0] = (float)cos(turn);
    f->turn[1] = (float)sin(turn);
    f->turn[2] = (float)d->widening;
    f->shading[2] = d->map ? VIEW_BACKDROP_MAP : VIEW_BACKDROP_CUBE;
}

static void fill_box(float to[2][4], const double low[3], const double high[3])
{
    double thickness = INFINITY;

    for (int k = 0; k < 3; k++) {
        to[0][k] = (float)low[k];
        to[1][k] = (float)high[k];
        thickness = fmin(thickness, high[k] - low[k]);
    }
    to[0][3] = (float)thickness;
}

/* Returns the number of boxes. */
static int fill_boxes(room_block *b, const view_room_draw *d)
{
    const double *floor = view_room_box_at(0)->low;
    int n = 0;

    for (int hides = 1; hides >= 0; hides--) {
        for (int i = VIEW_ROOM_TILES - 1; i < VIEW_ROOM_BOXES; i++) {
            const view_room_box *box = view_room_box_at(i);
            if (view_room_box_hides(i) == hides)
                fill_box(&b->boxes[2 * n++],
                         i < VIEW_ROOM_TILES ? floor : box->low, box->high);
        }
        if (hides && d->walls)
            b->flags[1] = (float)n;
    }
    return n;
}

static void fill_block(room_block *b, const view_room_draw *d)
{
    const int boxes = fill_boxes(b, d);
    int n = 0;

    b->paraboloid[0] = d->paraboloid;
    b->flags[0] = d->parallax;
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++) {
        double centre[3], radius;
        if (!d->moving && view_room_sphere_moves(i))
            continue;
        view_room_sphere(i, d->seconds, centre, &radius);
        for (int k = 0; k < 3; k++)
            b->spheres[n][k] = (float)centre[k];
        b->spheres[n++][3] = (float)radius;
    }
    b->flags[2] = (float)(d->shadows ? boxes : 0);
    b->flags[3] = (float)(d->shadows ? n : 0);
}

/* Returns whether the picture is mirrored. */
static bool upload_blocks(view_room *r, const view_room_draw *d,
                          const GLint viewport[4])
{
    view_frame frame;
    room_block block = {0};
    double rows[3][3];

    fill_frame(&frame, d);
    fill_block(&block, d);
    fill_probes(&block.probes, d, viewport + 2);
    picture_rows(d, rows);
    const double det = invert_rows(rows, block.picture);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, VIEW_BLOCK_FRAME, r->frame_buffer);
    gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof frame, &frame);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, VIEW_BLOCK_ROOM, r->room_buffer);
    gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
    return det > 0;
}

static void bind_maps(const view_room_draw *d)
{
    const view_room_environment *e = &d->environment;
    const GLuint cube = GL_TEXTURE_CUBE_MAP;

    view_gl_bind(VIEW_UNIT_SPECULAR, cube, e->specular);
    view_gl_bind(VIEW_UNIT_IRRADIANCE, cube, e->irradiance);
    view_gl_bind(VIEW_UNIT_SKY, cube, e->sky);
    view_gl_bind(VIEW_UNIT_LUT, GL_TEXTURE_2D, d->table);
}

/* ---- drawing ----------------------------------------------------------- */

/* centre, radius: of a sphere; boxes are at their places with 0 and 1. */
static void draw_range(const view_room_range *range, const double centre[3],
                       double radius)
{
    gl.VertexAttrib4f(CENTRE_RADIUS, (float)centre[0], (float)centre[1],
                      (float)centre[2], (float)radius);
    gl.DrawElements(GL_TRIANGLES, range->count, GL_UNSIGNED_INT,
                    (const void *)((uintptr_t)range->first * sizeof(GLuint)));
}

static void draw_surfaces(const view_room *r, const view_room_draw *d)
{
    double centre[3], radius;

    gl.UseProgram(r->surfaces);
    gl.BindVertexArray(r->array);
    for (int i = 0; i < VIEW_ROOM_SPHERES; i++) {
        if (!d->moving && view_room_sphere_moves(i))
            continue;
        view_room_sphere(i, d->seconds, centre, &radius);
        draw_range(&r->mesh.spheres[i], centre, radius);
    }
    draw_range(d->paraboloid ? &r->mesh.cells : &r->mesh.sides, (double[3]){0},
               1);
}

/* Renders masks, if needed, into their own framebuffer. Returns whether the
 * picture is mirrored. */
static bool prepare(view_room *r, const view_room_draw *d,
                    const GLint viewport[4])
{
    gl.Disable(GL_CULL_FACE);
    gl.Disable(GL_DEPTH_TEST);
    gl.Disable(GL_BLEND);
    const bool mirrored = upload_blocks(r, d, viewport);
    bind_maps(d);
    use_probes(&r->probes, d, viewport + 2);
    return mirrored;
}

void view_room_render(view_room *r, const view_room_draw *d)
{
    GLint framebuffer, viewport[4];

    gl.GetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
    gl.GetIntegerv(GL_VIEWPORT, viewport);
    const bool mirrored = prepare(r, d, viewport);
    gl.BindFramebuffer(GL_FRAMEBUFFER, (GLuint)framebuffer);
    gl.Viewport(viewport[0], viewport[1], viewport[2], viewport[3]);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL); /* the sky has the cleared depth */
    gl.Enable(GL_CULL_FACE);
    gl.FrontFace(mirrored ? GL_CW : GL_CCW);
    if (d->paraboloid)
        gl.Enable(GL_CLIP_DISTANCE0);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_DEPTH_BUFFER_BIT | (d->bare ? GL_COLOR_BUFFER_BIT : 0));
    draw_surfaces(r, d);
    gl.Disable(GL_CLIP_DISTANCE0);
    gl.Disable(GL_CULL_FACE);
    gl.FrontFace(GL_CCW);
    if (!d->bare)
        view_gl_draw_full(r->sky);
    gl.DepthFunc(GL_LESS);
    gl.Disable(GL_DEPTH_TEST);
}
