/* SPDX-License-Identifier: MIT */
/* The user interface, by Dear ImGui: text on pictures, the panel, help and
 * messages, drawn by the viewer's own OpenGL with a window or without. ui.cpp
 * is the only C++ of the viewer. */
#ifndef VIEW_UI_H
#define VIEW_UI_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

struct GLFWwindow;
struct view_app;

/* Needs a current context. scale: pixels of a unit of text and of controls, 1
 * or more; text is 14 units high. Letters are those of DejaVu Sans (package
 * fonts-dejavu-core) or, without it, ImGui's own. One at a time. False, with a
 * message. */
bool view_ui_make(double scale);
void view_ui_free(void);
/* Takes mouse and keys of a window; its callbacks that were set before are
 * called, too. */
void view_ui_attach(struct GLFWwindow *window);
/* Whether the pointer is over a window of the interface, or keys go to a field
 * of text. */
bool view_ui_has_pointer(void);
bool view_ui_has_keys(void);

/* What follows draws on a picture of that size, and appears in a framebuffer by
 * view_ui_end. */
void view_ui_begin(int width, int height);
void view_ui_end(unsigned framebuffer);

/* Draws text, in which \n ends a line, so that a point of it, in fractions of
 * its size from its upper left, is at x, y. */
void view_ui_text(double x, double y, const double point[2], const char *text);
/* A scale of that size with its values below: false colours with their stops
 * or, if most is above 0, greys from 0 to most. */
void view_ui_legend(double x, double y, double width, double most);

/* False colours: a spiral through the colour cube whose perceived brightness
 * rises evenly (Green 2011), over stops around middle grey, 0.18. Each stop is
 * a step, within which the colour changes half of the way to the next. Values
 * outside are striped black and blue, or white and red: shaders/tone.glsl. */
#define VIEW_STOPS 8 /* on either side of middle grey */

/* Panel, help, list of files, progress and messages. */
void view_ui_app(struct view_app *app);

#ifdef __cplusplus
}
#endif

#endif
