/* SPDX-License-Identifier: MIT */
#include "view/gl.h"

#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "common/path.h"
#include "common/signals.h"
#include "engine/picture.h"
#include "view/message.h"

view_gl gl;

static GLuint nothing; /* a vertex array without attributes */
static GLuint timers[2];
static GLuint block_buffers[VIEW_BLOCKS];

/* Programs of this context. */
static struct {
    char *text; /* files and defines */
    GLuint program;
} * programs;
static int program_count;

/* Blending with the part of the pixel that alpha says is covered, in pictures
 * whose colours are times their alpha. */
static void blend_over(void)
{
    gl.BlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE,
                         GL_ONE_MINUS_SRC_ALPHA);
}

bool view_gl_load(view_gl_proc *(*get)(const char *name))
{
    /* ISO C converts between types of functions, but not through void *. */
#define VIEW_GL_FIND(name)                                                     \
    gl.name = (__typeof__(gl.name))get("gl" #name);                            \
    if (!gl.name)                                                              \
        return view_fail("this OpenGL has no gl" #name                         \
                         ": its driver is too old or broken");
    VIEW_GL_FUNCTIONS(VIEW_GL_FIND)
#undef VIEW_GL_FIND
    gl.GenVertexArrays(1, &nothing);
    gl.GenQueries(2, timers);
    gl.GenBuffers(VIEW_BLOCKS, block_buffers);
    while (program_count)
        free(programs[--program_count].text);
    gl.Enable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    blend_over();
    return true;
}

void view_gl_bind(int unit, GLenum target, GLuint texture)
{
    gl.ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl.BindTexture(target, texture);
}

void view_gl_filter(GLenum target, GLint filtering, int levels)
{
    const bool mips = filtering == GL_LINEAR && levels > 1;

    gl.TexParameteri(target, GL_TEXTURE_BASE_LEVEL, 0);
    gl.TexParameteri(target, GL_TEXTURE_MAX_LEVEL, levels - 1);
    gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, filtering);
    gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER,
                     mips ? GL_LINEAR_MIPMAP_LINEAR : filtering);
    gl.TexParameteri(target, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(target, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(target, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
}

GLuint view_gl_buffer(GLenum target, size_t bytes, const void *data)
{
    GLuint buffer;

    gl.GenBuffers(1, &buffer);
    gl.BindBuffer(target, buffer);
    gl.BufferData(target, (GLsizeiptr)bytes, data,
                  data ? GL_STATIC_DRAW : GL_DYNAMIC_DRAW);
    return buffer;
}

void view_gl_attribute(GLuint at, int size, size_t stride, size_t offset)
{
    gl.EnableVertexAttribArray(at);
    gl.VertexAttribPointer(at, size, GL_FLOAT, GL_FALSE, (GLsizei)stride,
                           (const void *)(uintptr_t)offset);
}

void view_gl_block(int block, const void *data, size_t bytes)
{
    gl.BindBufferBase(GL_UNIFORM_BUFFER, (GLuint)block, block_buffers[block]);
    gl.BufferData(GL_UNIFORM_BUFFER, (GLsizeiptr)bytes, data, GL_STREAM_DRAW);
}

void view_gl_draw_quads(GLuint program, int count)
{
    gl.UseProgram(program);
    gl.BindVertexArray(nothing);
    gl.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, count);
}

void view_gl_draw_full(GLuint program)
{
    gl.UseProgram(program);
    gl.BindVertexArray(nothing);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

void view_gl_time_begin(void)
{
    gl.QueryCounter(timers[0], GL_TIMESTAMP);
}

double view_gl_time_end(void)
{
    GLuint64 ns[2] = {0, 0};

    gl.QueryCounter(timers[1], GL_TIMESTAMP);
    for (int i = 0; i < 2; i++)
        gl.GetQueryObjectui64v(timers[i], GL_QUERY_RESULT, &ns[i]);
    return 1e-6 * (double)(ns[1] - ns[0]);
}

bool view_gl_check(const char *where)
{
    const GLenum error = gl.GetError();

    return error == GL_NO_ERROR ||
           view_fail("%s: OpenGL has %s 0x%04x", where,
                     error == GL_OUT_OF_MEMORY ? "no memory" : "the error",
                     error);
}

/* ---- shaders ----------------------------------------------------------- */

enum {
    LOG_BYTES = 4096
};

/* Says the first line of an error rather than a warning. */
static void fail(const char *name, const char *log)
{
    const char *line = strstr(log, "rror");

    while (line && line > log && line[-1] != '\n')
        line--;
    line = line ? line : log;
    view_fail("shader %s: %.*s", name, (int)strcspn(line, "\n"), line);
}

/* Binds uniform blocks and samplers, which never changes. */
static void bind(GLuint program)
{
    static const char *const blocks[VIEW_BLOCKS] = {"Frame", "Room",
                                                    "Material"};
#define VIEW_SAMPLER(unit, name) name,
    static const char *const samplers[] = {VIEW_UNITS(VIEW_SAMPLER)};

    for (GLuint i = 0; i < VIEW_BLOCKS; i++) {
        const GLuint block = gl.GetUniformBlockIndex(program, blocks[i]);
        if (block != GL_INVALID_INDEX)
            gl.UniformBlockBinding(program, block, i);
    }
    gl.UseProgram(program);
    for (int i = 0; i < VIEW_UNIT_COUNT; i++)
        gl.Uniform1i(gl.GetUniformLocation(program, samplers[i]), i);
    gl.UseProgram(0);
}

GLuint view_program_from(const view_shader_file *files, const char *defines,
                         const char *vertex_file, const char *fragment_file)
{
    const GLuint program = gl.CreateProgram();
    char log[LOG_BYTES] = "the compiler does not say why";
    GLint ok = 1;

    for (int i = 0; i < 2 && ok; i++) {
        const char *name = i ? fragment_file : vertex_file;
        const view_shader_file *file = files;
        while (strcmp(file->name, name) != 0)
            file++;
        const char *text[] = {
            "#version 330 core\n"
            "#extension GL_ARB_texture_cube_map_array : enable\n",
            defines, file->text};
        const GLuint shader =
            gl.CreateShader(i ? GL_FRAGMENT_SHADER : GL_VERTEX_SHADER);
        gl.ShaderSource(shader, 3, text, NULL);
        gl.CompileShader(shader);
        gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
        if (!ok) {
            gl.GetShaderInfoLog(shader, sizeof log, NULL, log);
            fail(name, log);
        }
        gl.AttachShader(program, shader);
        gl.DeleteShader(shader); /* with the program */
    }
    if (ok) {
        gl.LinkProgram(program);
        gl.GetProgramiv(program, GL_LINK_STATUS, &ok);
        if (!ok) {
            gl.GetProgramInfoLog(program, sizeof log, NULL, log);
            fail(fragment_file, log);
        }
    }
    if (ok) {
        bind(program);
        return program;
    }
    gl.DeleteProgram(program);
    return 0;
}

GLuint view_program(const char *defines, const char *vertex_file,
                    const char *fragment_file)
{
    char text[1024];

    snprintf(text, sizeof text, "%s %s\n%s", vertex_file, fragment_file,
             defines);
    for (int i = 0; i < program_count; i++)
        if (!strcmp(programs[i].text, text))
            return programs[i].program;
    const GLuint program = view_program_from(view_shader_files, defines,
                                             vertex_file, fragment_file);
    if (!program)
        return 0;
    programs = ibl_need(
        realloc(programs, (size_t)(program_count + 1) * sizeof *programs));
    programs[program_count].text = ibl_need(strdup(text));
    programs[program_count++].program = program;
    return program;
}

/* ---- textures ---------------------------------------------------------- */

bool view_gl_takes(GLenum limit, int width, int height, const char *name)
{
    GLint most = 0;

    gl.GetIntegerv(limit, &most);
    return (width <= most && height <= most) ||
           view_fail("%s: %d x %d texels, and this OpenGL takes %d x %d at "
                     "most: make it smaller",
                     name, width, height, (int)most, (int)most);
}

GLuint view_upload(const ibl_texture *tex, bool cubes, const char *name)
{
    const GLenum target = cubes                     ? GL_TEXTURE_CUBE_MAP_ARRAY
                          : tex->faces == IBL_FACES ? GL_TEXTURE_CUBE_MAP
                          : tex->layers > 1         ? GL_TEXTURE_2D_ARRAY
                                                    : GL_TEXTURE_2D;
    const ibl_pixel_numbers as = ibl_pixel_numbers_of(tex->pixel);
    GLuint texture = 0;

    if (!view_gl_takes(tex->faces == 1 ? GL_MAX_TEXTURE_SIZE
                                       : GL_MAX_CUBE_MAP_TEXTURE_SIZE,
                       tex->width, tex->height, name))
        return 0;
    gl.GenTextures(1, &texture);
    gl.BindTexture(target, texture);
    for (int level = 0; level < tex->levels; level++) {
        const int w = ibl_cube_edge(tex->width, level);
        const int h = ibl_cube_edge(tex->height, level);
        if (target == GL_TEXTURE_CUBE_MAP_ARRAY ||
            target == GL_TEXTURE_2D_ARRAY)
            gl.TexImage3D(target, level, (GLint)as.gl_internal, w, h,
                          tex->layers * tex->faces, 0, as.gl_format, as.gl_type,
                          tex->data + ibl_texture_offset(tex, level, 0));
        else
            for (int face = 0; face < tex->faces; face++)
                gl.TexImage2D(target == GL_TEXTURE_2D
                                  ? target
                                  : GL_TEXTURE_CUBE_MAP_POSITIVE_X +
                                        (GLenum)face,
                              level, (GLint)as.gl_internal, w, h, 0,
                              as.gl_format, as.gl_type,
                              tex->data + ibl_texture_offset(tex, level, face));
    }
    view_gl_filter(target, GL_LINEAR, tex->levels);
    if (view_gl_check(name))
        return texture;
    gl.DeleteTextures(1, &texture);
    return 0;
}

GLuint view_upload_map(const baked_set *set)
{
    const ibl_image *map = view_set_source(set);

    if (!map)
        return 0;
    const GLuint texture =
        view_float_image(GL_RGB, map->width, map->height, map->data);
    view_gl_filter(GL_TEXTURE_2D, GL_LINEAR, 1);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
    return texture;
}

GLuint view_float_image(GLenum format, int width, int height,
                        const float *texels)
{
    const GLint internal = format == GL_RED    ? GL_R32F
                           : format == GL_RGB  ? GL_RGB32F
                           : format == GL_RGBA ? GL_RGBA32F
                                               : GL_DEPTH_COMPONENT24;
    GLuint texture = 0;

    gl.GenTextures(1, &texture);
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexImage2D(GL_TEXTURE_2D, 0, internal, width, height, 0, format,
                  GL_FLOAT, texels);
    view_gl_filter(GL_TEXTURE_2D, GL_NEAREST, 1);
    return texture;
}

void view_image_free(view_image *i)
{
    gl.DeleteFramebuffers(1, &i->framebuffer);
    gl.DeleteTextures(1, &i->texture);
    gl.DeleteTextures(1, &i->depth);
    *i = (view_image){0};
}

bool view_image_make(view_image *i, int width, int height)
{
    if (i->width == width && i->height == height)
        return true;
    view_image_free(i);
    gl.ActiveTexture(GL_TEXTURE0 + VIEW_UNIT_PICTURE);
    i->depth = view_float_image(GL_DEPTH_COMPONENT, width, height, NULL);
    i->texture = view_float_image(GL_RGBA, width, height, NULL);
    gl.GenFramebuffers(1, &i->framebuffer);
    gl.BindFramebuffer(GL_FRAMEBUFFER, i->framebuffer);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D,
                            i->depth, 0);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                            i->texture, 0);
    if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        return view_fail("this OpenGL cannot draw into a picture of %d x %d "
                         "floats: ask for a smaller one",
                         width, height);
    i->width = width;
    i->height = height;
    return view_gl_check("making a picture");
}

void view_image_begin(const view_image *i)
{
    gl.BindFramebuffer(GL_FRAMEBUFFER, i->framebuffer);
    gl.Viewport(0, 0, i->width, i->height);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
}

bool view_mean_add(const view_image *picture, float part, view_image *mean)
{
    const GLuint program =
        view_program("#define COPY\n", "full.vert", "display.frag");

    if (!program || !view_image_make(mean, picture->width, picture->height))
        return false;
    view_image_begin(mean);
    view_gl_bind(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture->texture);
    gl.BlendColor(0, 0, 0, part);
    gl.BlendFunc(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
    if (part < 1) /* else the mean may hold NaN */
        gl.Enable(GL_BLEND);
    view_gl_draw_full(program);
    gl.Disable(GL_BLEND);
    blend_over();
    return true;
}

/* ---- pictures ---------------------------------------------------------- */

void view_picture_flip(void *pixels, size_t row_bytes, int height)
{
    for (int i = 0; i < height / 2; i++) {
        unsigned char *a = (unsigned char *)pixels + (size_t)i * row_bytes;
        unsigned char *b = a + (size_t)(height - 1 - 2 * i) * row_bytes;
        for (size_t x = 0; x < row_bytes; x++) {
            const unsigned char kept = a[x];
            a[x] = b[x];
            b[x] = kept;
        }
    }
}

unsigned char *view_picture_read(GLuint framebuffer, int width, int height,
                                 int channels)
{
    const size_t row_bytes = (size_t)channels * (size_t)width;
    unsigned char *pixels = ibl_need(malloc(row_bytes * (size_t)height));

    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    gl.ReadPixels(0, 0, width, height, channels == 3 ? GL_RGB : GL_RGBA,
                  GL_UNSIGNED_BYTE, pixels);
    view_picture_flip(pixels, row_bytes, height);
    return pixels;
}

bool view_picture_is_linear(const char *path)
{
    const size_t length = strlen(path);

    return length > 4 && !strcasecmp(path + length - 4, ".exr");
}

bool view_picture_write(ibl_ctx *ctx, const char *path, int width, int height,
                        int channels, const void *pixels)
{
    static const ibl_picture_options exr = {.kind = IBL_PICTURE_EXR};
    ibl_outputs *outputs = NULL;
    ibl_blob file = {0};
    bool ok;

    if (view_picture_is_linear(path))
        ok = !ibl_picture_encode(ctx, path, &exr, width, height, pixels, &file);
    else
        ok = ibl_png_encode(pixels, channels, width, height, NULL, &file) ||
             view_fail("%s: no memory for a PNG of %d x %d pixels", path, width,
                       height);
    ok = ok && !ibl_outputs_create(ctx, 0, &outputs) &&
         !ibl_outputs_add(outputs, path, file.bytes, file.size) &&
         !ibl_outputs_commit(outputs);
    ibl_outputs_free(outputs);
    ibl_blob_free(&file);
    return ok;
}

char *view_picture_name(const char *path, int number)
{
    const char *dot = strrchr(ibl_path_name(path), '.');
    char *name = NULL;

    dot = dot ? dot : path + strlen(path);
    ibl_append(&name, "%.*s-%03d%s", (int)(dot - path), path, number, dot);
    return name;
}

/* ---- pictures in memory ------------------------------------------------ */

/* From EGL/egl.h and eglext.h, which need not be installed, and GL/osmesa.h,
 * which cannot be included with GL/glcorearb.h. */
enum {
    EGL_PBUFFER_BIT = 1,
    EGL_OPENGL_BIT = 8,
    EGL_ALPHA_SIZE = 0x3021,
    EGL_SURFACE_TYPE = 0x3033,
    EGL_NONE = 0x3038,
    EGL_RENDERABLE_TYPE = 0x3040,
    EGL_HEIGHT = 0x3056,
    EGL_WIDTH,
    EGL_CONTEXT_MAJOR_VERSION = 0x3098,
    EGL_OPENGL_API = 0x30A2,
    EGL_CONTEXT_MINOR_VERSION = 0x30FB,
    EGL_CONTEXT_OPENGL_PROFILE_MASK = 0x30FD,
    EGL_PLATFORM_DEVICE_EXT = 0x313F,
    OSMESA_PROFILE = 0x33,
    OSMESA_CORE_PROFILE = 0x34,
    OSMESA_CONTEXT_MAJOR_VERSION = 0x36,
    OSMESA_CONTEXT_MINOR_VERSION = 0x37,
    DEVICES = 16
};

/* clang-format off */
#define EGL_CALLS(X)                                                           \
    X(unsigned, eglQueryDevicesEXT, (int most, void **devices, int *count))    \
    X(void *, eglGetPlatformDisplayEXT, (int kind, void *of, const int *list)) \
    X(unsigned, eglInitialize, (void *display, int *major, int *minor))        \
    X(unsigned, eglTerminate, (void *display))                                 \
    X(unsigned, eglBindAPI, (unsigned api))                                    \
    X(unsigned, eglChooseConfig, (void *display, const int *list,              \
                                  void **configs, int most, int *count))       \
    X(void *, eglCreateContext, (void *display, void *config, void *share,     \
                                 const int *list))                             \
    X(void *, eglCreatePbufferSurface, (void *display, void *config,           \
                                        const int *list))                      \
    X(unsigned, eglMakeCurrent, (void *display, void *draw, void *read,        \
                                 void *context))
#define OSMESA_CALLS(X)                                                        \
    X(void *, OSMesaCreateContextAttribs, (const int *list, void *share))      \
    X(void, OSMesaDestroyContext, (void *context))                             \
    X(GLboolean, OSMesaMakeCurrent, (void *context, void *buffer, GLenum type, \
                                     GLsizei width, GLsizei height))
/* clang-format on */
#define POINTER(type, name, arguments) static type(*name) arguments;
EGL_CALLS(POINTER)
OSMESA_CALLS(POINTER)

/* The screen that is open. */
static const char *by = "GLFW";
static void *display; /* EGL's, or NULL */
static void *context; /* OSMesa's, or NULL */
static void *pixels;  /* its framebuffer 0, RGBA, rows from the bottom */
static view_gl_proc *(*get)(const char *name); /* its functions */

const char *view_screen_by(void)
{
    return by;
}

/* POSIX lets dlsym return a function; C has no cast for it. */
static bool find(void *library, const char *name, void *call)
{
    void *symbol = dlsym(library, name);
    memcpy(call, &symbol, sizeof symbol);
    return symbol != NULL;
}

void view_screen_close(void)
{
    if (display) {
        eglMakeCurrent(display, NULL, NULL, NULL);
        eglTerminate(display);
    }
    if (context) {
        OSMesaMakeCurrent(NULL, NULL, 0, 0, 0);
        OSMesaDestroyContext(context);
    }
    free(pixels);
    display = context = pixels = NULL;
    by = "GLFW";
}

static bool open_device(void *device, int width, int height, bool software)
{
    static const int wanted[][2] = {{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT},
                                    {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT},
                                    {EGL_ALPHA_SIZE, 8},
                                    {EGL_NONE}};
    static const int core[][2] = {{EGL_CONTEXT_MAJOR_VERSION, 3},
                                  {EGL_CONTEXT_MINOR_VERSION, 3},
                                  {EGL_CONTEXT_OPENGL_PROFILE_MASK, 1},
                                  {EGL_NONE}};
    const int size[] = {EGL_WIDTH, width, EGL_HEIGHT, height, EGL_NONE};
    void *config, *made, *surface;
    int count = 0;

    display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, NULL);
    if (!display || !eglInitialize(display, NULL, NULL) ||
        !eglBindAPI(EGL_OPENGL_API) ||
        !eglChooseConfig(display, *wanted, &config, 1, &count) || !count)
        return false;
    made = eglCreateContext(display, config, NULL, *core);
    surface = eglCreatePbufferSurface(display, config, size);
    return made && surface && eglMakeCurrent(display, surface, surface, made) &&
           view_gl_load(get) &&
           (software ||
            !strstr((const char *)gl.GetString(GL_RENDERER), "llvmpipe"));
}

/* Opens the first GPU of the system, in silence if there is none. */
static bool open_egl(void *library, int width, int height, bool software)
{
    void *devices[DEVICES];
    int count = 0;

    if (!find(library, "eglGetProcAddress", &get))
        return false;
#define EGL_FIND(type, name, arguments)                                        \
    name = (__typeof__(name))get(#name);                                       \
    if (!name)                                                                 \
        return false;
    EGL_CALLS(EGL_FIND)
    eglQueryDevicesEXT(DEVICES, devices, &count);
    for (int i = 0; i < count; i++) {
        if (open_device(devices[i], width, height, software))
            return true;
        view_screen_close();
    }
    return false;
}

/* By default OSMesa draws RGBA without depth or stencil. It loads LLVM, which
 * does not survive being unloaded. */
static bool open_osmesa(void *library, int width, int height)
{
    static const int core[][2] = {{OSMESA_PROFILE, OSMESA_CORE_PROFILE},
                                  {OSMESA_CONTEXT_MAJOR_VERSION, 3},
                                  {OSMESA_CONTEXT_MINOR_VERSION, 3},
                                  {0}};
    bool ok = find(library, "OSMesaGetProcAddress", &get);

#define OSMESA_FIND(type, name, arguments)                                     \
    ok = ok && find(library, #name, &name);
    OSMESA_CALLS(OSMESA_FIND)
    context = ok ? OSMesaCreateContextAttribs(*core, NULL) : NULL;
    if (!context)
        return view_fail("this OSMesa has no OpenGL 3.3 core: update package "
                         "libosmesa6");
    pixels = ibl_need(calloc((size_t)width * (size_t)height, 4));
    return OSMesaMakeCurrent(context, pixels, GL_UNSIGNED_BYTE, width, height)
               ? view_gl_load(get)
               : view_fail("OSMesa does not draw pictures of %d x %d pixels: "
                           "ask for a smaller one",
                           width, height);
}

/* Where no driver has made one of these there is no GPU, and loading EGL would
 * take longer than a small picture. */
static bool has_gpu(void)
{
    return !access("/dev/dri", F_OK) || !access("/dev/nvidiactl", F_OK) ||
           !access("/dev/dxg", F_OK);
}

bool view_screen_memory(int width, int height, const char *const *libraries)
{
    static const char *const usual[] = {"libEGL.so.1", "libOSMesa.so.8",
                                        "libOSMesa.so.6", "libOSMesa.so", NULL};

    for (const char *const *l = libraries ? libraries : usual; *l; l++) {
        const bool egl = !strncmp(*l, "libEGL", 6);
        void *library = egl && !libraries && !has_gpu()
                            ? NULL
                            : dlopen(*l, RTLD_NOW | RTLD_LOCAL);
        if (!library)
            continue;
        const bool ok = egl ? open_egl(library, width, height, libraries)
                            : open_osmesa(library, width, height);
        if (!ok)
            view_screen_close();
        if (ok)
            by = egl ? "EGL" : "OSMesa";
        if (ok || !egl)
            return ok;
    }
    return view_fail("pictures without a display need OSMesa: install package "
                     "libosmesa6");
}
