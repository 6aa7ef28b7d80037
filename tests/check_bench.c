/* SPDX-License-Identifier: MIT */
/* Parts of iblbake bench that have a truth of their own: resampled maps, and
 * the words of command lines as the shell sees them. */
#include "json/text.c"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/resample.c"
#include "cli/shell_words.c"
#include "ibl/ibl.h"
#include "ibl/io.h"
#include "test.h"

/* env resampled and read again by the library. */
static bool resample(ibl_ctx *ctx, const ibl_image *env, int width, int height,
                     ibl_image *out)
{
    ibl_read_options read = ibl_read_options_default();
    char *bytes = NULL;
    size_t size;
    FILE *to = open_memstream(&bytes, &size);

    read.any_aspect = 1;
    const int why = ibl_resample_write(env, width, height, to);
    fclose(to);
    const bool ok = !why && !ibl_image_decode(ctx, "resampled", bytes, size,
                                              &read, out, NULL);
    free(bytes);
    return ok && out->width == width && out->height == height;
}

static bool fill(ibl_ctx *ctx, int width, int height, ibl_image *env)
{
    test_random r = {(uint64_t)width};

    if (ibl_image_alloc(ctx, width, height, env))
        return false;
    for (size_t i = 0; i < 3 * (size_t)width * (size_t)height; i++)
        env->data[i] = (float)pow(10, 4 * test_random_unit(&r) - 2);
    return true;
}

/* Means and interpolation keep a constant colour; RGBE is exact for these. */
TEST(constant)
{
    static const int sizes[][2] = {{7, 3}, {8, 4}, {64, 32}, {200, 100}};
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image env;

    NEED(!ibl_image_alloc(ctx, 36, 17, &env));
    for (int i = 0; i < 36 * 17; i++)
        memcpy(env.data + 3 * i, (float[]){1, 0.5f, 2.25f}, 12);
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        ibl_image out = {0};
        int bad = 0;
        NEED(resample(ctx, &env, sizes[k][0], sizes[k][1], &out));
        for (int i = 0; i < out.width * out.height; i++)
            bad += fabsf(out.data[3 * i] - 1) > 0.02f ||
                   fabsf(out.data[3 * i + 1] - 0.5f) > 0.02f ||
                   fabsf(out.data[3 * i + 2] - 2.25f) > 0.02f;
        CHECK_MSG(!bad, "%dx%d: %d pixels", out.width, out.height, bad);
        ibl_image_free(&out);
    }
    ibl_image_free(&env);
}

static double energy(const ibl_image *env)
{
    const double pi_here = acos(-1);
    double sum = 0;

    for (int y = 0; y < env->height; y++) {
        const double band_here = cos(pi_here * y / env->height) -
                                 cos(pi_here * (y + 1) / env->height);
        double row_sum = 0;
        for (int x = 0; x < 3 * env->width; x++)
            row_sum += (double)env->data[3 * (size_t)y * env->width + x];
        sum += band_here * row_sum / env->width;
    }
    return sum;
}

/* Means over the solid angle keep the energy, whatever the ratio; RGBE cuts
 * off up to a 128th of a component below its pixel's largest. */
TEST(smaller_keeps_energy)
{
    static const int sizes[][2] = {{50, 25}, {33, 16}, {10, 7}, {1, 1}};
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image env;

    NEED(fill(ctx, 100, 50, &env));
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        ibl_image out = {0};
        NEED(resample(ctx, &env, sizes[k][0], sizes[k][1], &out));
        CHECK_NEAR(energy(&out) / energy(&env), 1, 1.0 / 128);
        ibl_image_free(&out);
    }
    ibl_image_free(&env);
}

/* Three times as wide and high: every third pixel's centre is a pixel's of
 * the source, and columns go on across the seam. */
TEST(larger_interpolates)
{
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    ibl_image env, out = {0};
    double worst = 0;

    NEED(fill(ctx, 12, 6, &env));
    NEED(resample(ctx, &env, 36, 18, &out));
    for (int y = 0; y < 6; y++)
        for (int x = 0; x < 12; x++) {
            const float *a = env.data + 3 * (12 * y + x);
            const float *b = out.data + 3 * (36 * (3 * y + 1) + 3 * x + 1);
            const float most = fmaxf(a[0], fmaxf(a[1], a[2]));
            for (int c = 0; c < 3; c++)
                worst = fmax(worst, (double)(fabsf(a[c] - b[c]) / most));
        }
    CHECK_MSG(worst <= 1.0 / 128, "off by %g", worst);
    for (int c = 0; c < 3; c++) {
        const float *last = env.data + 3 * 11, *first = env.data;
        const double mixed = (2 * (double)first[c] + (double)last[c]) / 3;
        const float *got = out.data + 3 * 36;
        const float most = fmaxf(got[0], fmaxf(got[1], got[2]));
        CHECK_NEAR((double)got[c], mixed, (double)most / 64);
    }
    ibl_image_free(&out);
    ibl_image_free(&env);
}

TEST(split)
{
    static const struct {
        const char *text, *words[5];
    } cases[] = {
        {"", {NULL}},
        {"  \t\n ", {NULL}},
        {"a", {"a"}},
        {" a  bc\td ", {"a", "bc", "d"}},
        {"'a b' \"c'd\" e\\ f", {"a b", "c'd", "e f"}},
        {"'' x''y \"\"", {"", "xy", ""}},
        {"'\\' \"\\\"\"", {"\\", "\""}},
        {"a\\", {"a\\"}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char **words = ibl_words_split(cases[i].text);
        int n = 0;
        NEED(words);
        for (; words[n] && cases[i].words[n]; n++)
            CHECK_MSG(!strcmp(words[n], cases[i].words[n]), "%s: %s",
                      cases[i].text, words[n]);
        CHECK_MSG(!words[n] && !cases[i].words[n], "%s: %d words",
                  cases[i].text, n);
        free(words);
    }
    CHECK(!ibl_words_split("a 'b"));
    CHECK(!ibl_words_split("a \"b'"));
}

/* What is quoted comes back, through our words and through a shell's. */
TEST(quote)
{
    static const char *const words[] = {"a.b-c", "", "a b", "it's",
                                        "$HOME `x` \\ \"q\" *"};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        char *quoted = ibl_words_quote(words[i]);
        char command[128], got[64] = "";
        NEED(quoted);
        char **back = ibl_words_split(quoted);
        CHECK(back && back[0] && !strcmp(back[0], words[i]) && !back[1]);
        snprintf(command, sizeof command, "printf %%s %s", quoted);
        FILE *shell = popen(command, "r");
        NEED(shell);
        got[fread(got, 1, sizeof got - 1, shell)] = '\0';
        CHECK(!pclose(shell) && !strcmp(got, words[i]));
        free(back);
        free(quoted);
    }
}

TEST(placeholders)
{
    const ibl_placeholder holders[] = {{"env", "E"}, {"out", "O/{env}"}};
    char *text =
        ibl_words_fill("{env} {out}/{env}{ {no} ${x} {envy} {env", holders, 2);

    NEED(text);
    CHECK(!strcmp(text, "E O/{env}/E{ {no} ${x} {envy} {env"));
    free(text);
}
