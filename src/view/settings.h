/* SPDX-License-Identifier: MIT */
/* Everything that keys and options change: with the set, what a picture is a
 * function of. */
#ifndef VIEW_SETTINGS_H
#define VIEW_SETTINGS_H

#include <stdbool.h>

typedef enum view_mode {
    VIEW_SPHERES,
    VIEW_LEVELS,         /* a level of the specular chain */
    VIEW_IRRADIANCE_MAP, /* the irradiance map */
    VIEW_TABLE,          /* the BRDF table with iso-lines */
    VIEW_SCENE,          /* the room with a probe */
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

typedef enum view_compare {
    VIEW_SPLIT_SUM,  /* what engines show */
    VIEW_REFERENCE,  /* the integral itself, progressive */
    VIEW_SPLIT,      /* split sum left of settings.split, reference right */
    VIEW_DIFFERENCE, /* |split sum - reference| * gain */
    VIEW_COMPARES
} view_compare;

/* How a probe sees the scene. */
typedef enum view_probe_capture {
    VIEW_PROBE_FACES,
    VIEW_PROBE_PARABOLOIDS,
    VIEW_PROBE_CAPTURES
} view_probe_capture;

/* What filters it. */
typedef enum view_probe_filter {
    VIEW_PROBE_GPU,
    VIEW_PROBE_CPU, /* the library, from what is read back */
    VIEW_PROBE_FILTERS
} view_probe_filter;

#define VIEW_MAX_LOCALS 64 /* probes of the scene that stand still */
#define VIEW_MAX_LIGHTS 4
#define VIEW_MAX_GRID 16

typedef struct view_light {
    double position[3];
    double intensity[3]; /* radiant intensity, radiance times area: at distance
                            d irradiance is intensity / d^2 */
} view_light;

typedef struct view_settings {
    view_mode mode;
    /* spheres: rows 0 (bottom) .. from dielectric to metal, columns from
     * smooth to rough; radius 0.45, centres 1 apart in the plane z = 0, the
     * grid's middle in the origin */
    int rows, columns;                /* 1..VIEW_MAX_GRID; 7 */
    int material;                     /* see view_material */
    double metallic[2], roughness[2]; /* the grid's ranges: 0..1; one row or
                                         column alone has the first */
    view_diffuse diffuse;
    bool multiscatter; /* compensate for what single scattering loses */
    int light_count;
    view_light light[VIEW_MAX_LIGHTS];
    /* camera: looks at the origin from distance, right-handed, +Y up; yaw 0
     * looks along -Z, from +Z */
    double yaw, pitch; /* degrees; pitch -89..89, positive from above */
    double distance;   /* 0: so that the grid fits */
    double fov;        /* vertical, degrees */
    /* environment */
    double turn; /* degrees about +Y, counter-clockwise seen from above */
    bool sky;    /* show it; else the background is black */
    /* display */
    double ev; /* exposure 2^ev */
    view_tone tone;
    bool false_colour; /* of luminance, in place of tone mapping */
    /* inspection */
    view_layout layout;
    int level;
    double zoom, pan[2];
    /* truth */
    view_compare compare;
    double split; /* 0..1 of the width */
    double gain;  /* of differences */
    /* scene */
    double seconds;        /* where what moves is */
    bool parallax;         /* reflections of the room's walls, not of what is
                              infinitely far */
    bool blend;            /* probes, over the widths at their borders */
    int probes;            /* local ones, 0..VIEW_MAX_LOCALS */
    int probe_size;        /* of faces: a power of two */
    double probe_interval; /* seconds; 0: every frame */
    int probe_faces;       /* steps of view_capture_update a frame; 0: all */
    view_probe_capture probe_capture;
    view_probe_filter probe_filter;
    bool spread;          /* local probes are captured one a frame */
    bool probe_limit;     /* a probe sees what it is for alone */
    bool volumes;         /* of probes are drawn as wires */
    bool sun;             /* the environment's, as a light with shadows */
    bool capture_shadows; /* in captures too */
    bool help;            /* the list of keys is shown */
} view_settings;

view_settings view_settings_default(void);

/* Names for options and titles, by the enumeration; NULL after the last. */
extern const char *const view_mode_names[VIEW_MODES + 1];
extern const char *const view_layout_names[VIEW_LAYOUTS + 1];
extern const char *const view_tone_names[VIEW_TONES + 1];
extern const char *const view_diffuse_names[VIEW_DIFFUSES + 1];
extern const char *const view_compare_names[VIEW_COMPARES + 1];
extern const char *const view_probe_filter_names[VIEW_PROBE_FILTERS + 1];
extern const char *const view_probe_capture_names[VIEW_PROBE_CAPTURES + 1];

#endif
