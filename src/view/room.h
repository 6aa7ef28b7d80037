/* SPDX-License-Identifier: MIT */
/*
 * The scene of --mode scene: a room of 10 x 4 x 10 units, floor at y = 0, with
 * a glossy floor, four pillars, a wall in a corner, panels that emit light,
 * windows to the environment, and spheres, most of which move.
 *
 * Probes capture the light of the windows and the panels. Each surface is
 * shaded by the split sum with the given probes, mixed and looked up as in
 * ibl/probes.h; the next refresh of the probes adds the next bounce. Lights
 * that were taken out of the environment have shadows.
 */
#ifndef VIEW_ROOM_H
#define VIEW_ROOM_H

#include <stdbool.h>

#include "ibl/ibl.h"
#include "ibl/io.h"
#include "ibl/probes.h"
#include "view/frame.h"
#include "view/gl.h"
#include "view/model.h"
#include "view/settings.h"
#include "view/sphere_grid.h"

typedef struct view_room view_room;

/* The inside of the walls, for proxies. */
extern const double view_room_centre[3], view_room_half[3];

typedef struct view_room_material {
    float albedo[3]; /* diffuse; metals: 0 */
    float roughness;
    float f0[3];
    float emission[3]; /* radiance */
} view_room_material;

/* Solid, axis-aligned. */
typedef struct view_room_box {
    double low[3], high[3];
    const view_room_material *material;
} view_room_box;

/* Everything that stands still, except the sphere in the middle. The first are
 * the tiles of the floor, which fill the box from the low corner of the first
 * to the high corner of the last. */
#define VIEW_ROOM_BOXES 49
#define VIEW_ROOM_TILES 25
const view_room_box *view_room_box_at(int i);

/* Sphere 0 is a mirror that stands still. 1 is a lamp, 2 and 3 are rough; these
 * move. */
#define VIEW_ROOM_SPHERES 4
void view_room_sphere(int i, double seconds, double centre[3], double *radius);
bool view_room_sphere_moves(int i);
const view_room_material *view_room_sphere_material(int i);

/* Probes, each a layer of cube arrays, filtered linearly. Alpha is the part
 * that was captured; colours are premultiplied by it. */
typedef struct view_probe_maps {
    int count;              /* 0..IBL_MAX_PROBES */
    const ibl_probe *probe; /* sorted by ibl_probes_order */
    bool holes; /* alpha is below 1 somewhere: other probes must fill in */
    GLuint specular, irradiance;
    bool filament; /* levels are linear in r (2 - r), not in roughness r */
    float lod_scale, lod_offset, last_level;
    float irradiance_scale; /* texel * scale = E / pi */
} view_probe_maps;

/* Seen through windows; gets the weight that the probes leave. */
typedef struct view_room_environment {
    GLuint specular, irradiance, sky; /* sky: level 0 or the skybox */
    view_frame
        frame;   /* what it says of the set and its lookup, with lights that
                    are no part of the maps; all but SPLIT_SUM by FIT */
    bool map;    /* VIEW_UNIT_BACKDROP has the map itself, for the sky */
    double turn; /* degrees */
} view_room_environment;

typedef struct view_room_draw {
    /* Of a paraboloid, as in shaders/paraboloid.glsl, unit axes. Pictures may
     * be mirrored. */
    view_camera camera;
    bool paraboloid;
    double seconds; /* time that places moving objects */
    bool moving;    /* draw moving objects */
    bool shadows;   /* of the lights */
    /* Blended at a point in the order of ibl_probes_order, local ones first
     * among equals, as by ibl_probes_blend with alpha but without a maximum
     * count. */
    view_probe_maps locals;
    view_probe_maps dynamic; /* a probe captured repeatedly, or none */
    view_room_environment environment;
    GLuint table;        /* split-sum table */
    view_lighting light; /* SPLIT_SUM or FIT; override is of the guest */
    /* SPHERE: in place of a proxy's box the sphere around it, so that all of
     * the box is corrected. */
    view_parallax parallax;
    /* NEAREST and NEAREST_K mix the locals that are nearest, whatever their
     * influence; the dynamic one is before or after all of them. */
    view_probe_choice choice;
    int nearest;  /* of NEAREST_K */
    bool weights; /* draw view_room_hue of the probes, mixed as diffuse light */
    bool mirror;  /* draw the mirror */
    view_model *guest; /* is drawn, too, or NULL */
    bool map;          /* the sky is the environment's map; not for captures */
    bool bare;         /* no sky: what it would cover is 0, alpha too */
} view_room_draw;

/* NULL, with a message; needs cube map arrays. */
view_room *view_room_create(void);
void view_room_free(view_room *r); /* NULL is fine */

/* The weights of d->locals, then the dynamic probe's, then the environment's,
 * at a point, as if all captures had an alpha of 1; their sum is 1. */
void view_room_weights(const view_room_draw *d, const double point[3],
                       double *weights);
/* The colour of a probe where weights are drawn: dynamic ones are white, the
 * environment (-1) grey. */
void view_room_hue(const view_room_draw *d, int probe, float rgb[3]);
/* The distance at which a ray along a unit direction meets what is drawn;
 * INFINITY: it leaves the room. */
double view_room_cast(const view_room_draw *d, const double from[3],
                      const double direction[3]);

/* Draws scene-linear RGBA and depth. Changes texture units below
 * VIEW_UNIT_COUNT, uniform buffers 0 and 1, program and vertex array; leaves
 * depth test and face culling off. False, with a message. */
bool view_room_render(view_room *r, const view_room_draw *d, view_image *to);

/* ---- captures (capture.c) ----------------------------------------------- */

/*
 * Captures of the room as cubes, filtered to levels of roughness (ibl/ibl.h:
 * GGX with N = V = R) and irradiance. Levels of cubes of 64
 * texels differ from the library's by an nRMSE of 1.6 % in an evenly lit room,
 * up to 4 % with a light 50 times as bright, 12 % with a small one 1000 times
 * as bright (tests/check_view_capture.c).
 *
 * Alpha is the share of a texel that was drawn, 0..1. Filters treat it like the
 * colours, which are premultiplied by it.
 *
 * All calls turn depth test and blending off and leave no program in use. They
 * change the framebuffer, the viewport, the units VIEW_CAPTURE_UNIT and on
 * and the vertex array.
 */

/* Cube arrays, RGBA16F, filtered linearly. */
typedef struct view_cubes {
    GLuint specular;
    GLuint irradiance; /* E / pi */
} view_cubes;

#define VIEW_CAPTURE_IRRADIANCE 32 /* edge of irradiance */

/* Allocates count cubes with ibl_default_levels(size) levels, without defined
 * texels. False, and both are 0, if OpenGL has no memory. */
bool view_cubes_make(view_cubes *c, int size, int count);
void view_cubes_free(view_cubes *c); /* also zeroes them */

typedef struct view_capture view_capture;

/* size: edge of a face, a power of two, 16..1024. Pictures of paraboloids have
 * twice the edge: a third more pixels than six faces. They pay off if the scene
 * is more expensive to draw. NULL, with a message. */
view_capture *view_capture_create(view_probe_capture kind, int size);
void view_capture_free(view_capture *c); /* NULL is fine */

/* Captures draw, its camera's eye, near and far, into a layer of cubes of the
 * capture's size. */
void view_capture_update(view_capture *c, view_room *room,
                         const view_room_draw *draw, const view_cubes *to,
                         int layer);

/* ---- probes that were baked (probe_set.c) ------------------------------- */

typedef struct view_probe_set view_probe_set;

/* Reads an index (iblbake-probes(1)) and its arrays, and turns spherical
 * harmonics of irradiance into cubes; ignores the global environment. ctx must
 * log through view_log. NULL, with a message: a file is missing or wrong. */
view_probe_set *view_probe_set_load(ibl_ctx *ctx, const char *index);
void view_probe_set_free(view_probe_set *set); /* NULL is fine */

/* Maps to draw the room with; owned by set. */
const view_probe_maps *view_probe_set_locals(const view_probe_set *set);

/* ---- --mode scene (scene_captures.c) ------------------------------------ */

typedef struct view_scene view_scene;

enum {
    VIEW_SCENE_MIRROR = 0 /* index of the sphere with the probe */
};

view_scene *view_scene_create(void);  /* NULL, with a message */
void view_scene_free(view_scene *st); /* NULL is fine */

/* Replaces local probes of the settings by baked ones; NULL: does not. probes
 * must stay valid until the next call. The next draw captures everything again;
 * call this also after a change of the environment. */
void view_scene_use(view_scene *st, const view_probe_set *probes);

/*
 * Captures what is due by settings: turn, parallax, seconds and how the probe
 * is refreshed. The first call, and each after a change of the light or of the
 * capture, makes a whole capture with its bounces. If settings spread local
 * probes, each call captures one of them, and the last the mirror too; until
 * then nothing moves in it. Later calls capture when the interval is over, by
 * settings.seconds, and objects have moved.
 *   guest  a model that stands in place of the mirror, or NULL; captures leave
 *          it out
 *   anew   becomes true if the next draw is another picture by this
 * False, with a message.
 */
bool view_scene_update(view_scene *st, const view_settings *s,
                       const view_room_environment *environment, GLuint table,
                       view_model *guest, bool *anew);
/* Draws it by the camera of the settings. False, with a message. */
bool view_scene_draw(view_scene *st, const view_settings *s, view_image *to);

/* Results of draws. */
typedef struct view_scene_state {
    view_room_draw draw; /* the last draw, with its probes */
    int updates;         /* number of updates of the mirror's probe */
    double shown;        /* settings.seconds of that probe */
    double ms;           /* of the last one */
} view_scene_state;

const view_scene_state *view_scene_state_of(const view_scene *st);

/* Default distance of the camera from the mirror, in units. */
extern const double view_scene_distance;
/* The camera orbits the mirror and stays in the room. */
view_camera view_scene_camera(const view_settings *s, int width, int height);

/* ---- local probes ------------------------------------------------------- */

/* Places 1..VIEW_MAX_LOCALS probes in a nearly square grid at eye level,
 * outside pillars and mirror. Influence: the cell, from below the floor to
 * above the ceiling; proxy: the walls. Influences of neighbours overlap by a
 * blend width and sum to at least 1. Sorted by ibl_probes_order; layers 0 to
 * count - 1. */
void view_scene_place(ibl_probe *probes, int count);

/* ---- for the user interface --------------------------------------------- */

/* The probe with the largest weight where the pixel x, y shows the room: a
 * local one, or their number for the mirror's, or -1 for the environment. A
 * model in place of the mirror is not seen. weights: as of view_room_weights,
 * IBL_MAX_PROBES + 2 at most. */
int view_scene_probe_at(const view_scene *st, const view_settings *s, int width,
                        int height, double x, double y, double *weights);
#define VIEW_SCENE_NOWHERE (-2) /* it shows the sky; weights are undefined */

#endif
