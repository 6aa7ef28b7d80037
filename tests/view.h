/* SPDX-License-Identifier: MIT */
/* What tests of the viewer share: a screen in memory, and what was said. */
#ifndef TEST_VIEW_H
#define TEST_VIEW_H

#include <stdbool.h>

#include "test.h"
#include "view/app.h"
#include "view/gl.h"

/* Opens a screen in memory until the running test has ended, with gl loaded.
 * The test is skipped where there is no OSMesa, and under the thread
 * sanitizer. */
void view_test_begin(int width, int height);
void view_test_close(void); /* also without a screen */

/* The text of one of the viewer's shaders. */
const char *view_test_shader(const char *name);

/* A program of this fragment shader for all of what is drawn into. */
GLuint view_test_program(const char *fragment);

/* A context for the running test, with the viewer's log; exits on failure. */
ibl_ctx *view_test_ctx(int threads);

/* A window without OpenGL, by the default settings, with a white set; both must
 * last until the running test has ended. */
void view_test_app(view_app *app, view_options *options, int width, int height);

/* Draws a state, where it compares against the reference, at the lower left of
 * framebuffer 0. */
bool view_test_draw(view_renderer *r, const view_settings *s, int width,
                    int height);

/* Keeps what is written to standard error, until view_test_caught gives it:
 * static storage, overwritten by the next call. */
void view_test_catch(void);
const char *view_test_caught(void);

/* Green 2011, eq. 2: the sRGB-encoded false colour of -VIEW_STOPS .. VIEW_STOPS
 * stops from middle grey. */
void view_test_false_colour(double stops, double srgb[3]);

/* Unit direction through the centre of pixel (x, y), row 0 on top. */
void view_test_ray(const view_camera *c, int width, int height, double x,
                   double y, double direction[3]);
/* Index of the nearest sphere along the ray, and its normal at the hit; -1:
 * none. normal may be NULL. */
int view_test_hit(const view_sphere *spheres, int count, const double eye[3],
                  const double direction[3], double normal[3]);

#endif
