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
    {NULL, {NULL}},
};

static const GLubyte *old_version(GLenum name)
{
    (void)name;
    return (const GLubyte *)"2.1 Mesa 7.0";
}

static view_gl_proc *old_get(const char *name)
{
    return strcmp(name, "glGetString") ? NULL : (view_gl_proc *)old_version;
}

/* Without OpenGL, or one that will do. */
TEST(no_screen)
{
    static const char *const none[] = {"libNoSuchMesa.so.8", NULL};
    static const char *const old[] = {"libm.so.6", NULL};
    static const struct {
        int width, height;
        const char *const *names, *words;
    } all[] = {
        {8, 8, none,
         "OSMesa, and libNoSuchMesa.so.8 cannot be opened: install package "
         "libosmesa6\n"},
        {8, 8, old, "older than 11.2"},
        {40000, 2, NULL, "not 40000 x 2: ask"},
        {2, 40000, NULL, "not 2 x 40000: ask"},
    };

    view_test_begin(8, 8);
    view_test_close();
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        view_test_catch();
        CHECK(!view_screen_memory(all[i].width, all[i].height, all[i].names));
        const char *said = view_test_caught();
        CHECK_MSG(strstr(said, all[i].words), "%s", said);
    }
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
    gl.Viewport(0, 0, width, height);
    view_gl_draw_full(program);
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
