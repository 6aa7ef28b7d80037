/* SPDX-License-Identifier: MIT */
/*
 * The scene of --mode scene: a room of 10 x 4 x 10 units, floor at y = 0, with
 * a glossy floor, four pillars, a wall in a corner, panels that emit light,
 * windows to the environment, and spheres, most of which move.
 *
 * Probes capture the light of the windows and the panels. Each surface is
 * shaded by the split sum with the given probes, mixed and looked up as in
 * ibl/probes.h; the next refresh of the probes adds the next bounce. Lights
 * that were taken out of the environment are left out.
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
extern const ibl_volume view_room_inside;

/* Sphere 0 is a mirror that stands still; the others move: 1 is a lamp, 2 and 3
 * are rough. */
#define VIEW_ROOM_SPHERES 4
typedef struct view_room_sphere {
    double centre[3], radius;
} view_room_sphere;
view_room_sphere view_room_sphere_at(int i, double seconds);

/* The first are those of the spheres. */
extern const ibl_scene_material view_room_materials[];

/* Solid, axis-aligned: everything else, which stands still. The first are the
 * tiles of the floor. */
#define VIEW_ROOM_BOXES 49
typedef struct view_room_box {
    double low[3], high[3];
    int material;
} view_room_box;
view_room_box view_room_box_at(int i);

/* Probes, each a layer of cube arrays, filtered linearly. Alpha is the part
 * that was captured; colours are premultiplied by it. */
typedef struct view_probe_maps {
    int count;              /* 0..IBL_MAX_PROBES */
    const ibl_probe *probe; /* sorted by ibl_probes_order */
    bool holes; /* alpha is below 1 somewhere: other probes must fill in */
    GLuint specular, irradiance;
    float lod[4];           /* as view_frame.lod */
    float irradiance_scale; /* texel * scale = E / pi */
} view_probe_maps;

/* Seen through windows; gets the weight that the probes leave. */
typedef struct view_room_environment {
    GLuint specular, irradiance, sky; /* sky: level 0 or the skybox */
    view_frame frame; /* what it says of the set and its lookup, the turn, and
                         how far lobes are widened, not in captures */
    bool map; /* the sky is VIEW_UNIT_BACKDROP's map itself; not for captures */
} view_room_environment;

typedef struct view_room_draw {
    /* seconds that place moving objects; reflection, split-sum or fit; weights;
     * parallax, SPHERE: in place of a proxy's box the sphere around it, so that
     * all of the box is corrected; probe_choice, NEAREST and NEAREST_K: mix the
     * locals that are nearest, whatever their influence, and the dynamic one
     * before or after all of them. */
    view_settings settings;
    /* Of a paraboloid, as in shaders/room.glsl, unit axes. Pictures may be
     * mirrored. */
    view_camera camera;
    bool paraboloid;
    bool moving, mirror; /* draw moving objects; the mirror */
    view_model *guest;   /* is drawn, too, or NULL */
    /* Blended at a point in the order of ibl_probes_order, local ones first
     * among equals, as by ibl_probes_blend with alpha but without a maximum
     * count. */
    view_probe_maps locals;
    view_probe_maps dynamic; /* a probe captured repeatedly, or none */
    view_room_environment environment;
    GLuint table; /* split-sum table */
    /* Surfaces have as red the number of the probe with the largest share of
     * diffuse light, that of the locals for the dynamic one and -1 for the
     * environment, and as green the share. */
    bool largest;
    bool bare; /* no sky: what it would cover is 0, alpha too */
} view_room_draw;

/* NULL, with a message; needs cube map arrays. */
view_room *view_room_create(void);
void view_room_free(view_room *r); /* NULL is fine */

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
 * as bright (tests/check_view_room.c).
 *
 * Alpha is the share of a texel that was drawn, 0..1. Filters treat it like the
 * colours, which are premultiplied by it.
 *
 * All calls turn depth test and blending off and leave no program in use. They
 * change the framebuffer, the viewport, the units VIEW_CAPTURE_UNIT and on
 * and the vertex array.
 */

#define VIEW_CAPTURE_IRRADIANCE 32 /* edge of irradiance, E / pi */

/* Makes cube arrays, RGBA16F, of count cubes with ibl_default_levels(size)
 * levels, without defined texels. False, and both are 0, if OpenGL has no
 * memory. */
bool view_probe_maps_make(view_probe_maps *m, int size, int count);
void view_probe_maps_free(view_probe_maps *m); /* also zeroes them */

typedef struct view_capture view_capture;

/* size: edge of a face, a power of two, 16..1024. Pictures of paraboloids have
 * twice the edge: a third more pixels than six faces. They pay off if the scene
 * is more expensive to draw. NULL, with a message. */
view_capture *view_capture_create(view_probe_capture kind, int size);
void view_capture_free(view_capture *c); /* NULL is fine */

/* Captures draw, its camera's eye, near and far, into a layer of cubes of the
 * capture's size. */
void view_capture_update(view_capture *c, view_room *room,
                         const view_room_draw *draw, const view_probe_maps *to,
                         int layer);

/* ---- probes that were baked (probe_set.c) ------------------------------- */

typedef struct view_probe_set {
    ibl_probe_index index;
    view_probe_maps maps;
} view_probe_set;

/* Reads an index (iblbake-probes(1)) and its arrays, and turns spherical
 * harmonics of irradiance into cubes; ignores the global environment. ctx must
 * log through view_log. NULL, with a message: a file is missing or wrong. */
view_probe_set *view_probe_set_load(ibl_ctx *ctx, const char *index);
void view_probe_set_free(view_probe_set *set); /* NULL is fine */

/* ---- --mode scene (scene_captures.c) ------------------------------------ */

typedef struct view_scene {
    view_room *room;
    view_capture *capture;  /* for all probes */
    view_probe_maps mirror; /* two cubes, with moving objects */
    ibl_probe probe;        /* the mirror's, of the last capture */
    view_probe_maps locals; /* count: as many as were captured */
    ibl_probe local[VIEW_MAX_LOCALS];
    const view_probe_set *set; /* baked probes replace locals */
    view_settings made;  /* of the captures; nearest is 0: they are not valid */
    view_room_draw draw; /* the last draw, with its probes */
    view_model *guest;   /* in place of the mirror, or NULL */
    view_image pixel;    /* under the pointer */
    bool told;           /* lights were noted */
    int updates;         /* number of updates of the mirror's probe */
    double shown;        /* settings.seconds of that probe */
    double ms;           /* of the last one */
} view_scene;

view_scene *view_scene_create(void);  /* NULL, with a message */
void view_scene_free(view_scene *st); /* NULL is fine */

/* Replaces local probes of the settings by baked ones; NULL: does not. probes
 * must stay valid until the next call. The next draw captures everything again;
 * call this also after a change of the environment, whose lights are then noted
 * to be left out. */
void view_scene_use(view_scene *st, const view_probe_set *probes);

/*
 * Captures what is due by settings. The first call, and each after a change of
 * what captures depend on, makes a whole capture with its bounces. If settings
 * spread local probes, each call captures one of them, and the last the mirror
 * too; until then nothing moves in it. Later calls capture when the interval is
 * over, by settings.seconds, and objects have moved.
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

/* The probe with the largest weight where the pixel x, y shows the room, as
 * view_room_draw.largest has it. A model in place of the mirror is not seen.
 * Changes OpenGL as draws do. */
int view_scene_probe_at(view_scene *st, const view_settings *s, int width,
                        int height, double x, double y, double *weight);
#define VIEW_SCENE_NOWHERE (-2) /* it shows the sky */

#endif
