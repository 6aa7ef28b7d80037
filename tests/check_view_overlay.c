/* SPDX-License-Identifier: MIT */
/* Text on a picture: where it is, how large, and that nothing else changes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "test.h"
#include "view.h"
#include "view/overlay.h"
#include "view/picture.h"

enum {
    WIDTH = 240,
    HEIGHT = 120,
    GREY = 128
};

static view_overlay *overlay;
static unsigned char *seen;

static void end(void *unused)
{
    (void)unused;
    CHECK(view_gl_check("test"));
    free(seen);
    seen = NULL;
    view_overlay_free(overlay);
}

/* On grey. */
static void clear(void)
{
    gl.ClearColor(GREY / 255.0f, GREY / 255.0f, GREY / 255.0f, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    view_overlay_begin(overlay, WIDTH, HEIGHT);
}

static void begin(void)
{
    view_test_begin(WIDTH, HEIGHT);
    overlay = view_overlay_create();
    NEED(overlay);
    test_defer(end, NULL);
    gl.Viewport(0, 0, WIDTH, HEIGHT);
    clear();
}

/* Looks at what was drawn since the last look. */
static void draw(void)
{
    view_overlay_end(overlay);
    free(seen);
    seen = view_picture_read(0, WIDTH, HEIGHT);
    if (!seen)
        exit(1);
    clear();
}

static int at(int x, int y)
{
    return seen[3 * (y * WIDTH + x)];
}

/* The smallest box around the pixels that changed, or are lighter than grey. */
typedef struct box {
    int left, top, right, bottom, count;
} box;

static box find(bool light)
{
    box b = {WIDTH, HEIGHT, 0, 0, 0};

    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const int v = at(x, y);
            if (light ? v <= GREY : v == GREY)
                continue;
            b.left = x < b.left ? x : b.left;
            b.top = y < b.top ? y : b.top;
            b.right = x + 1 > b.right ? x + 1 : b.right;
            b.bottom = y + 1 > b.bottom ? y + 1 : b.bottom;
            b.count++;
        }
    return b;
}

static void check_plate(const char *text, double x, double y, double scale)
{
    double width, height;

    view_overlay_measure(text, scale, &width, &height);
    view_overlay_text(overlay, x, y, scale, text);
    draw();
    const box plate = find(false), ink = find(true);
    CHECK(plate.left == x && plate.top == y);
    CHECK(plate.right == (int)ceil(x + width));
    CHECK(plate.bottom == (int)ceil(y + height));
    CHECK(plate.count ==
          (plate.right - plate.left) * (plate.bottom - plate.top));
    CHECK(ink.left >= x + 4 * scale - 1 && ink.top >= y + 4 * scale - 1);
    CHECK(ink.right <= x + width - 4 * scale + 1);
    CHECK(ink.bottom <= y + height - 4 * scale + 1);
    CHECK(ink.count > 0 && ink.count < plate.count / 2);
}

TEST(text_is_where_measure_says)
{
    static const char all[] = "!\"#$%&'()*+,-./0123456789:;<=>?\n"
                              "@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_\n"
                              "`abcdefghijklmnopqrstuvwxyz{|}~";
    double w1, h1, w2, h2;

    begin();
    check_plate("H", 10, 20, 1);
    check_plate("two lines\nand more of them", 3, 5, 1);
    check_plate("columns\tof\tkeys\nq\tx\ty", 3, 5, 1);
    check_plate("scaled", 30, 40, 2);
    check_plate("by half as much", 30, 40, 1.5);
    check_plate(all, 7, 9, 1);
    view_overlay_measure("one", 1, &w1, &h1);
    view_overlay_measure("one\none", 1, &w2, &h2);
    CHECK(w1 == w2 && h2 == h1 + 12);
    view_overlay_measure("one\n", 1, &w2, &h2);
    CHECK(w1 == w2 && h2 == h1);
    view_overlay_measure("one", 3, &w2, &h2);
    CHECK(w2 == 3 * w1 && h2 == 3 * h1);
    view_overlay_measure("", 1, &w2, &h2);
    CHECK(w2 == 0 && h2 == 0);
    /* A column is 100 wide: from its beginning to the next one's. */
    view_overlay_measure("\tone", 1, &w2, &h2);
    CHECK(w2 == w1 + 100);
    view_overlay_measure("\t\tone", 1, &w2, &h2);
    CHECK(w2 == w1 + 200);
}

/* An H is two bars of seven pixels and one across; whole scales are exact. */
TEST(strokes_are_sharp)
{
    begin();
    for (int scale = 1; scale <= 3; scale++) {
        view_overlay_text(overlay, 10.2, 19.9, scale, "H");
        draw();
        const box b = find(true);
        CHECK(b.left == 10 + 4 * scale && b.top == 20 + 4 * scale);
        CHECK(b.bottom - b.top == 7 * scale);
        CHECK(b.right - b.left >= 4 * scale && b.right - b.left <= 5 * scale);
        for (int y = b.top; y < b.bottom; y++)
            for (int x = b.left; x < b.right; x++)
                CHECK(at(x, y) == 255 || at(x, y) < GREY);
        for (int y = b.top; y < b.bottom; y++)
            CHECK(at(b.left, y) == 255 && at(b.right - 1, y) == 255);
        CHECK(at((b.left + b.right) / 2, b.top) < GREY);
    }
}

/* More strokes than the vertex buffer holds, many times, partly outside of the
 * picture, and bytes that the font has not, which are question marks. The last
 * plate darkens all before it, and nothing is left for the next picture. */
TEST(any_text_is_taken)
{
    const int lines = TEST_SANITIZED ? 300 : 1500, columns = 40;
    char *text = test_alloc((size_t)lines * (columns + 1) + 1, 1);
    int dark = 0;

    begin();
    for (int i = 0; i < lines * (columns + 1); i++)
        text[i] = (char)(i % (columns + 1) == columns ? '\n'
                         : i % columns                ? 'W'
                                                      : 128 + i % 128);
    view_overlay_text(overlay, -30, HEIGHT - 12 * lines - 4, 1, text);
    view_overlay_text(overlay, 20, 10, 1, "   ");
    view_overlay_text(overlay, 1e6, -1e6, 1, "nowhere");
    draw();
    const box b = find(true);
    CHECK(b.bottom > HEIGHT - 12 && b.top < 12 && b.left < 6);
    for (int x = 20; x < 40; x++)
        for (int y = 10; y < 30; y++)
            dark += at(x, y) < 100;
    CHECK(dark == 20 * 20);
    view_overlay_text(overlay, 5, 5, 1, "\x80");
    draw();
    const int marks = find(true).count;
    CHECK(find(false).left == 5 && find(false).top == 5);
    view_overlay_text(overlay, 5, 5, 1, "?");
    draw();
    CHECK(marks > 0 && find(true).count == marks);
    draw();
    CHECK(find(false).count == 0);
}

TEST(bars_are_as_long_as_their_share)
{
    static const double shares[] = {-1, 0, 0.25, 0.5, 1, 2};

    begin();
    for (int i = 0; i < 6; i++) {
        view_overlay_bar(overlay, 20, 30, 100, 8, shares[i]);
        draw();
        const box b = find(false);
        CHECK(b.left == 20 && b.top == 30 && b.right == 120 && b.bottom == 38);
        int white = 0;
        for (int x = 0; x < WIDTH; x++)
            white += at(x, 33) == 255;
        CHECK(white == (int)(100 * fmin(fmax(shares[i], 0), 1)));
    }
}

/* Its middle is the colour of middle grey and each stop has its own. */
TEST(legends_show_the_scale)
{
    begin();
    view_overlay_legend(overlay, 10, 20, 168, 1, 0);
    draw();
    const box b = find(false);
    CHECK(b.left == 10 && b.right == 178 && b.top == 20 && b.bottom == 52);
    for (int i = -VIEW_STOPS; i < VIEW_STOPS; i++) {
        const int x = 14 + 10 * (i + VIEW_STOPS) + 1;
        double c[3];
        view_test_false_colour(i + 0.15, c);
        for (int k = 0; k < 3; k++)
            CHECK_NEAR(seen[3 * (28 * WIDTH + x) + k], 255 * c[k], 0.51);
    }
}
