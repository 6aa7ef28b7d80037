/* SPDX-License-Identifier: MIT */
/* Everything that keys and options change: a picture is a function of the set
 * and these. */
#ifndef VIEW_SETTINGS_H
#define VIEW_SETTINGS_H

#include <stdbool.h>

typedef enum view_mode {
    VIEW_SPHERES,
    VIEW_LEVELS,         /* a level of the specular chain */
    VIEW_IRRADIANCE_MAP, /* the irradiance map */
    VIEW_TABLE,          /* the BRDF table with iso-lines */
    VIEW_SCENE,          /* the room with a probe */
    VIEW_MODEL,          /* a scene of glTF, or a material ball */
    VIEW_MODES
} view_mode;

typedef enum view_layout {
    VIEW_CROSS,
    VIEW_STRIP,
    VIEW_EQUIRECT,
    VIEW_LAYOUTS
} view_layout;

typedef enum view_tone {
    VIEW_TONE_LINEAR,   /* clamp */
    VIEW_TONE_REINHARD, /* of the luminance, Reinhard et al. 2002 eq. 3 */
    VIEW_TONE_ACES,     /* Hill's fit of RRT and ODT */
    VIEW_TONE_NEUTRAL,  /* Khronos PBR Neutral */
    VIEW_TONES
} view_tone;

typedef enum view_diffuse {
    VIEW_DIFFUSE_MAP,
    VIEW_DIFFUSE_SH,
    VIEW_DIFFUSES
} view_diffuse;

/* How the specular light of spheres is looked up: ibl/ibl.glsl. */
typedef enum view_reflection {
    VIEW_SPLIT_SUM,
    VIEW_BENT,
    VIEW_FIT,
    VIEW_TABLE_LOBES, /* these need the set's table of lobes */
    VIEW_TWO_TAPS,
    VIEW_FOUR_TAPS,
    VIEW_REFERENCE, /* the integral itself, progressive */
    VIEW_REFLECTIONS
} view_reflection;

typedef enum view_compare {
    VIEW_ALONE,
    VIEW_SPLIT,      /* reflection left of settings.split, against right; of
                        each sphere */
    VIEW_DIFFERENCE, /* |reflection - against| * gain */
    VIEW_COMPARES
} view_compare;

/* How a probe captures the scene. */
typedef enum view_probe_capture {
    VIEW_PROBE_FACES,
    VIEW_PROBE_PARABOLOIDS,
    VIEW_PROBE_CAPTURES
} view_probe_capture;

#define VIEW_MAX_LOCALS 64 /* static probes of the scene */
#define VIEW_MAX_LIGHTS 4
#define VIEW_MAX_PRIORITY 1000000
#define VIEW_MAX_LAYER (IBL_MAX_LAYERS / IBL_FACES - 1) /* of cubes */
#define VIEW_MIRROR_AUTO (-VIEW_MAX_PRIORITY - 1)
#define VIEW_MAX_GRID 16
#define VIEW_MAX_ANTIALIAS 8

typedef struct view_light {
    double position[3];
    double intensity[3]; /* radiant intensity; at distance d irradiance is
                            intensity / d^2 */
} view_light;

typedef struct view_settings {
    view_mode mode;
    /* spheres: rows from dielectric (bottom) to metal, columns from smooth to
     * rough; radius 0.45, centres 1 apart in the plane z = 0 round the origin
     */
    int rows, columns;                /* 1..VIEW_MAX_GRID; 7 */
    int material;                     /* index in view_materials */
    double metallic[2], roughness[2]; /* ranges of the grid, 0..1; a single row
                                         or column has the first value */
    view_diffuse diffuse;
    bool multiscatter; /* add the energy that single scattering loses */
    int light_count;
    view_light light[VIEW_MAX_LIGHTS];
    /* camera: looks at the origin from distance, right-handed, +Y up; yaw 0
     * looks along -Z, from +Z. Models fit into a sphere of radius 1 and are
     * moved by pan, of twice that. */
    double yaw, pitch; /* degrees; pitch -89..89, positive from above */
    double distance;   /* 0: the grid or the model fits */
    double border;     /* share of height and width that a picture that fits
                          leaves free on each side */
    double fov;        /* vertical, degrees */
    double covered;    /* share of the width, at the right, that controls cover:
                          the grid is in the middle of the rest */
    /* environment */
    double turn; /* degrees about +Y, counter-clockwise seen from above */
    bool sky;    /* show it; false: the background is black */
    double blur; /* roughness at which it is seen behind spheres, 0..1 */
    /* antialiasing */
    int antialias;   /* N: a picture is the mean of N x N places in each pixel,
                        1..VIEW_MAX_ANTIALIAS; maps are not smoothed */
    double pixel[2]; /* the place, from the pixel's centre to the right and up,
                        -0.5..0.5; the renderer sets it */
    int multisample; /* samples of a pixel of the scene, in place of places,
                        for pictures that change, 1: places; of the model at
                        each place, while it moves 1 if all are slow */
    /* display */
    double ev; /* exposure 2^ev */
    view_tone tone;
    bool false_colour; /* of luminance, instead of tone mapping */
    /* inspection */
    view_layout layout;
    int level;
    double zoom, pan[2];
    /* reflections */
    view_reflection reflection, against;
    view_compare compare;
    double split; /* 0..1 of the width, or of a sphere's cell */
    double gain;  /* of differences */
    /* scene */
    double seconds;        /* time of the animation */
    bool parallax;         /* correct reflections for the room's walls */
    bool blend;            /* blend probes over the widths at their borders */
    int probes;            /* number of local probes, 0..VIEW_MAX_LOCALS */
    int probe_size;        /* of faces: a power of two */
    double probe_interval; /* seconds; 0: every frame */
    int probe_faces;       /* steps of view_capture_update per frame; 0: all */
    view_probe_capture probe_capture;
    bool spread;          /* capture one local probe per frame */
    bool probe_limit;     /* captures end where their influence ends */
    int layer;            /* of an array of cubes */
    int mirror_priority;  /* of the mirror's probe, or VIEW_MIRROR_AUTO */
    bool walls;           /* walls hide probes from points behind them */
    bool volumes;         /* draw volumes of probes as wires */
    bool capture_shadows; /* shadows in captures, too */
    bool help;            /* show the list of keys */
    bool panel;           /* show the controls */
} view_settings;

view_settings view_settings_default(void);

/* Whether a picture is of spheres or a model, of two reflections of them, and
 * whether one of these is the reference. */
bool view_shows_materials(const view_settings *s);
bool view_compares(const view_settings *s);
bool view_wants_reference(const view_settings *s);
/* Draws that make a picture: the places in a pixel. */
int view_places(const view_settings *s);
/* Sets s->pixel to place i of view_places: a lattice that is turned, so that
 * edges along rows and columns meet each place apart. */
void view_set_place(view_settings *s, int i);
/* How far normals of a pixel are taken apart, in pixels, for the roughness that
 * stands for their curvature; 0: not at all, as where errors are measured. */
double view_widening(const view_settings *s);
/* Whether a reflection needs the set's table of lobes. */
bool view_needs_lobes(view_reflection reflection);

/* Names for options and titles, indexed by the enumeration; NULL after the
 * last. */
extern const char *const view_mode_names[VIEW_MODES + 1];
extern const char *const view_layout_names[VIEW_LAYOUTS + 1];
extern const char *const view_tone_names[VIEW_TONES + 1];
extern const char *const view_diffuse_names[VIEW_DIFFUSES + 1];
extern const char *const view_reflection_names[VIEW_REFLECTIONS + 1];
extern const char *const view_compare_names[VIEW_COMPARES + 1];
extern const char *const view_probe_capture_names[VIEW_PROBE_CAPTURES + 1];

#endif
