/* SPDX-License-Identifier: MIT */
/* The viewer's ground: OpenGL in memory, shaders, pictures and their files. */
#include "view.h"

#include "files.h"
#include "view/gl.h"
#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

static view_gl_proc *no_function(const char *name)
{
    (void)name;
    return NULL;
}

/* Without OpenGL, or one that will do. */
TEST(no_screen)
{
    static const char *const all[][2] = {
        {"libNoSuchMesa.so.8", "install package libosmesa6\n"},
        {"libm.so.6", "no OpenGL 3.3 core: update"},
        {"libEGLnone.so", "need OSMesa"}};

    view_test_begin(8, 8);
    gl.Enable(0x1234);
    gl.Enable(0x1234);
    view_test_catch();
    CHECK(!view_gl_check("enabling") && view_gl_check("again"));
    CHECK(strstr(view_test_caught(), "enabling: OpenGL has the error 0x0500"));
    view_test_close();
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        view_test_catch();
        CHECK(!view_screen_memory(8, 8, (const char *[]){all[i][0], NULL}));
        const char *said = view_test_caught();
        CHECK_MSG(strstr(said, all[i][1]), "%s", said);
    }
    view_test_catch();
    CHECK(!view_gl_load(no_function));
    CHECK(strstr(view_test_caught(), "this OpenGL has no gl"));
}

/* ---- pictures ------------------------------------------------------------ */

/* Odd sizes: rows without padding, and from the top; alpha; what it takes. */
static void draw_places(int width, int height)
{
    static const char fragment[] =
        "out vec4 colour;\n"
        "void main() { colour = vec4(gl_FragCoord.xy / 255.0, 0.25, 0.5); }\n";

    view_gl_time_begin();
    gl.Viewport(0, 0, width, height);
    view_gl_draw_full(view_test_program(fragment));
    const double ms = view_gl_time_end();
    CHECK_MSG(ms >= 0 && ms < 60e3, "takes %g ms", ms);
    for (int n = 3; n <= 4; n++) {
        unsigned char *seen = view_picture_read(0, width, height, n), *p = seen;
        for (int i = 0; i < width * height; i++, p += n) {
            const int x = i % width, y = height - 1 - i / width;
            /* Pixel centres are halves; those round either way. */
            NEED(p[0] >= fmin(x, 255) && p[0] <= x + 1 && p[1] >= y &&
                 p[1] <= y + 1 && p[2] == 64 &&
                 p[n - 1] == (n == 4 ? 128 : 64));
        }
        free(seen);
    }
    CHECK(view_gl_check("drawing"));
}

/* EGL draws as OSMesa does, if only on the processor. */
TEST(rows_from_the_top)
{
    static const char *const names[] = {"libEGL.so.1", NULL};

    view_test_begin(37, 21);
    CHECK(!strcmp(view_screen_by(), "OSMesa") ||
          !strstr((const char *)gl.GetString(GL_RENDERER), "llvmpipe"));
    draw_places(37, 21);
    view_test_begin(3001, 4); /* rows of some kilobytes */
    draw_places(3001, 4);
    view_test_close();
    if (TEST_SANITIZED)
        return; /* EGL's drivers leak */
    view_test_catch();
    const bool ok = view_screen_memory(37, 21, names);
    view_test_caught();
    if (!ok)
        test_skip("no EGL without a display");
    CHECK(!strcmp(view_screen_by(), "EGL"));
    draw_places(37, 21);
    view_screen_close();
}

TEST(written_and_read)
{
    unsigned char pixels[4 * 45 * 33], back[sizeof pixels];
    test_random r = {7};
    const char *path = file_path("picture.png");

    for (size_t i = 0; i < sizeof pixels; i++)
        pixels[i] = (unsigned char)test_random_u64(&r);
    for (int n = 4; n >= 3; n--) {
        png_image image = {.version = PNG_IMAGE_VERSION};
        CHECK(view_picture_write(view_test_ctx(1), path, 45, 33, n, pixels));
        NEED(png_image_begin_read_from_file(&image, path) &&
             image.width == 45 && image.height == 33 &&
             image.format == (n == 3 ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA) &&
             png_image_finish_read(&image, NULL, back, 0, NULL));
        CHECK(!memcmp(pixels, back, (size_t)(n * 45 * 33)));
    }
    char *name = view_picture_name("a.b/out.png", 7);
    CHECK(!strcmp(name, "a.b/out-007.png"));
    free(name);
}

/* Lines count from 1 in each file, whatever a shader includes. */
TEST(shader_errors_have_their_line)
{
    static const struct {
        const char *shader, *word, *file, *define;
    } cases[] = {
        {"display.frag", "TONE)", "display.frag", "#define TONE missing\n"},
        {"sky.frag", "DIFFUSE ==", "light.glsl",
         "#define BACKDROP 1\n#define DIFFUSE missing\n"},
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
