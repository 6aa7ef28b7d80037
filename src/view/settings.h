/* SPDX-License-Identifier: MIT */
/* Everything that keys and options change: a picture is a function of the set
 * and these. */
#ifndef VIEW_SETTINGS_H
#define VIEW_SETTINGS_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/io.h"

typedef enum view_mode {
    VIEW_SPHERES,
    VIEW_LEVELS,         /* a level of the specular chain */
    VIEW_IRRADIANCE_MAP, /* the irradiance map */
    VIEW_TABLE,          /* the BRDF table */
    VIEW_SCENE,          /* the room with a probe */
    VIEW_MODEL,          /* a scene of glTF */
    VIEW_SOURCE_MAP,     /* the environment at its own resolution */
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
    VIEW_TONE_AGX,      /* Sobotka's, by its published formula */
    VIEW_TONES
} view_tone;

typedef enum view_diffuse {
    VIEW_DIFFUSE_MAP,
    VIEW_DIFFUSE_SH,
    VIEW_DIFFUSE_LAST, /* the last level of the specular chain, at N */
    VIEW_DIFFUSE_AUTO, /* what the set's engine takes: view_diffuse_of */
    VIEW_DIFFUSES
} view_diffuse;

/* How the specular light of spheres is looked up: ibl/ibl.glsl. */
typedef enum view_reflection {
    VIEW_SPLIT_SUM,
    VIEW_FIT,
    VIEW_TABLE_LOBES, /* these need the set's table of lobes */
    VIEW_TWO_TAPS,
    VIEW_THREE_TAPS,
    VIEW_FOUR_TAPS,
    VIEW_REFERENCE, /* the integral itself, progressive */
    VIEW_REFLECTIONS
} view_reflection;

/* How two states are shown; members that differ are those of controls.h. */
typedef enum view_compare {
    VIEW_ALONE,
    VIEW_SPLIT,      /* the first left of settings.split; of each sphere */
    VIEW_DIFFERENCE, /* |first - second| * gain */
    VIEW_COMPARES
} view_compare;

/* What of the light is drawn. */
typedef enum view_parts {
    VIEW_PARTS_ALL,
    VIEW_PARTS_AMBIENT, /* albedo in a constant light, the mean of the set, in
                           place of diffuse and specular */
    VIEW_PARTS_DIRECT,  /* lights that are no part of the maps */
    VIEW_PARTS_DIFFUSE,
    VIEW_PARTS_SPECULAR,
    VIEW_PARTS_COUNT
} view_parts;

/* What is behind everything. */
typedef enum view_background {
    VIEW_BACKGROUND_MAP, /* the map; else the skybox or level 0 */
    VIEW_BACKGROUND_BLUR,
    VIEW_BACKGROUND_LEVEL,
    VIEW_BACKGROUND_COLOUR,
    VIEW_BACKGROUND_TRANSPARENT /* alpha 0 in pictures */
} view_background;

/* Materials of a model. */
typedef enum view_override {
    VIEW_AS_IS,
    VIEW_CLAY,    /* albedo .5, rough, not metallic */
    VIEW_CHROME,  /* a mirror of chromium */
    VIEW_MATERIAL /* settings.material */
} view_override;

typedef enum view_channel {
    VIEW_RGB,
    VIEW_RED,
    VIEW_GREEN,
    VIEW_BLUE,
    VIEW_ALPHA,
    VIEW_LUMINANCE,
    VIEW_CHANNELS
} view_channel;

/* What reflections of probes are corrected for. */
typedef enum view_parallax {
    VIEW_PARALLAX_NONE,
    VIEW_PARALLAX_BOX,   /* each probe's own proxy */
    VIEW_PARALLAX_SPHERE /* a sphere in its place */
} view_parallax;

/* Which probes light a point. */
typedef enum view_probe_choice {
    VIEW_PROBES_BLEND, /* by influence, weight and priority: ibl/probes.h */
    VIEW_PROBES_NEAREST,
    VIEW_PROBES_NEAREST_K, /* by inverse distance */
    VIEW_PROBE_CHOICES
} view_probe_choice;

/* How a probe captures the scene. */
typedef enum view_probe_capture {
    VIEW_PROBE_FACES,
    VIEW_PROBE_PARABOLOIDS,
    VIEW_PROBE_CAPTURES
} view_probe_capture;

#define VIEW_MAX_LOCALS 64 /* static probes of the scene */
#define VIEW_MAX_LIGHTS 4
#define VIEW_MAX_NEAREST 8
#define VIEW_MAX_LAYER (IBL_MAX_LAYERS / IBL_FACES - 1) /* of cubes */
#define VIEW_MAX_GRID 16
#define VIEW_MAX_ANTIALIAS 8

typedef struct view_light {
    double position[3];
    double intensity[3]; /* radiant intensity; at distance d irradiance is
                            intensity / d^2 */
} view_light;

/* Where a camera of a file is, as the model is moved and scaled. */
typedef struct view_pose {
    double axes[3][3]; /* unit: right, up, back */
    double eye[3];
    double yfov, aspect; /* radians; width by height, or 0 */
} view_pose;

typedef struct view_settings {
    /* What may differ between two states that are compared: materials, */
    int material;                     /* index in view_materials */
    double metallic[2], roughness[2]; /* ranges of the grid, 0..1; a single row
                                         or column has the first value */
    view_override override;
    /* light, */
    view_parts parts;
    view_diffuse diffuse;
    view_reflection reflection;
    bool multiscatter;  /* add the energy that single scattering loses */
    bool rough_fresnel; /* diffuse light by the tutorials' Fresnel of roughness,
                           in place of what the specular part leaves */
    bool seams;         /* cubes without GL_TEXTURE_CUBE_MAP_SEAMLESS */
    int level;          /* that is shown */
    /* probes of the scene */
    view_parallax parallax;
    view_probe_choice probe_choice;
    int nearest;    /* of VIEW_PROBES_NEAREST_K, 1..VIEW_MAX_NEAREST */
    int probes;     /* number of local probes, 0..VIEW_MAX_LOCALS */
    int probe_size; /* faces have 16 << probe_size texels along an edge */
    view_probe_capture probe_capture;
    bool probe_limit; /* captures end where their influence ends */

    /* What is of both, from here on: VIEW_SIDE_BYTES. */
    view_mode mode;
    /* spheres: rows from dielectric (bottom) to metal, columns from smooth to
     * rough; radius 0.45, centres 1 apart in the plane z = 0 round the origin
     */
    int rows, columns; /* 1..VIEW_MAX_GRID; 7 */
    int light_count;
    view_light light[VIEW_MAX_LIGHTS];
    /* camera: looks at the origin from distance, right-handed, +Y up; yaw 0
     * looks along -Z, from +Z. Models fit into a sphere of radius 1 and are
     * moved by pan, of twice that. */
    double yaw, pitch;     /* degrees; pitch -89..89, positive from above */
    double distance;       /* 0: the grid or the model fits */
    double border;         /* share of height and width that a picture that fits
                              leaves free on each side */
    double fov;            /* vertical, degrees */
    int file_camera;       /* 1 + index of a camera of the model; 0: none */
    const view_pose *pose; /* of it, which the renderer sets; NULL: none */
    bool ground; /* below the model, with the shadow of the main light */
    /* environment */
    view_background background;
    int background_level;
    double background_colour[3]; /* scene-linear */
    double turn; /* degrees about +Y, counter-clockwise seen from above */
    double blur; /* roughness at which it is seen behind spheres, 0..1 */
    /* antialiasing */
    int antialias;   /* N: a picture is the mean of N x N places in each pixel,
                        1..VIEW_MAX_ANTIALIAS; maps are not smoothed */
    double pixel[2]; /* the place, from the pixel's centre to the right and up,
                        -0.5..0.5; the renderer sets it */
    /* display */
    double ev; /* exposure 2^ev */
    view_tone tone;
    bool false_colour; /* of luminance, instead of tone mapping */
    view_compare compare;
    double split; /* 0..1 of the width, or of a sphere's cell */
    double gain;  /* of differences */
    /* maps */
    view_layout layout;
    view_channel channel;
    bool filter; /* interpolate texels */
    int layer;   /* of an array of cubes */
    double zoom, pan[2];
    /* scene */
    double seconds;        /* time of the animation */
    double probe_interval; /* seconds; 0: every frame */
    bool spread;           /* capture one local probe per frame */
    bool weights;          /* show the probes' weights as colours */
} view_settings;

enum {
    VIEW_SIDE_BYTES = offsetof(view_settings, mode)
};

view_settings view_settings_default(void);

/* Whether a picture is of spheres or a model; of these or the room. */
bool view_shows_materials(const view_settings *s);
bool view_is_lit(const view_settings *s);
/* Whether it is the reference; whether that is drawn of a state and, if it is
 * compared, of the other one. */
bool view_wants_reference(const view_settings *s);
bool view_is_sampled(const view_settings *s, const view_settings *other);
/* Draws that make a picture: the places in a pixel. */
int view_places(const view_settings *s);
/* Sets s->pixel to place i of view_places: a lattice that is turned, so that
 * edges along rows and columns meet each place apart. */
void view_set_place(view_settings *s, int i);
/* Whether a reflection needs the set's table of lobes. */
bool view_needs_lobes(view_reflection reflection);

/* Names for options and titles, indexed by the enumeration; NULL after the
 * last. */
extern const char *const view_mode_names[VIEW_MODES + 1];
extern const char *const view_layout_names[VIEW_LAYOUTS + 1];
extern const char *const view_diffuse_names[VIEW_DIFFUSES + 1];
extern const char *const view_reflection_names[VIEW_REFLECTIONS + 1];
extern const char *const view_channel_names[VIEW_CHANNELS + 1];

#endif
