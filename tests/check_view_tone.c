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
        view_float_image(GL_RGBA, WIDTH, HEIGHT, 0, flipped[0][0]);
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

static double agx_curve(double stops)
{
    const double x = fmin(fmax((stops + 12.47393) / 16.499999, 0), 1);

    return -0.00232 +
           x * (0.1191 +
                x * (0.4298 +
                     x * (-6.868 + x * (31.96 + x * (-40.14 + x * 15.5)))));
}

static void agx(double c[3])
{
    static const double in[2][3][3] = {
        {{0.6274, 0.3293, 0.0433},
         {0.0691, 0.9195, 0.0113},
         {0.0164, 0.0880, 0.8956}},
        {{0.856627153315983, 0.0951212405381588, 0.0482516061458583},
         {0.137318972929847, 0.761241990602591, 0.101439036467562},
         {0.11189821299995, 0.0767994186031903, 0.811302368396859}}};
    static const double out[2][3][3] = {
        {{1.1271005818144368, -0.1106066430966032, -0.0164939387178346},
         {-0.1413297634984383, 1.157823702216272, -0.0164939387178343},
         {-0.1413297634984383, -0.1106066430966029, 1.2519364065950405}},
        {{1.6605, -0.5876, -0.0728},
         {-0.1246, 1.1329, -0.0083},
         {-0.0182, -0.1006, 1.1187}}};

    transform(in[0], c);
    transform(in[1], c);
    for (int k = 0; k < 3; k++)
        c[k] = agx_curve(log2(fmax(c[k], 1e-10)));
    transform(out[0], c);
    for (int k = 0; k < 3; k++)
        c[k] = pow(fmax(c[k], 0), 2.2);
    transform(out[1], c);
}

static void (*const curves[VIEW_TONES])(double c[3]) = {linear, reinhard, aces,
                                                        neutral, agx};

/* ---- a sweep ----------------------------------------------------------- */

/* From 2^-16 to 2^16 in columns; rows of grey, pure, mixed and random hues,
 * the last of them with negative parts. */
static void fill_sweep(void)
{
    test_random r = {1};

    for (int y = 0; y < HEIGHT; y++) {
        double hue[3];
        for (int k = 0; k < 3; k++)
            hue[k] = y == 0  ? 1
                     : y < 8 ? (y >> k & 1)
                             : test_random_unit(&r) - (y > HEIGHT - 8) / 4.0;
        for (int x = 0; x < WIDTH; x++) {
            const double level = exp2(32.0 * x / (WIDTH - 1) - 16);
            for (int k = 0; k < 3; k++)
                on.picture[0][y][x][k] = (float)(level * hue[k]);
        }
    }
}

static void compare_curve(int tone, double exposure)
{
    double worst = 0;
    int at[2] = {0};

    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            double c[3];
            for (int k = 0; k < 3; k++)
                c[k] = fmax(on.picture[0][y][x][k] * exposure, 0);
            curves[tone](c);
            for (int k = 0; k < 3; k++) {
                const double off = fabs(255 * encode(c[k]) - seen(x, y)[k]);
                if (off > worst)
                    worst = off, at[0] = x, at[1] = y;
            }
        }
    /* Half a step of rounding, and 3e-5 of the range for float. */
    CHECK_MSG(worst <= 0.5 + 0.008, "curve %d at 2^%g: off by %g at %d, %d",
              tone, log2(exposure), worst, at[0], at[1]);
}

/* In the program for all that is shown, and in that of the curve alone. */
TEST(curves_are_their_formulas)
{
    /* What the fits must hold, whoever typed them: grey stays grey. */
    for (int k = 0; k < 3; k++) {
        CHECK_NEAR(aces_in[k][0] + aces_in[k][1] + aces_in[k][2], 1, 1e-4);
        CHECK_NEAR(aces_out[k][0] + aces_out[k][1] + aces_out[k][2], 1, 1e-4);
    }
    begin();
    fill_sweep();
    for (int tone = 0; tone < VIEW_TONES; tone++)
        for (int ev = -6; ev <= 6; ev += 3) {
            on.display = view_program_from(
                view_shader_files,
                ev % 2 ? test_text("#define TONE %d\n", tone) : "", "full.vert",
                "display.frag");
            on.frame.show[0] = tone;
            on.frame.display[0] = (float)exp2(ev);
            draw();
            compare_curve(tone, exp2(ev));
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
    for (int i = 0; i < 10; i++)
        for (int k = 0; k < 3; k++)
            on.picture[0][0][i][k] = (float)values[i][0][k];
    on.frame.show[0] = VIEW_TONE_AGX;
    draw();
    for (int i = 0; i < 10; i++)
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(seen(i, 0)[k], values[i][1][k], 0.51);
}

/* ---- false colour ------------------------------------------------------ */

static void stripes(int x0, int x1, const int a[3], const int b[3])
{
    int count[2] = {0, 0};

    for (int y = 0; y < HEIGHT; y++)
        for (int x = x0; x < x1; x++) {
            const unsigned char *c = seen(x, y);
            count[0] += c[0] == a[0] && c[1] == a[1] && c[2] == a[2];
            count[1] += c[0] == b[0] && c[1] == b[1] && c[2] == b[2];
        }
    CHECK(count[0] > 0 && count[1] > 0);
    CHECK(count[0] + count[1] == (x1 - x0) * HEIGHT);
    CHECK_NEAR(count[0], count[1], HEIGHT * 8);
}

/* One hue a row, all of the luminance of their column: 9.5 stops each way. */
static void fill_stops(double ev)
{
    test_random r = {2};

    for (int y = 0; y < HEIGHT; y++) {
        double hue[3] = {1, 1, 1};
        for (int k = 0; y && k < 3; k++)
            hue[k] = test_random_unit(&r);
        for (int x = 0; x < WIDTH; x++)
            for (int k = 0; k < 3; k++)
                on.picture[0][y][x][k] =
                    (float)(hue[k] / brightness(hue) * 0.18 *
                            exp2((x + 0.3) * 19 / WIDTH - 9.5 - ev));
    }
}

TEST(false_colours_are_of_luminance)
{
    const int first = 11, last = WIDTH - 11;

    begin();
    on.frame.show[1] = 1;
    for (int ev = -3; ev <= 3; ev += 3) {
        fill_stops(ev);
        on.frame.display[0] = (float)exp2(ev);
        draw();
        for (int y = 0; y < HEIGHT; y++)
            for (int x = first; x < last; x++) {
                double c[3];
                view_test_false_colour((x + 0.3) * 19 / WIDTH - 9.5, c);
                for (int k = 0; k < 3; k++)
                    CHECK_NEAR(seen(x, y)[k], 255 * c[k], 0.51);
            }
        stripes(0, 10, (const int[3]){0, 0, 0}, (const int[3]){0, 0, 128});
        stripes(WIDTH - 10, WIDTH, (const int[3]){255, 255, 255},
                (const int[3]){255, 0, 0});
    }
}

/* ---- no numbers, and comparing ------------------------------------------ */

static bool is(const unsigned char *c, int r, int g, int b)
{
    return c[0] == r && c[1] == g && c[2] == b;
}

TEST(no_number_hides)
{
    begin();
    on.picture[0][3][5][0] = NAN;
    on.picture[0][3][6][1] = -NAN;
    on.picture[0][3][7][2] = INFINITY;
    on.picture[0][3][8][0] = -INFINITY;
    on.picture[0][3][9][0] = NAN;
    on.picture[0][3][9][1] = INFINITY;
    on.picture[0][3][10][0] = FLT_MAX;
    on.picture[0][3][10][1] = FLT_MAX;
    on.picture[0][3][10][2] = FLT_MAX;
    on.picture[1][3][100][2] = NAN;
    on.picture[1][3][101][2] = INFINITY;
    for (int i = 0; i < 2 * VIEW_TONES; i++) {
        on.frame.show[0] = i / 2;
        on.frame.show[1] = i % 2;
        for (int compare = 0; compare < VIEW_COMPARES; compare++) {
            on.frame.show[2] = compare;
            on.frame.display[0] = compare == VIEW_SPLIT ? 8 : 0.125f;
            on.frame.display[1] = 0.5f;
            draw();
            const bool right = compare != VIEW_ALONE;
            CHECK(is(seen(5, 3), 255, 0, 255));
            CHECK(is(seen(6, 3), 255, 0, 255));
            CHECK(is(seen(7, 3), 0, 255, 255));
            CHECK(is(seen(8, 3), 0, 255, 255));
            CHECK(is(seen(9, 3), 255, 0, 255));
            CHECK(is(seen(100, 3), 255, 0, 255) == right);
            CHECK(is(seen(101, 3), 0, 255, 255) == right);
            CHECK(!is(seen(10, 3), 0, 255, 255) &&
                  !is(seen(10, 3), 255, 0, 255));
            CHECK(i % 2 || is(seen(10, 3), 255, 255, 255));
        }
    }
}

static void fill_both(void)
{
    test_random r = {3};

    for (int i = 0; i < 2 * WIDTH * HEIGHT; i++)
        for (int k = 0; k < 3; k++)
            on.picture[i / (WIDTH * HEIGHT)][i / WIDTH % HEIGHT][i % WIDTH][k] =
                (float)test_random_unit(&r);
}

/* Pixels of columns x0 .. x1 are those of a picture. */
static void same(int x0, int x1, int which)
{
    int bad = 0;

    for (int y = 0; y < HEIGHT; y++)
        for (int x = x0; x < x1; x++)
            for (int k = 0; k < 3; k++)
                bad += !(fabs(255 * encode(on.picture[which][y][x][k]) -
                              seen(x, y)[k]) <= 0.508);
    CHECK_MSG(!bad, "columns %d to %d: %d are not of picture %d", x0, x1, bad,
              which);
}

TEST(pictures_are_compared)
{
    static const double splits[] = {0, 0.25, 0.4999, 0.5, 0.777, 1};

    begin();
    fill_both();
    draw();
    same(0, WIDTH, 0);
    on.frame.show[2] = VIEW_SPLIT;
    for (size_t i = 0; i < sizeof splits / sizeof *splits; i++) {
        const int at = (int)ceil(splits[i] * WIDTH - 0.5);
        on.frame.display[1] = (float)splits[i];
        draw();
        same(0, at - 1, 0);
        same(at + 1, WIDTH, 1);
        for (int y = 0; y < HEIGHT; y++) {
            CHECK(at == WIDTH || is(seen(at, y), 255, 255, 255));
            CHECK(at == 0 || is(seen(at - 1, y), 0, 0, 0));
        }
    }
}

TEST(differences_are_amplified)
{
    int bad = 0;

    begin();
    fill_both();
    on.frame.show[2] = VIEW_DIFFERENCE;
    on.frame.display[0] = 2;
    for (int gain = 1; gain <= 16; gain *= 4) {
        on.frame.display[2] = (float)gain;
        draw();
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++)
                for (int k = 0; k < 3; k++) {
                    const double a = on.picture[0][y][x][k];
                    const double b = on.picture[1][y][x][k];
                    bad += !(fabs(255 * encode(fabs(a - b) * gain * 2) -
                                  seen(x, y)[k]) <= 0.508);
                }
        CHECK_MSG(!bad, "gain %d: %d are off", gain, bad);
    }
}

/* Nothing is there where alpha is 0, and colours are times alpha. */
TEST(alpha_is_taken_off)
{
    begin();
    fill_both();
    on.picture[0][7][0][3] = 0;
    for (int k = 0; k < 3; k++)
        on.picture[0][7][1][k] = 0.125F;
    on.picture[0][7][1][3] = 0.25F;
    for (int clear = 0; clear < 2; clear++) {
        on.frame.looks[2] = clear;
        draw();
        same(2, WIDTH, 0);
        CHECK(is(seen(0, 7), 26, 26, 26) || is(seen(0, 7), 25, 25, 25));
        CHECK_NEAR(seen(1, 7)[0], 255 * encode(0.5), 0.51);
        unsigned char *rgba = view_picture_read(0, WIDTH, HEIGHT, 4);
        CHECK(rgba[4 * (7 * WIDTH + 1) + 3] == (clear ? 64 : 255));
        CHECK(rgba[4 * 7 * WIDTH + 3] == (clear ? 0 : 255));
        free(rgba);
    }
}
