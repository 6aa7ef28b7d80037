/* SPDX-License-Identifier: MIT */
/* The viewer's ground: OpenGL in memory, shaders, pictures and their files. */
#include "view.h"

#include "files.h"
#include "sets.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/picture.h"
#include "view/program.h"
#include "view/renderer.h"
#include "view/screen.h"
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

/* ---- shaders of this test -------------------------------------------- */

static const view_shader_file shaders[] = {
    {"whole.vert",
     {"// One triangle over the screen.\n"
      "void main() {\n"
      "    vec2 p = vec2(gl_VertexID & 1, gl_VertexID >> 1);\n"
      "    gl_Position = vec4(4.0 * p - 1.0, 0.0, 1.0);\n"
      "}\n"}},
    {"place.frag",
     {"const float ALL = 255.0;\n",
      "vec4 of(vec2 at) { return vec4(at / ALL, 0.25, 1.0); }\n",
      "out vec4 colour;\n"
      "void main() { colour = of(gl_FragCoord.xy); }\n"}},
    {"unlinked.frag",
     {"vec4 nowhere();\n"
      "out vec4 colour;\n"
      "void main() { colour = nowhere(); }\n"}},
    {"units.frag",
     {"uniform samplerCube specular_map;\n"
      "uniform sampler2D lut_map, picture;\n"
      "layout(std140) uniform Frame { vec4 shade; };\n"
      "out vec4 colour;\n"
      "void main() {\n"
      "    colour = texture(specular_map, shade.xyz) +\n"
      "        texture(lut_map, shade.xy) +\n"
      "        texture(picture, shade.xy);\n"
      "}\n"}},
    {NULL, {NULL}},
};

static void draw_whole(GLuint program, int width, int height)
{
    GLuint array;

    gl.GenVertexArrays(1, &array);
    gl.BindVertexArray(array);
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl.Viewport(0, 0, width, height);
    gl.UseProgram(program);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    gl.UseProgram(0);
    gl.DeleteVertexArrays(1, &array);
}

/* ---- the context ----------------------------------------------------- */

TEST(context)
{
    int major = 0, minor = 0;

    view_test_begin(16, 8);
    gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    CHECK_MSG(10 * major + minor >= 33, "OpenGL %d.%d", major, minor);
    CHECK(view_gl_check("context"));
    view_test_close();

    view_screen *screen = view_screen_memory(31, 7, NULL);
    GLint viewport[4];
    NEED(screen);
    gl.GetIntegerv(GL_VIEWPORT, viewport);
    CHECK(viewport[2] == 31 && viewport[3] == 7);
    view_screen_close(screen);
    view_screen_close(NULL);
}

TEST(library_missing)
{
    static const char *const names[] = {"libNoSuchMesa.so.8", NULL};
    static const char *const others[] = {"libm.so.6", NULL};

    view_test_catch();
    CHECK(!view_screen_memory(8, 8, names));
    const char *said = view_test_caught();
    CHECK_MSG(!strcmp(said, "iblview: pictures without a display need OSMesa, "
                            "and libNoSuchMesa.so.8 cannot be opened: install "
                            "package libosmesa6\n"),
              "%s", said);
    view_test_catch();
    CHECK(!view_screen_memory(8, 8, others));
    said = view_test_caught();
    CHECK_MSG(strstr(said, "older than 11.2"), "%s", said);
}

TEST(too_large)
{
    view_test_begin(8, 8);
    view_test_close();
    view_test_catch();
    CHECK(!view_screen_memory(40000, 2, NULL));
    const char *said = view_test_caught();
    CHECK_MSG(strstr(said, "not 40000 x 2: ask"), "%s", said);
    view_test_catch();
    CHECK(!view_screen_memory(2, 40000, NULL));
    said = view_test_caught();
    CHECK_MSG(strstr(said, "not 2 x 40000: ask"), "%s", said);
}

static const GLubyte *old_version(GLenum name)
{
    (void)name;
    return (const GLubyte *)"2.1 Mesa 7.0";
}

static view_gl_proc *old_get(const char *name)
{
    return strcmp(name, "glGetString") ? NULL : (view_gl_proc *)old_version;
}

TEST(version_too_old)
{
    view_test_catch();
    CHECK(!view_gl_load(old_get));
    const char *said = view_test_caught();
    CHECK_MSG(strstr(said, "3.3 core is needed, this is \"2.1 Mesa 7.0\""),
              "%s", said);
}

TEST(errors_of_gl)
{
    view_test_begin(8, 8);
    gl.Enable(0x1234);
    gl.Enable(0x1234);
    view_test_catch();
    CHECK(!view_gl_check("enabling"));
    const char *said = view_test_caught();
    CHECK_MSG(!strcmp(said, "iblview: enabling: OpenGL says invalid enum "
                            "(0x0500)\n"),
              "%s", said);
    CHECK(view_gl_check("enabling"));
}

/* ---- pictures -------------------------------------------------------- */

/* Odd sizes: rows without padding, and from the top. */
static void rows_of(int width, int height)
{
    int wrong = 0;

    view_test_begin(width, height);
    const GLuint program =
        view_program_from(shaders, "", "whole.vert", "place.frag");
    NEED(program);
    draw_whole(program, width, height);
    unsigned char *rgb = view_picture_read(0, width, height);
    NEED(rgb);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const unsigned char *p = rgb + 3 * (y * width + x);
            /* Pixel centres are halves; those round either way. */
            wrong += p[0] < fmin(x, 255) || p[0] > x + 1;
            wrong += p[1] < height - 1 - y || p[1] > height - y;
            wrong += p[2] != 64;
        }
    CHECK_MSG(wrong == 0, "%d components differ", wrong);
    free(rgb);
    CHECK(view_gl_check("drawing"));
}

/* Rows of some kilobytes, too. */
TEST(rows_from_the_top)
{
    rows_of(37, 21);
    rows_of(3001, 4);
}

TEST(written_and_read)
{
    enum {
        WIDTH = 45,
        HEIGHT = 33
    };
    unsigned char rgb[3 * WIDTH * HEIGHT], back[sizeof rgb];
    png_image image = {.version = PNG_IMAGE_VERSION};
    test_random r = {7};
    ibl_ctx *ctx = view_test_ctx(1);
    const char *path = file_path("picture.png");
    size_t size;

    for (size_t i = 0; i < sizeof rgb; i++)
        rgb[i] = (unsigned char)test_random_u64(&r);
    CHECK(view_picture_write(ctx, path, WIDTH, HEIGHT, rgb));
    NEED(png_image_begin_read_from_file(&image, path));
    CHECK(image.width == WIDTH && image.height == HEIGHT);
    CHECK(image.format == PNG_FORMAT_RGB);
    NEED(png_image_finish_read(&image, NULL, back, 0, NULL));
    CHECK(!memcmp(rgb, back, sizeof rgb));
    /* The chunk behind the header: length 1, name, intent. */
    unsigned char *bytes = file_load(path, &size);
    CHECK(size > 46 && !memcmp(bytes + 33, "\0\0\0\1sRGB", 8));
}

TEST(not_writable)
{
    const unsigned char rgb[3] = {1, 2, 3};
    ibl_ctx *ctx = view_test_ctx(1);

    view_test_catch();
    CHECK(!view_picture_write(ctx, file_path("none/picture.png"), 1, 1, rgb));
    const char *said = view_test_caught();
    CHECK_MSG(!strncmp(said, "iblview: ", 9) && strstr(said, "picture.png") &&
                  strchr(said, '\n') == said + strlen(said) - 1,
              "%s", said);
}

/* It draws the picture again: other windows may cover what is on the screen. */
TEST(picture_of_the_last_draw)
{
    enum {
        WIDTH = 32,
        HEIGHT = 24
    };
    const view_settings settings = view_settings_default();
    static baked_set set;

    view_test_begin(WIDTH, HEIGHT);
    sets_white(&set);
    view_renderer *r = view_renderer_create();
    CHECK(r && view_renderer_load(r, &set) &&
          view_renderer_draw(r, &settings, WIDTH, HEIGHT));
    unsigned char *shown = view_picture_read(0, WIDTH, HEIGHT);
    gl.ClearColor(1, 0, 1, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    unsigned char *rgb = view_renderer_picture(r);
    CHECK(shown && rgb && !memcmp(shown, rgb, (size_t)3 * WIDTH * HEIGHT));
    free(shown);
    free(rgb);
    view_renderer_free(r);
}

/* ---- shaders --------------------------------------------------------- */

TEST(shader_errors)
{
    static const struct {
        const char *fragment, *message;
    } cases[] = {
        {"unlinked.frag", "iblview: shader unlinked.frag: error: "},
        {"absent.frag", "iblview: shader absent.frag is not in the program\n"},
    };

    view_test_begin(8, 8);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        view_test_catch();
        CHECK(!view_program_from(shaders, "", "whole.vert", cases[i].fragment));
        const char *said = view_test_caught(), *message = cases[i].message;
        CHECK_MSG(!strncmp(said, message, strlen(message)), "%s", said);
        CHECK_MSG(strchr(said, '\n') == said + strlen(said) - 1, "%s", said);
    }
    view_test_catch();
    CHECK(!view_program("none.vert", "none.frag"));
    const char *said = view_test_caught();
    CHECK_MSG(strstr(said, "none.vert is not in the program"), "%s", said);
    CHECK(view_gl_check("shaders"));
}

/* Lines count from 1 in each file, whatever a shader includes. */
TEST(shader_errors_have_their_line)
{
    static const struct {
        const char *shader, *word, *file, *define;
    } cases[] = {
        {"display.frag", "TONE)", "display.frag", "#define TONE missing\n"},
        {"sphere.frag", "DIFFUSE ==", "maps.glsl", "#define DIFFUSE missing\n"},
    };

    view_test_begin(8, 8);
    for (int i = 0; i < 2; i++) {
        size_t size;
        const char *text = (const char *)file_load(
            test_text("src/view/shaders/%s", cases[i].file), &size);
        int line = 1;
        for (; strncmp(text, cases[i].word, strlen(cases[i].word)); text++)
            line += *text == '\n';
        view_test_catch();
        CHECK(!view_program_from(view_shader_files, cases[i].define,
                                 "full.vert", cases[i].shader));
        const char *said = view_test_caught();
        const char *want =
            test_text("iblview: shader %s: 0:%d(", cases[i].shader, line);
        CHECK_MSG(!strncmp(said, want, strlen(want)), "%s, not %s", said, want);
    }
}

/* A texture of one texel. */
static void texel(view_unit unit, GLenum kind, const unsigned char *rgba)
{
    const bool cube = kind == GL_TEXTURE_CUBE_MAP;
    GLuint texture;

    gl.GenTextures(1, &texture);
    gl.ActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    gl.BindTexture(kind, texture);
    for (GLenum face = 0; face < (cube ? 6 : 1); face++)
        gl.TexImage2D(cube ? GL_TEXTURE_CUBE_MAP_POSITIVE_X + face : kind, 0,
                      GL_RGBA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    gl.TexParameteri(kind, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
}

/* Samplers and the block get their places by name: the sum of the three
 * textures comes out, read where the block says. */
TEST(shader_units)
{
    static const unsigned char specular[4] = {10, 0, 0, 0};
    static const unsigned char lut[4] = {0, 20, 0, 0};
    static const unsigned char picture[4] = {0, 0, 30, 255};
    static const float shade[4] = {1, 0, 0, 1};
    GLuint block;

    view_test_begin(4, 4);
    const GLuint program =
        view_program_from(shaders, "", "whole.vert", "units.frag");
    NEED(program);
    texel(VIEW_UNIT_SPECULAR, GL_TEXTURE_CUBE_MAP, specular);
    texel(VIEW_UNIT_LUT, GL_TEXTURE_2D, lut);
    texel(VIEW_UNIT_PICTURE, GL_TEXTURE_2D, picture);
    gl.GenBuffers(1, &block);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, block);
    gl.BufferData(GL_UNIFORM_BUFFER, sizeof shade, shade, GL_STATIC_DRAW);
    draw_whole(program, 4, 4);
    unsigned char *rgb = view_picture_read(0, 4, 4);
    NEED(rgb);
    CHECK_MSG(rgb[0] == 10 && rgb[1] == 20 && rgb[2] == 30, "%d %d %d", rgb[0],
              rgb[1], rgb[2]);
    free(rgb);
    CHECK(view_gl_check("units"));
}

/* ---- messages -------------------------------------------------------- */

/* The library's numbers are those of Khronos' header, and OpenGL takes them. */
TEST(pixel_numbers)
{
    static const ibl_pixel_numbers known[IBL_PIXEL_COUNT] = {
        [IBL_PIXEL_RGBA16F] = {97, 10, GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT},
        [IBL_PIXEL_RGBA32F] = {109, 2, GL_RGBA32F, GL_RGBA, GL_FLOAT},
        [IBL_PIXEL_RGB9E5] = {123, 67, GL_RGB9_E5, GL_RGB,
                              GL_UNSIGNED_INT_5_9_9_9_REV},
        [IBL_PIXEL_R11G11B10F] = {122, 26, GL_R11F_G11F_B10F, GL_RGB,
                                  GL_UNSIGNED_INT_10F_11F_11F_REV},
        [IBL_PIXEL_BC6H] = {143, 95, GL_COMPRESSED_RGB_BPTC_UNSIGNED_FLOAT, 0,
                            0},
        [IBL_PIXEL_UASTC_HDR] = {1000066000, 0, 0, 0, 0},
        [IBL_PIXEL_ASTC4X4HDR] = {1000066000, 0,
                                  GL_COMPRESSED_RGBA_ASTC_4x4_KHR, 0, 0},
        [IBL_PIXEL_RG16F] = {83, 34, GL_RG16F, GL_RG, GL_HALF_FLOAT},
        [IBL_PIXEL_RG32F] = {103, 16, GL_RG32F, GL_RG, GL_FLOAT}};
    static const char zero[16];
    GLuint texture;

    view_test_begin(16, 16);
    for (int i = 0; i < IBL_PIXEL_COUNT; i++) {
        const ibl_pixel_numbers n = ibl_pixel_numbers_of((ibl_pixel)i);
        CHECK_MSG(!memcmp(&n, &known[i], sizeof n), "%s",
                  ibl_pixel_name((ibl_pixel)i));
        if (!n.gl_type)
            continue;
        gl.GenTextures(1, &texture);
        gl.BindTexture(GL_TEXTURE_2D, texture);
        gl.TexImage2D(GL_TEXTURE_2D, 0, (GLint)n.gl_internal, 1, 1, 0,
                      n.gl_format, n.gl_type, zero);
        CHECK(view_gl_check(ibl_pixel_name((ibl_pixel)i)));
        gl.DeleteTextures(1, &texture);
    }
}

TEST(messages)
{
    view_test_catch();
    CHECK(!view_fail("%s: is wrong", "a\033[31m\nb"));
    view_log(NULL, IBL_LOG_WARNING, "mended 100% of it");
    view_log(NULL, IBL_LOG_INFO, "chatter");
    view_log(NULL, IBL_LOG_ERROR, "gone");
    view_quiet();
    view_note("not heard");
    const char *said = view_test_caught();
    CHECK_MSG(!strcmp(said, "iblview: a?[31m?b: is wrong\n"
                            "iblview: note: mended 100% of it\n"
                            "iblview: gone\n"),
              "%s", said);
}
