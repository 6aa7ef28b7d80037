/* SPDX-License-Identifier: MIT */
/* The probes of a picture's tiles, against points of their volumes that are
 * projected (none may be missed) and against rays through the tiles' pixels
 * (few may be too many). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/probes.h"
#include "test.h"

enum {
    MOST_TILES = 40 * 40
};

/* A camera as the test knows it: axes are unit and square to each other. */
struct camera {
    double eye[3], right[3], up[3], forward[3];
    double focal_x, focal_y;
    double shift_x, shift_y; /* off the middle, in half pictures */
    bool parallel;
};

static void random_camera(test_random *r, struct camera *c)
{
    const double yaw = test_random_between(r, -3.2, 3.2),
                 pitch = test_random_between(r, -1.5, 1.5);
    const double roll =
        test_random_below(r, 2) ? test_random_between(r, -3, 3) : 0;
    const double side[3] = {cos(yaw), 0, sin(yaw)};
    const double top[3] = {sin(pitch) * sin(yaw), cos(pitch),
                           -sin(pitch) * cos(yaw)};

    *c = (struct camera){.parallel = test_random_below(r, 5) == 0};
    c->forward[0] = sin(yaw) * cos(pitch);
    c->forward[1] = -sin(pitch);
    c->forward[2] = -cos(yaw) * cos(pitch);
    for (int i = 0; i < 3; i++) {
        c->eye[i] = test_random_between(r, -3, 3);
        c->right[i] = cos(roll) * side[i] + sin(roll) * top[i];
        c->up[i] = cos(roll) * top[i] - sin(roll) * side[i];
    }
    c->focal_y = test_random_between(r, 0.4, 3) / (c->parallel ? 5 : 1);
    c->focal_x = c->focal_y * test_random_between(r, 0.5, 1);
    if (test_random_below(r, 3) == 0) {
        c->shift_x = test_random_between(r, -0.5, 0.5);
        c->shift_y = test_random_between(r, -0.5, 0.5);
    }
}

static void set_row(double clip[16], int row, const double axis[3],
                    const double eye[3], double scale)
{
    clip[12 + row] = 0;
    for (int i = 0; i < 3; i++) {
        clip[4 * i + row] = scale * axis[i];
        clip[12 + row] -= scale * axis[i] * eye[i];
    }
}

static void camera_matrix(const struct camera *c, double clip[16])
{
    const double zero[3] = {0, 0, 0};

    set_row(clip, 0, c->right, c->eye, c->focal_x);
    set_row(clip, 1, c->up, c->eye, c->focal_y);
    set_row(clip, 2, c->forward, c->eye, 1);
    set_row(clip, 3, c->parallel ? zero : c->forward, c->eye, 1);
    if (c->parallel)
        clip[15] = 1;
    for (int i = 0; i < 4; i++) {
        clip[4 * i] += c->shift_x * clip[4 * i + 3];
        clip[4 * i + 1] += c->shift_y * clip[4 * i + 3];
    }
}

/* The ray through a point of the picture, -1..1. */
static void camera_ray(const struct camera *c, double x, double y,
                       double from[3], double along[3])
{
    const double a = (x - c->shift_x) / c->focal_x;
    const double b = (y - c->shift_y) / c->focal_y;

    for (int i = 0; i < 3; i++) {
        const double off = a * c->right[i] + b * c->up[i];
        from[i] = c->eye[i] + (c->parallel ? off : 0);
        along[i] = c->forward[i] + (c->parallel ? 0 : off);
    }
}

static ibl_probe random_volume(test_random *r)
{
    ibl_probe probe = {.blend = 0.1};
    const double size = test_random_below(r, 4) ? 1.5 : 0.1;

    probe.influence.shape = (ibl_shape)test_random_below(r, 2);
    for (int i = 0; i < 3; i++) {
        probe.influence.centre[i] = test_random_between(r, -6, 6);
        probe.influence.half[i] = test_random_between(r, 0.05, 1.5) * size;
    }
    if (test_random_below(r, 5) == 0)
        probe.influence.half[test_random_below(r, 3)] =
            test_random_between(r, 2, 8);
    return probe;
}

static ibl_tiles random_tiles(test_random *r, struct camera *c)
{
    ibl_tiles tiles = {.tile = 5 + test_random_below(r, 20)};

    random_camera(r, c);
    camera_matrix(c, tiles.clip);
    tiles.width = tiles.tile * 3 + test_random_below(r, 200);
    tiles.height = 1 + test_random_below(r, 200);
    while (ibl_tiles_columns(&tiles) > 40 || ibl_tiles_rows(&tiles) > 40)
        tiles.tile++;
    return tiles;
}

/* A point of the volume, many on its border, its edges and its corners. */
static void random_point_of(test_random *r, const ibl_volume *v, double p[3])
{
    double d[3], square = 0;

    for (int i = 0; i < 3; i++) {
        d[i] = test_random_between(r, -1, 1);
        if (v->shape == IBL_SHAPE_BOX && test_random_below(r, 2))
            d[i] = d[i] < 0 ? -1 : 1;
        square += d[i] * d[i];
    }
    for (int i = 0; i < 3; i++) {
        if (v->shape == IBL_SHAPE_BOX)
            p[i] = v->centre[i] + v->half[i] * d[i];
        else
            p[i] = v->centre[i] +
                   v->half[0] * d[i] / sqrt(square) *
                       (test_random_below(r, 4) ? 1 : test_random_unit(r));
    }
}

/* The tile in which a point is seen, or -1. */
static int tile_of(const ibl_tiles *tiles, const double p[3])
{
    long double clip[4];

    for (int row = 0; row < 4; row++) {
        clip[row] = tiles->clip[12 + row];
        for (int i = 0; i < 3; i++)
            clip[row] += (long double)tiles->clip[4 * i + row] * p[i];
    }
    const long double w = clip[3];
    if (!(w > 0) || fabsl(clip[0]) >= w || fabsl(clip[1]) >= w)
        return -1;
    const int x = (int)((clip[0] / w + 1) / 2 * tiles->width);
    const int y = (int)((clip[1] / w + 1) / 2 * tiles->height);
    return y / tiles->tile * ibl_tiles_columns(tiles) + x / tiles->tile;
}

TEST(never_misses)
{
    test_random r = {1};
    static unsigned long long masks[MOST_TILES];
    ibl_probe probes[8];
    struct camera camera;
    double p[3];
    int seen = 0, crossing = 0;

    for (int n = 0; n < (TEST_SANITIZED ? 100 : 1000); n++) {
        const ibl_tiles tiles = random_tiles(&r, &camera);
        for (int i = 0; i < 8; i++) {
            probes[i] = random_volume(&r);
            /* Next to the eye, and around it. */
            if (test_random_below(&r, 3) == 0) {
                for (int k = 0; k < 3; k++)
                    probes[i].influence.centre[k] =
                        camera.eye[k] + test_random_between(&r, -1, 1);
            }
        }
        CHECK(ibl_tiles_cull(&tiles, probes, 8, masks) == IBL_OK);
        for (int i = 0; i < 8; i++) {
            int in = 0, out = 0;
            for (int k = 0; k < 400; k++) {
                random_point_of(&r, &probes[i].influence, p);
                const int at = tile_of(&tiles, p);
                out += at < 0;
                in += at >= 0;
                CHECK_MSG(at < 0 || masks[at] >> i & 1,
                          "probe %d of picture %d: not in tile %d", i, n, at);
            }
            seen += in;
            crossing += in > 0 && out > 0;
        }
    }
    CHECK_MSG(seen > 20000 && crossing > 50, "%d, %d", seen, crossing);
}

/* Whether a ray has a point in the volume, ahead of where it begins. */
static bool hits(const ibl_volume *v, bool whole, const double from[3],
                 const double along[3])
{
    double in = whole ? -1e9 : 1e-9, out = 1e9;

    if (v->shape == IBL_SHAPE_SPHERE) {
        double aa = 0, ab = 0, bb = 0;
        for (int i = 0; i < 3; i++) {
            const double off = from[i] - v->centre[i];
            aa += along[i] * along[i];
            ab += along[i] * off;
            bb += off * off;
        }
        const double root = ab * ab - aa * (bb - v->half[0] * v->half[0]);
        return root >= 0 && -ab + sqrt(root) >= in * aa;
    }
    for (int i = 0; i < 3; i++) {
        const double a = (v->centre[i] - v->half[i] - from[i]) / along[i];
        const double b = (v->centre[i] + v->half[i] - from[i]) / along[i];
        in = fmax(in, fmin(a, b));
        out = fmin(out, fmax(a, b));
    }
    return in <= out;
}

/* Whether a ray hits, of a grid over a tile with its border. */
static bool tile_hits(const ibl_tiles *tiles, const struct camera *c,
                      const ibl_volume *v, int column, int row)
{
    enum {
        GRID = 16
    };
    const double left = column * tiles->tile, bottom = row * tiles->tile;
    const double right = fmin(left + tiles->tile, tiles->width);
    const double top = fmin(bottom + tiles->tile, tiles->height);
    double from[3], along[3];

    for (int k = 0; k <= GRID; k++) {
        const double y = bottom + (top - bottom) * k / GRID;
        for (int i = 0; i <= GRID; i++) {
            const double x = left + (right - left) * i / GRID;
            camera_ray(c, 2 * x / tiles->width - 1, 2 * y / tiles->height - 1,
                       from, along);
            if (hits(v, c->parallel, from, along))
                return true;
        }
    }
    return false;
}

/* Each probe that a ray finds is listed, and few others (16 rays an edge). */
TEST(few_too_many)
{
    test_random r = {2};
    static unsigned long long masks[MOST_TILES];
    ibl_probe probes[8];
    struct camera camera;
    long named[2] = {0, 0}, found[2] = {0, 0};

    for (int n = 0; n < (TEST_SANITIZED ? 8 : 60); n++) {
        const ibl_tiles tiles = random_tiles(&r, &camera);
        const int columns = ibl_tiles_columns(&tiles);

        for (int i = 0; i < 8; i++)
            probes[i] = random_volume(&r);
        CHECK(ibl_tiles_cull(&tiles, probes, 8, masks) == IBL_OK);
        for (int t = 0; t < columns * ibl_tiles_rows(&tiles); t++) {
            for (int i = 0; i < 8; i++) {
                const ibl_volume *v = &probes[i].influence;
                const bool touched =
                    tile_hits(&tiles, &camera, v, t % columns, t / columns);
                const bool says = masks[t] >> i & 1;

                CHECK(says || !touched);
                named[v->shape] += says;
                found[v->shape] += touched;
            }
        }
    }
    for (int shape = 0; shape < 2; shape++) {
        CHECK(found[shape] > (TEST_SANITIZED ? 50 : 1000));
        CHECK_MSG((double)named[shape] <= 1.02 * (double)found[shape],
                  "%s: %ld named, %ld found", ibl_shape_name((ibl_shape)shape),
                  named[shape], found[shape]);
    }
}

static ibl_tiles looking_along_z(int width, int height, int tile)
{
    return (ibl_tiles){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -1, 0, 0, 0, 0},
                       width,
                       height,
                       tile};
}

static void all_have(const ibl_tiles *tiles, const ibl_probe *probe,
                     unsigned long long mask)
{
    static unsigned long long masks[MOST_TILES];

    CHECK(ibl_tiles_cull(tiles, probe, 1, masks) == IBL_OK);
    for (int i = 0; i < ibl_tiles_columns(tiles) * ibl_tiles_rows(tiles); i++)
        CHECK(masks[i] == mask);
}

TEST(around_and_behind)
{
    const ibl_tiles tiles = looking_along_z(100, 70, 16);

    for (int shape = 0; shape < 2; shape++) {
        ibl_probe probe = {0};

        probe.influence =
            (ibl_volume){(ibl_shape)shape, {0.1, 0.2, -0.1}, {1, 2, 1}};
        all_have(&tiles, &probe, 1);
        probe.influence.centre[2] = 2.5;
        all_have(&tiles, &probe, 0);
        /* Beside and beyond the middle plane, but out of the picture. */
        probe.influence.centre[0] = 30;
        probe.influence.centre[2] = 0;
        all_have(&tiles, &probe, 0);
        /* The size of a world, far away. */
        probe.influence =
            (ibl_volume){(ibl_shape)shape, {0, 0, -3e9}, {4e9, 4e9, 1}};
        all_have(&tiles, &probe, 1);
    }
}

/* Behind the eye, all but around it, and across the plane w = 0: only what is
 * seen opposite is near it. */
TEST(at_the_back)
{
    const ibl_tiles tiles = looking_along_z(100, 100, 10);
    unsigned long long masks[100];
    const double off = 1.002 / sqrt(3);
    ibl_probe probe = {0};

    probe.influence = (ibl_volume){IBL_SHAPE_SPHERE, {-off, -off, off}, {1}};
    CHECK(ibl_tiles_cull(&tiles, &probe, 1, masks) == IBL_OK);
    CHECK(masks[0] == 1 && masks[99] == 0);
}

/* Tiles named one by one: the last column and row are cut, the first row is at
 * the bottom. A pixel is 0.02 wide at the distance 1. */
TEST(tiles_by_hand)
{
    const ibl_tiles tiles = looking_along_z(100, 100, 30);
    unsigned long long masks[16];
    ibl_probe probes[2] = {0};

    CHECK(ibl_tiles_columns(&tiles) == 4 && ibl_tiles_rows(&tiles) == 4);
    /* x of pixels 31..59, y of pixels 91..99. */
    probes[0].influence =
        (ibl_volume){IBL_SHAPE_BOX, {-0.1, 0.9, -1}, {0.28, 0.08, 1e-9}};
    /* Around the pixel (90, 30), where four tiles meet, less than a corner. */
    probes[1].influence =
        (ibl_volume){IBL_SHAPE_SPHERE, {0.8, -0.4, -1}, {0.01}};
    CHECK(ibl_tiles_cull(&tiles, probes, 2, masks) == IBL_OK);
    for (int t = 0; t < 16; t++) {
        const bool corner = t == 2 || t == 3 || t == 6 || t == 7;
        CHECK_MSG(masks[t] == ((t == 13) | (corner ? 2U : 0U)),
                  "tile %d has %llx", t, masks[t]);
    }
    /* Beside and above the picture, where the last tiles would go on. */
    for (int k = 0; k < 2; k++) {
        probes[0].influence =
            (ibl_volume){IBL_SHAPE_BOX, {0, 0, -1}, {0.5, 0.5, 1e-9}};
        probes[0].influence.centre[k] = 1.1;
        probes[0].influence.half[k] = 0.05;
        all_have(&tiles, probes, 0);
    }
}

/* A body's side on the border of tiles, all exact, is in those on both. */
TEST(touching)
{
    const ibl_tiles tiles = looking_along_z(64, 64, 16);
    unsigned long long masks[16];
    ibl_probe probe = {0};

    probe.influence =
        (ibl_volume){IBL_SHAPE_BOX, {0.25, 0.25, -1}, {0.25, 0.25, 0}};
    CHECK(ibl_tiles_cull(&tiles, &probe, 1, masks) == IBL_OK);
    for (int t = 0; t < 16; t++)
        CHECK_MSG(masks[t] == (t % 4 > 0 && t > 3), "tile %d", t);
}

TEST(sixty_four)
{
    test_random r = {3};
    static unsigned long long masks[MOST_TILES], one[MOST_TILES];
    ibl_probe probes[IBL_MAX_TILE_PROBES + 1];
    struct camera camera;
    const ibl_tiles tiles = random_tiles(&r, &camera);
    const int count = ibl_tiles_columns(&tiles) * ibl_tiles_rows(&tiles);

    for (int i = 0; i <= IBL_MAX_TILE_PROBES; i++)
        probes[i] = random_volume(&r);
    CHECK(ibl_tiles_cull(&tiles, probes, IBL_MAX_TILE_PROBES, masks) == IBL_OK);
    for (int i = 0; i < IBL_MAX_TILE_PROBES; i++) {
        CHECK(ibl_tiles_cull(&tiles, &probes[i], 1, one) == IBL_OK);
        for (int t = 0; t < count; t++)
            CHECK((masks[t] >> i & 1) == one[t]);
    }
    CHECK(ibl_tiles_cull(&tiles, probes, 0, masks) == IBL_OK);
    for (int t = 0; t < count; t++)
        CHECK(masks[t] == 0);
}

TEST(refuses)
{
    const ibl_tiles good = looking_along_z(8, 8, 4);
    ibl_tiles bad[3] = {good, good, good}, tiles = good;
    unsigned long long masks[4] = {7, 7, 7, 7};
    const ibl_probe probes[IBL_MAX_TILE_PROBES + 1] = {0};

    CHECK(ibl_tiles_cull(&good, probes, IBL_MAX_TILE_PROBES + 1, masks) ==
          IBL_ERR_ARGUMENT);
    CHECK(ibl_tiles_cull(&good, probes, -1, masks) == IBL_ERR_ARGUMENT);
    bad[0].width = 0;
    bad[1].height = IBL_MAX_EDGE + 1;
    bad[2].tile = 0;
    for (int i = 0; i < 3; i++)
        CHECK(ibl_tiles_cull(&bad[i], probes, 1, masks) == IBL_ERR_ARGUMENT);
    for (int i = 0; i < 4; i++)
        CHECK(masks[i] == 7);
    tiles.tile = 2147483647;
    CHECK(ibl_tiles_columns(&tiles) == 1 && ibl_tiles_rows(&tiles) == 1);
}
