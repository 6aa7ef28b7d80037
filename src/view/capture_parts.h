/* SPDX-License-Identifier: MIT */
/* What the files of view/capture.h share. */
#ifndef VIEW_CAPTURE_PARTS_H
#define VIEW_CAPTURE_PARTS_H

#include "view/capture.h"
#include "view/program.h"

enum {
    VIEW_CAPTURE_DRAWING,
    VIEW_CAPTURE_LEVELS,
    VIEW_CAPTURE_DIFFUSE,
    VIEW_CAPTURE_PARTS
};

/* A program that fills a face. */
typedef struct view_capture_pass {
    GLuint program;
    GLint face, edge, row, count, spread, rings;
} view_capture_pass;

typedef struct view_capture_set {
    GLuint specular, irradiance;
} view_capture_set;

struct view_capture {
    view_capture_options options; /* levels resolved */
    view_capture_pass face, paraboloid, mip, blur, lobe, equirect;
    GLuint corners;         /* vertex array without attributes */
    GLuint picture[2];      /* RGBA32F: one, or two paraboloids */
    GLuint depth, drawn[2]; /* their depth, framebuffers */
    GLuint target, source;  /* framebuffers of what is drawn and copied */
    GLuint halved;          /* cube of half the edge, one level */
    GLuint lookup;          /* cube with blurred levels from 1 on */
    GLuint samples;         /* a row of it for each level from 1 on, one for
                               irradiance */
    view_capture_set set[2];
    int shown; /* of the sets */
    int step;  /* that is next */
    bool failed;
    double position[3];
    double doing[VIEW_CAPTURE_PARTS], ms[VIEW_CAPTURE_PARTS];
};

/* Levels of the lookups: the last has four texels along an edge. */
int view_capture_lookups(int size);
/* Of a lookup in a level from 1 on, variance along an axis, in mean solid
 * angles of a texel there. So wide that texels, up to 5 times as large in the
 * middle of faces as in corners, do not show. */
#define VIEW_CAPTURE_BLUR (5.0 / 3)

/* What OpenGL has that is not the capture's, from begin to end. */
typedef struct view_capture_state {
    GLint framebuffer, viewport[4];
} view_capture_state;
view_capture_state view_capture_begin(const view_capture *c);
void view_capture_end(const view_capture_state *state);

/* The set that is not shown. */
view_capture_set *view_capture_back(view_capture *c);

/* A pass into a face of a level of a cube, n x n, from what is bound to
 * VIEW_CAPTURE_UNIT and VIEW_CAPTURE_UNIT_MORE. */
void view_capture_fill(const view_capture *c, const view_capture_pass *pass,
                       GLuint cube, int level, int face, int n);

/* Makes c->samples. False: no memory, with a message. */
bool view_capture_make_samples(view_capture *c);
/* Samples of an irradiance texel. */
int view_capture_diffuse_samples(const view_capture *c);

/* Level 0 of set through the library into its levels from 1 on and its
 * irradiance. False, with a message, and they are as they were. */
bool view_capture_by_library(view_capture *c, ibl_ctx *ctx,
                             const view_capture_set *set);

#endif
