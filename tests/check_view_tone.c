/* SPDX-License-Identifier: MIT */
/* The display pass against closed forms in double: every curve over a sweep of
 * colours, sRGB, false colours, comparing, and numbers that are none. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "test.h"
#include "view.h"
#include "view/frame.h"
#include "view/gl.h"
#include "view/ui.h"

enum {
    WIDTH = 128,
    HEIGHT = 48
};

/* What a test draws with; pictures have row 0 on top. */
static struct {
    GLuint display, uniforms;
    view_frame frame;
    float picture[2][HEIGHT][WIDTH][4];
    unsigned char *seen; /* [HEIGHT][WIDTH][3] */
} on;

/* From 2^-16 to 2^16 in columns, the other way in the other picture; rows of
 * grey, pure, mixed and random hues, the last of them with negative parts. */
static void fill_sweep(void)
{
    test_random r = {1};

    for (int y = 0; y < HEIGHT; y++)
        for (int k = 0; k < 3; k++) {
            const double hue =
                y == 0  ? 1
                : y < 8 ? (y >> k & 1)
                        : test_random_unit(&r) - (y > HEIGHT - 8) / 4.0;
            for (int x = 0; x < WIDTH; x++)
                on.picture[0][y][x][k] = on.picture[1][y][WIDTH - 1 - x][k] =
                    (float)(exp2(32.0 * x / (WIDTH - 1) - 16) * hue);
        }
}

static void end(void *unused)
{
    (void)unused;
    free(on.seen);
}

static void begin(void)
{
    view_test_begin(WIDTH, HEIGHT);
    memset(&on, 0, sizeof on);
    on.display = view_program("", "full.vert", "display.frag");
    NEED(on.display);
    test_defer(end, NULL);
    gl.GenBuffers(1, &on.uniforms);
    gl.BindBufferBase(GL_UNIFORM_BUFFER, 0, on.uniforms);
    gl.Viewport(0, 0, WIDTH, HEIGHT);
    on.frame.viewport[0] = WIDTH;
    on.frame.viewport[1] = HEIGHT;
    on.frame.display[0] = on.frame.display[2] = 1;
    for (int i = 0; i < 2 * WIDTH * HEIGHT; i++)
        on.picture[i / (WIDTH * HEIGHT)][i / WIDTH % HEIGHT][i % WIDTH][3] = 1;
    fill_sweep();
}

static void draw(void)
{
    static float flipped[HEIGHT][WIDTH][4];

    for (int i = 0; i < 2; i++) {
        for (int y = 0; y < HEIGHT; y++)
            memcpy(flipped[HEIGHT - 1 - y], on.picture[i][y],
                   sizeof flipped[0]);
        gl.ActiveTexture(GL_TEXTURE0 +
                         (i ? VIEW_UNIT_OTHER : VIEW_UNIT_PICTURE));
        view_float_image(GL_RGBA, WIDTH, HEIGHT, flipped[0][0]);
    }
    gl.BindBuffer(GL_UNIFORM_BUFFER, on.uniforms);
    gl.BufferData(GL_UNIFORM_BUFFER, sizeof on.frame, &on.frame,
                  GL_DYNAMIC_DRAW);
    view_gl_draw_full(on.display);
    free(on.seen);
    on.seen = view_picture_read(0, WIDTH, HEIGHT, 3);
    NEED(on.seen && view_gl_check("test"));
}

static const unsigned char *seen(int x, int y)
{
    return on.seen + 3 * ((size_t)y * WIDTH + (size_t)x);
}

/* ---- closed forms ------------------------------------------------------ */

static double encode(double c)
{
    c = fmin(fmax(c, 0), 1);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
}

static double brightness(const double c[3])
{
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

static void linear(double c[3])
{
    (void)c;
}

static void reinhard(double c[3])
{
    const double y = brightness(c), shown = y / (1 + y);
    for (int k = 0; k < 3; k++)
        c[k] = y > 0 ? c[k] / y * shown : 0;
}

static void transform(const double m[3][3], double c[3])
{
    double r[3];
    for (int k = 0; k < 3; k++)
        r[k] = m[k][0] * c[0] + m[k][1] * c[1] + m[k][2] * c[2];
    memcpy(c, r, sizeof r);
}

static const double aces_in[3][3] = {{0.59719, 0.35458, 0.04823},
                                     {0.07600, 0.90834, 0.01566},
                                     {0.02840, 0.13383, 0.83777}};
static const double aces_out[3][3] = {{1.60475, -0.53108, -0.07367},
                                      {-0.10208, 1.10813, -0.00605},
                                      {-0.00327, -0.07276, 1.07602}};

static void aces(double c[3])
{
    transform(aces_in, c);
    for (int k = 0; k < 3; k++) {
        const double v = c[k];
        c[k] = (v * (v + 0.0245786) - 0.000090537) /
               (v * (0.983729 * v + 0.4329510) + 0.238081);
    }
    transform(aces_out, c);
}

/* As the specification has it: f, p, p_n, g. */
static void neutral(double c[3])
{
    const double f90 = 0.04, ks = 0.8 - f90, kd = 0.15;
    const double x = fmin(c[0], fmin(c[1], c[2]));
    const double f = x <= 2 * f90 ? x - x * x / (4 * f90) : f90;
    const double p = fmax(c[0], fmax(c[1], c[2])) - f;
    const double pn = 1 - (1 - ks) * (1 - ks) / (p + 1 - 2 * ks);
    const double g = 1 / (kd * (p - pn) + 1);

    for (int k = 0; k < 3; k++)
        c[k] = p <= ks ? c[k] - f : (c[k] - f) * pn / p * g + pn * (1 - g);
}

/* Those of AgX are values. */
static void (*const curves[VIEW_TONE_AGX])(double c[3]) = {linear, reinhard,
                                                           aces, neutral};

/* ---- pictures and what is expected of them ----------------------------- */

/* Stops from middle grey of a column: 9.5 each way. */
static double stops_of(int x)
{
    return (x + 0.3) * 19 / WIDTH - 9.5;
}

/* One hue a row, all of the luminance of their column. */
static void fill_stops(double ev)
{
    test_random r = {2};

    for (int y = 0; y < HEIGHT; y++) {
        double hue[3] = {1, 1, 1};
        for (int k = 0; y && k < 3; k++)
            hue[k] = test_random_unit(&r);
        for (int x = 0; x < WIDTH; x++)
            for (int k = 0; k < 3; k++)
                on.picture[0][y][x][k] = (float)(hue[k] / brightness(hue) *
                                                 0.18 * exp2(stops_of(x) - ev));
    }
}

/* The sRGB-encoded colour of a pixel, by the frame. */
static void expect(int x, int y, double c[3])
{
    const view_frame *f = &on.frame;
    const float *a = on.picture[0][y][x], *b = on.picture[1][y][x];
    const bool left = x + 0.5 < f->display[1] * WIDTH;

    for (int k = 0; k < 3; k++)
        c[k] = f->show[2] == VIEW_DIFFERENCE
                   ? fabs((double)a[k] - b[k]) * f->display[2]
               : f->show[2] == VIEW_SPLIT && !left ? b[k]
                                                   : a[k];
    for (int k = 0; k < 3; k++)
        c[k] = fmax(c[k] * f->display[0], 0);
    if (f->show[1]) {
        view_test_false_colour(log2(brightness(c) / 0.18), c);
        return;
    }
    curves[f->show[2] == VIEW_DIFFERENCE ? 0 : f->show[0]](c);
    for (int k = 0; k < 3; k++)
        c[k] = encode(c[k]);
}

/* Columns x0 .. x1 are as expected: half a step of rounding, and 3e-5 of the
 * range for float. */
static void compare(int x0, int x1)
{
    const view_frame *f = &on.frame;
    double worst = 0, c[3];
    int at[2] = {0};

    for (int y = 0; y < HEIGHT; y++)
        for (int x = x0; x < x1; x++) {
            expect(x, y, c);
            for (int k = 0; k < 3; k++) {
                const double off = fabs(255 * c[k] - seen(x, y)[k]);
                if (off > worst)
                    worst = off, at[0] = x, at[1] = y;
            }
        }
    CHECK_MSG(worst <= 0.5 + 0.008,
              "tone %d, false colours %d, compare %d, exposure %g, split %g, "
              "gain %g: off by %g at %d, %d",
              f->show[0], f->show[1], f->show[2], f->display[0], f->display[1],
              f->display[2], worst, at[0], at[1]);
}

static bool is(const unsigned char *c, int r, int g, int b)
{
    return c[0] == r && c[1] == g && c[2] == b;
}

/* ---- curves ------------------------------------------------------------ */

/* Draws by the program of a curve alone, or by that for all that is shown. */
static void draw_curve(int tone, bool alone)
{
    on.display = view_program_from(
        view_shader_files, alone ? test_text("#define TONE %d\n", tone) : "",
        "full.vert", "display.frag");
    on.frame.show[0] = tone;
    draw();
}

TEST(curves_are_their_formulas)
{
    /* What the fits must hold, whoever typed them: grey stays grey. */
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(aces_in[k][0] + aces_in[k][1] + aces_in[k][2], 1, 1e-4);
        CHECK_NEAR(aces_out[k][0] + aces_out[k][1] + aces_out[k][2], 1, 1e-4);
    }
    begin();
    for (int tone = 0; tone < VIEW_TONE_AGX; tone++)
        for (int ev = -6; ev <= 6; ev += 3) {
            on.frame.display[0] = (float)exp2(ev);
            draw_curve(tone, ev % 2);
            compare(0, WIDTH);
        }
}

/* What three.js, which has the same formula, shows of these. */
TEST(agx_shows_ten_values)
{
    static const double values[10][2][3] = {
        {{0, 0, 0}, {0, 0, 0}},
        {{0.18, 0.18, 0.18}, {127.64, 127.63, 127.63}},
        {{1, 1, 1}, {201.94, 201.93, 201.92}},
        {{16, 16, 16}, {254.46, 254.45, 254.44}},
        {{0.5, 0.25, 0.1}, {176.50, 142.36, 109.74}},
        {{1, 0, 0}, {221.03, 91.51, 73.06}},
        {{0, 1, 0}, {133.12, 201.07, 101.08}},
        {{0, 0, 1}, {51.74, 102.94, 221.94}},
        {{0.02, 0.05, 0.2}, {40.56, 80.88, 138.25}},
        {{4, 2, 0.5}, {242.29, 223.44, 194.63}}};

    begin();
    for (int i = 0; i < 30; i++)
        on.picture[0][0][i / 3][i % 3] = (float)values[i / 3][0][i % 3] / 4;
    on.frame.display[0] = 4;
    for (int alone = 0; alone < 2; alone++) {
        draw_curve(VIEW_TONE_AGX, alone);
        for (int i = 0; i < 30; i++)
            CHECK_NEAR(seen(i / 3, 0)[i % 3], values[i / 3][1][i % 3], 0.51);
    }
}

/* ---- false colour ------------------------------------------------------ */

/* Those of out of range are stripes: half black, half blue, or white and red.
 */
TEST(false_colours_are_of_luminance)
{
    begin();
    on.frame.show[1] = 1;
    for (int ev = -3; ev <= 3; ev += 3) {
        int low[2] = {0}, high[2] = {0};
        fill_stops(ev);
        on.frame.display[0] = (float)exp2(ev);
        draw();
        compare(11, WIDTH - 11);
        for (int i = 0; i < 10 * HEIGHT; i++) {
            const unsigned char *dark = seen(i % 10, i / 10);
            const unsigned char *bright = seen(WIDTH - 1 - i % 10, i / 10);
            low[0] += is(dark, 0, 0, 0), low[1] += is(dark, 0, 0, 128);
            high[0] += is(bright, 255, 255, 255);
            high[1] += is(bright, 255, 0, 0);
        }
        CHECK(low[0] + low[1] == 10 * HEIGHT &&
              high[0] + high[1] == 10 * HEIGHT);
        CHECK_NEAR(low[0], low[1], HEIGHT);
        CHECK_NEAR(high[0], high[1], HEIGHT);
    }
}

/* ---- no numbers, and comparing ------------------------------------------ */

TEST(no_number_hides)
{
    static const struct {
        float c[3];
        int shown[3];
    } odd[] = {
        {{NAN, 0, 0}, {255, 0, 255}},
        {{0, -NAN, 0}, {255, 0, 255}},
        {{NAN, INFINITY, 0}, {255, 0, 255}},
        {{0, 0, INFINITY}, {0, 255, 255}},
        {{-INFINITY, 0, 0}, {0, 255, 255}},
        {{FLT_MAX, FLT_MAX, FLT_MAX}, {255, 255, 255}} /* by the curve */
    };

    begin();
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < 6; i++)
            memcpy(on.picture[side][3][5 + 100 * side + i], odd[i].c,
                   sizeof odd[i].c);
    on.frame.display[1] = 0.5f;
    for (int i = 0; i < 2 * VIEW_TONES * VIEW_COMPARES; i++) {
        on.frame.show[0] = i / 2 % VIEW_TONES;
        on.frame.show[1] = i % 2;
        on.frame.show[2] = i / 2 / VIEW_TONES;
        on.frame.display[0] = on.frame.show[2] == VIEW_SPLIT ? 8 : 0.125f;
        draw();
        for (int n = 0; n < 6 - i % 2; n++) {
            const int *c = odd[n].shown;
            CHECK(is(seen(5 + n, 3), c[0], c[1], c[2]));
            CHECK(on.frame.show[2] == VIEW_ALONE ||
                  is(seen(105 + n, 3), c[0], c[1], c[2]));
        }
    }
}

/* The left one's columns, a black and a white one, and the right one's. */
TEST(pictures_are_compared)
{
    static const double splits[] = {0, 0.25, 0.4999, 0.5, 0.777, 1};

    begin();
    draw();
    compare(0, WIDTH);
    on.frame.show[2] = VIEW_SPLIT;
    for (int i = 0; i < 6; i++) {
        const int at = (int)ceil(splits[i] * WIDTH - 0.5);
        on.frame.display[1] = (float)splits[i];
        draw();
        compare(0, at - 1);
        compare(at + 1, WIDTH);
        for (int y = 0; y < HEIGHT; y++) {
            CHECK(at == WIDTH || is(seen(at, y), 255, 255, 255));
            CHECK(at == 0 || is(seen(at - 1, y), 0, 0, 0));
        }
    }
    on.frame.show[2] = VIEW_DIFFERENCE;
    on.frame.show[0] = VIEW_TONE_ACES; /* differences are linear */
    on.frame.display[0] = 2;
    for (int gain = 1; gain <= 16; gain *= 4) {
        on.frame.display[2] = (float)gain;
        draw();
        compare(0, WIDTH);
    }
}

/* Nothing is there where alpha is 0, and colours are times alpha. */
TEST(alpha_is_taken_off)
{
    begin();
    on.picture[0][7][0][3] = 0;
    for (int k = 0; k < 3; k++)
        on.picture[0][7][1][k] = 0.125F;
    on.picture[0][7][1][3] = 0.25F;
    for (int clear = 0; clear < 2; clear++) {
        on.frame.looks[2] = clear;
        draw();
        compare(2, WIDTH);
        CHECK(is(seen(0, 7), 26, 26, 26) || is(seen(0, 7), 25, 25, 25));
        CHECK_NEAR(seen(1, 7)[0], 255 * encode(0.5), 0.51);
        unsigned char *rgba = view_picture_read(0, WIDTH, HEIGHT, 4);
        CHECK(rgba[4 * (7 * WIDTH + 1) + 3] == (clear ? 64 : 255));
        CHECK(rgba[4 * 7 * WIDTH + 3] == (clear ? 0 : 255));
        free(rgba);
    }
}
