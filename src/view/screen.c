/* SPDX-License-Identifier: MIT */
/* OSMesa: OpenGL drawn by the processor into memory. It is opened only on
 * demand: it loads LLVM, which does not survive being unloaded. */
#include "view/screen.h"
#include "common/signals.h"
#include "view/gl.h"
#include "view/message.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

/* From GL/osmesa.h, which cannot be included with GL/glcorearb.h. */
enum {
    OSMESA_PROFILE = 0x33,
    OSMESA_CORE_PROFILE = 0x34,
    OSMESA_CONTEXT_MAJOR_VERSION = 0x36,
    OSMESA_CONTEXT_MINOR_VERSION = 0x37
};

typedef struct osmesa_context osmesa_context;

typedef struct osmesa_calls {
    osmesa_context *(*create)(const int *attributes, osmesa_context *share);
    void (*destroy)(osmesa_context *context);
    GLboolean (*make_current)(osmesa_context *context, void *buffer,
                              GLenum type, GLsizei width, GLsizei height);
    view_gl_proc *(*get)(const char *name);
} osmesa_calls;

struct view_screen {
    osmesa_calls call;
    osmesa_context *context;
    unsigned char *pixels; /* framebuffer 0, RGBA, rows from the bottom */
    int width, height;
};

/* POSIX lets dlsym return a function; C has no cast for it. */
static bool find(void *library, const char *name, void *call)
{
    void *symbol = dlsym(library, name);
    memcpy(call, &symbol, sizeof symbol);
    return symbol != NULL;
}

static bool load(const char *const *names, osmesa_calls *call)
{
    void *library = NULL;

    for (int i = 0; names[i] && !library; i++)
        library = dlopen(names[i], RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return view_fail("pictures without a display need OSMesa, and %s "
                         "cannot be opened: install package libosmesa6",
                         names[0]);
    if (!find(library, "OSMesaCreateContextAttribs", &call->create) ||
        !find(library, "OSMesaDestroyContext", &call->destroy) ||
        !find(library, "OSMesaMakeCurrent", &call->make_current) ||
        !find(library, "OSMesaGetProcAddress", &call->get))
        return view_fail("this OSMesa is older than 11.2: update package "
                         "libosmesa6");
    return true;
}

void view_screen_close(view_screen *s)
{
    if (!s)
        return;
    if (s->context) {
        s->call.make_current(NULL, NULL, 0, 0, 0);
        s->call.destroy(s->context);
    }
    free(s->pixels);
    free(s);
}

/* OSMesa accepts any size, and draws only what fits OpenGL's limits. */
static bool fits(const view_screen *s)
{
    GLint texture = 0, viewport[2] = {0, 0};

    gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
    gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    const int most_x = texture < viewport[0] ? texture : viewport[0];
    const int most_y = texture < viewport[1] ? texture : viewport[1];
    if (s->width <= most_x && s->height <= most_y)
        return true;
    return view_fail("this OSMesa draws pictures of up to %d x %d pixels, not "
                     "%d x %d: ask for a smaller one",
                     most_x, most_y, s->width, s->height);
}

/* By default OSMesa draws RGBA without depth or stencil. */
static bool open_context(view_screen *s)
{
    static const int attributes[] = {OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     3,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     3,
                                     0};

    s->context = s->call.create(attributes, NULL);
    if (!s->context)
        return view_fail("this OSMesa has no OpenGL 3.3 core: update package "
                         "libosmesa6");
    if (!s->call.make_current(s->context, s->pixels, GL_UNSIGNED_BYTE, s->width,
                              s->height))
        return view_fail("OSMesa does not draw pictures of %d x %d pixels: "
                         "ask for a smaller one",
                         s->width, s->height);
    return view_gl_load(s->call.get) && fits(s);
}

view_screen *view_screen_memory(int width, int height,
                                const char *const *libraries)
{
    static const char *const usual[] = {"libOSMesa.so.8", "libOSMesa.so.6",
                                        "libOSMesa.so", NULL};
    view_screen *s = ibl_need(calloc(1, sizeof *s));

    s->width = width, s->height = height;
    s->pixels = ibl_need(calloc((size_t)width * (size_t)height, 4));
    if (load(libraries ? libraries : usual, &s->call) && open_context(s))
        return s;
    view_screen_close(s);
    return NULL;
}
