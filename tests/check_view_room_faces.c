/* SPDX-License-Identifier: MIT */
/* The room as captures draw it, in six faces or two paraboloids, against rays.
 */
#include "lit_room.h"
#include "view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ibl/ibl.h"
#include "view/capture.h"

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static const double middle[3] = {1.11, 2.07, 0.83};

/* Where x, y and z point, from the middle; of a projection or a paraboloid. */
static void look(view_room_draw *d, double axes[3][3])
{
    const double near = 0.05, far = 40;
    const double a = (far + near) / (far - near);
    const double b = -2 * far * near / (far - near);

    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 4; i++) {
            const double *axis = axes[i < 2 ? i : 2];
            const double at = k < 3 ? axis[k] : -dot(axis, middle);
            const bool depth = i == 2 && !d->paraboloid;
            d->clip[4 * k + i] = depth ? a * at + (k == 3 ? b : 0) : at;
            if (d->paraboloid)
                d->clip[4 * k + i] = i < 3 ? at / far : k == 3 ? near / far : 0;
        }
    memcpy(d->eye, middle, sizeof d->eye);
}

/* The other way round, pixels of a face in rows as they are drawn. */
static void face_axes(int face, double axes[3][3])
{
    double corner[4][3];

    for (int i = 0; i < 3; i++) {
        ibl_cube_direction(2, face, i == 0, i == 1, corner[i]);
        const double most = fmax(fabs(corner[i][0]),
                                 fmax(fabs(corner[i][1]), fabs(corner[i][2])));
        for (int k = 0; k < 3; k++)
            corner[i][k] /= most;
    }
    for (int k = 0; k < 3; k++) {
        axes[0][k] = corner[0][k] - corner[2][k];
        axes[1][k] = corner[1][k] - corner[2][k];
        axes[2][k] = (corner[0][k] + corner[1][k]) / 2;
    }
}

static bool sees(const view_room_draw *d, const float *pixel,
                 const double direction[3])
{
    const room_hit h = room_cast(d, middle, direction);

    return lit_has_colour(pixel, &h, 1e-4);
}

/* Every texel of all faces, but where two things meet. */
static void six_faces(void)
{
    enum {
        SIZE = 48
    };
    static const int ahead[6] = {31, 29, 25, 13, 36, 32}; /* boxes */
    const view_camera any = {.near = 1, .far = 2};

    if (!lit_begin(SIZE, SIZE))
        return;
    for (int face = 0; face < IBL_FACES; face++) {
        view_room_draw d = lit_draw(&any);
        double axes[3][3], direction[3];
        face_axes(face, axes);
        look(&d, axes);
        const room_hit h = room_cast(&d, middle, axes[2]);
        CHECK_MSG(h.what == ahead[face], "face %d: box %d", face, h.what);
        float *picture = lit_render(&d);
        int bad = 0;
        for (int i = 0; i < SIZE * SIZE; i++) {
            const int x = i % SIZE, y = SIZE - 1 - i / SIZE;
            ibl_cube_direction(SIZE, face, x, y, direction);
            bad += !sees(&d, picture + 4 * i, direction);
        }
        CHECK_MSG(bad <= 6, "face %d: %d texels", face, bad);
        free(picture);
    }
    lit_end();
}

/* Triangles have straight edges there, so that edges are up to a pixel away. */
static void paraboloids(void)
{
    enum {
        SIZE = 64
    };
    const view_camera any = {.near = 1, .far = 2};

    if (!lit_begin(SIZE, SIZE))
        return;
    for (int side = 0; side < 2; side++) {
        const double s = side ? -1 : 1;
        double axes[3][3] = {{s, 0, 0}, {0, 1, 0}, {0, 0, s}};
        view_room_draw d = lit_draw(&any);
        d.paraboloid = true;
        look(&d, axes);
        float *picture = lit_render(&d);
        int bad = 0, all = 0;
        for (int i = 0; i < SIZE * SIZE; i++) {
            const double fill = 0.9375; /* of the picture */
            const double x = ((i % SIZE + 0.5) * 2 / SIZE - 1) / fill;
            const double y = (1 - (i / SIZE + 0.5) * 2 / SIZE) / fill;
            bool seen = false;
            if (x * x + y * y > 1)
                continue;
            for (int k = 0; k < 9; k++) {
                const double u = x + (k % 3 - 1) * 1.5 / SIZE;
                const double v = y + (k / 3 - 1) * 1.5 / SIZE;
                const double r2 = 1 + u * u + v * v;
                const double direction[3] = {s * 2 * u / r2, 2 * v / r2,
                                             s * (2 - r2) / r2};
                seen = seen || sees(&d, picture + 4 * i, direction);
            }
            bad += !seen;
            all++;
        }
        CHECK_MSG(bad * 200 <= all, "side %d: %d of %d pixels", side, bad, all);
        free(picture);
    }
    lit_end();
}

/* What a capture asks for, drawn as it is asked. */
static void capture_scene(void *cookie, const double clip[16],
                          const double eye[3], int size, int side)
{
    view_room_draw d = *(const view_room_draw *)cookie;

    (void)size;
    memcpy(d.clip, clip, sizeof d.clip);
    memcpy(d.eye, eye, sizeof d.eye);
    d.paraboloid = side >= 0;
    view_room_render(lit.room, &d);
}

/* Whether a texel sees that, or what is up to so many texels away; or it is
 * between two things, and may be a mix of them. */
static bool texel_sees(const view_room_draw *d, const double from[3],
                       const ibl_cube *cube, int face, int x, int y,
                       double around)
{
    enum {
        FINE = 64
    };
    const view_room_material *first = NULL;
    const float *texel =
        ibl_cube_face(cube, 0, face) + 3 * ((size_t)y * cube->size + x);

    for (int i = 0; i < 9; i++) {
        double direction[3];
        ibl_cube_direction(
            cube->size * FINE, face,
            x * FINE + FINE / 2 + (int)(around * FINE) * ((i + 1) % 3 - 1),
            y * FINE + FINE / 2 + (int)(around * FINE) * ((i + 4) / 3 % 3 - 1),
            direction);
        const room_hit h = room_cast(d, from, direction);
        if (lit_has_colour(texel, &h, 2e-3) || (i && h.material != first))
            return true;
        first = h.material;
    }
    return false;
}

/* Captures of the room see what is there, whichever way they are made. */
static void captured(view_probe_capture kind, const double from[3],
                     double around, int most)
{
    enum {
        SIZE = 64
    };
    const view_camera any = {.near = 1, .far = 2};
    view_capture_options o = view_capture_options_default();
    ibl_cube cube = {0};
    int bad = 0;

    if (!lit_begin(4, 4))
        return;
    ibl_ctx *ctx = test_ctx(1, IBL_ISA_AUTO);
    view_room_draw d = lit_draw(&any);
    o.kind = kind;
    o.size = SIZE;
    o.samples = 1;
    o.far = 40;
    view_capture *c = view_capture_create(&o);
    const bool ok = c && view_capture_update(c, from, capture_scene, &d) &&
                    ibl_cube_alloc(ctx, SIZE, 1, &cube) == IBL_OK &&
                    view_capture_read(c, &cube);
    CHECK(ok);
    for (int i = 0; ok && i < IBL_FACES * SIZE * SIZE; i++)
        bad += !texel_sees(&d, from, &cube, i / (SIZE * SIZE), i % SIZE,
                           i / SIZE % SIZE, around);
    CHECK_MSG(bad <= most, "%d of %d texels", bad, IBL_FACES * SIZE * SIZE);
    ibl_cube_free(&cube);
    view_capture_free(c);
    ibl_ctx_free(ctx);
    lit_end();
}

static void captured_faces(void)
{
    captured(VIEW_PROBE_FACES, middle, 0.1, 0);
}

/* Edges of triangles are straight there, so that some are further away. */
static void captured_paraboloids(void)
{
    captured(VIEW_PROBE_PARABOLOIDS, middle, 1.5, 24);
}

/* The mirror is not in the way of what is captured within it. */
static void captured_in_mirror(void)
{
    double centre[3], radius;

    view_room_sphere(0, 0, centre, &radius);
    captured(VIEW_PROBE_FACES, centre, 0.1, 0);
    captured(VIEW_PROBE_PARABOLOIDS, centre, 1.5, 48);
}

static const test tests[] = {
    TEST(six_faces),          TEST(paraboloids),
    TEST(captured_faces),     TEST(captured_paraboloids),
    TEST(captured_in_mirror),
};
TEST_MAIN(tests)
