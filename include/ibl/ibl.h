/* SPDX-License-Identifier: MIT */
/*
 * iblbake: image-based lighting from an equirectangular environment map.
 *
 * This header declares the bake: types, conventions, options and calls.
 * <ibl/io.h> reads images and writes textures.
 *
 * CONVENTIONS (for the whole library; defined only here)
 *
 *   World        right-handed, +Y up.
 *   Equirect     row 0 is the zenith (+Y). Columns follow
 *                u = atan2(z, x) / 2pi + 1/2: the centre column looks
 *                along +X and u grows from +X towards +Z. Pixel (i, j) of a
 *                w x h map is centred on u = (i + .5) / w,
 *                theta = pi (j + .5) / h from +Y, and covers the solid angle
 *                2pi/w (cos(pi j / h) - cos(pi (j + 1) / h)).
 *   Cube faces   in the order +X -X +Y -Y +Z -Z, row 0 on top. With
 *                u = 2 (i + .5) / n - 1 and v = 2 (j + .5) / n - 1, texel
 *                (i, j) looks along (not normalised)
 *                  +X ( 1, -v, -u)   -X (-1, -v,  u)
 *                  +Y ( u,  1,  v)   -Y ( u, -1, -v)
 *                  +Z ( u, -v,  1)   -Z (-u, -v, -1)
 *                as in OpenGL, Direct3D, Vulkan, KTX and DDS.
 *   Colour       linear RGB, scene-referred, with the primaries of the
 *                source; no tone mapping anywhere.
 *   Roughness    perceptual, 0..1. A lobe's width is alpha = roughness^2.
 *   Threads      only one caller may use a context at a time. Its calls run
 *                on the context's pool. Different contexts are independent.
 *                Every output has the same bytes for any number of threads.
 *   Errors       functions that can fail return ibl_status, 0 for success.
 *                They report the reason through the context's log callback
 *                (one line with file, value and limit). Unless a function
 *                says otherwise, an ARGUMENT error leaves its output
 *                unchanged, and after any error the output holds nothing to
 *                free.
 *   Options      structs named *_options. *_options_default returns the
 *                defaults, of which a program changes what it wants other;
 *                those of a zeroed struct are not always the same.
 *   NULL         is allowed only where a comment says so. Elsewhere, functions
 *                that return ibl_status return IBL_ERR_ARGUMENT, without a log
 *                line if the context, or an object that holds it, is NULL.
 *                Other functions must not be given NULL.
 */
#ifndef IBL_IBL_H
#define IBL_IBL_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The shared library exports what is declared between these. */
#if defined(__GNUC__)
#define IBL_API_BEGIN _Pragma("GCC visibility push(default)")
#define IBL_API_END _Pragma("GCC visibility pop")
#else
#define IBL_API_BEGIN
#define IBL_API_END
#endif
IBL_API_BEGIN

#define IBL_VERSION_MAJOR 0
#define IBL_VERSION_MINOR 2
#define IBL_VERSION_PATCH 0
/* For #if: IBL_VERSION_NUMBER >= 200 is 0.2.0 or later. */
#define IBL_VERSION_NUMBER                                                     \
    (IBL_VERSION_MAJOR * 10000 + IBL_VERSION_MINOR * 100 + IBL_VERSION_PATCH)
#define IBL_VERSION "0.2.0"

/* IBL_VERSION of the library that runs. Until 1.0 a program is compiled again
 * for each version with other structs or calls, which has another SONAME. */
const char *ibl_version(void);

typedef enum ibl_status {
    IBL_OK = 0,
    IBL_ERR_ARGUMENT,    /* a value outside its documented range */
    IBL_ERR_MEMORY,      /* out of memory, or larger than the library takes */
    IBL_ERR_IO,          /* the system could not open, read or write */
    IBL_ERR_FORMAT,      /* not the format it claims, corrupt or truncated */
    IBL_ERR_UNSUPPORTED, /* valid, but not possible with what is installed */
    IBL_ERR_CANCELLED    /* ibl_ctx_cancel was called */
} ibl_status;

/* A short English phrase for a status; never NULL. Do not free it. */
const char *ibl_status_text(ibl_status status);

/* ---- context -------------------------------------------------------- */

/* Instruction sets of the hot loops. Those of the same arithmetic give the same
 * bytes; fused and plain results differ by rounding. */
typedef enum ibl_isa {
    IBL_ISA_AUTO = 0, /* the best that this CPU has */
    IBL_ISA_C,        /* for every CPU */
    IBL_ISA_SSE2,
    IBL_ISA_AVX2, /* AVX2 + FMA + F16C */
    IBL_ISA_NEON, /* of every aarch64 */
    IBL_ISA_COUNT
} ibl_isa;

/* "auto", "c", "sse2", "avx2" or "neon"; else "unknown". */
const char *ibl_isa_name(ibl_isa isa);
/* "fused", products and sums rounded once (AVX2, NEON), or "plain". */
const char *ibl_isa_arithmetic(ibl_isa isa);
/* The best set that this CPU and build have; never IBL_ISA_AUTO. */
ibl_isa ibl_isa_best(void);
/* 1 if they have isa, else 0; 0 for IBL_ISA_AUTO. */
int ibl_isa_supported(ibl_isa isa);

typedef enum ibl_log_level {
    IBL_LOG_ERROR,   /* why a call failed */
    IBL_LOG_WARNING, /* the call continued, but the user should know */
    IBL_LOG_INFO     /* what was done */
} ibl_log_level;

/* Receives one line without a newline, on the thread that made the call. */
typedef void ibl_log_fn(void *cookie, ibl_log_level level, const char *text);

/*
 * Receives what was finished, on the thread that made the call.
 *   stage  the running stage ("decode", "level 0", "specular 3", ...); valid
 *          only during the call
 *   done   the finished share of the stage, 0..1. A stage reports at least its
 *          start (0) and its end (1); stages may run side by side
 *   whole  the finished share of a bake of cubes or harmonics, of all its
 *          stages by their usual times: 0..1, never falls, and is 1 in the last
 *          report; -1 in calls that bake none
 */
typedef void ibl_progress_fn(void *cookie, const char *stage, double done,
                             double whole);

/* Where the library takes memory: for all that it allocates itself, results
 * too, from any thread. OpenEXRCore takes its own there as well; other
 * libraries use the C library's. */
typedef struct ibl_allocator {
    /* `bytes`, 1 or more, aligned to a power of two; NULL: there are none */
    void *(*alloc)(void *cookie, size_t bytes, size_t alignment);
    void (*release)(void *cookie, void *memory); /* never NULL */
    void *cookie;
} ibl_allocator;

/*
 * Sets it for the whole process; copied. NULL: the C library's, in huge pages
 * where it is much, and some is kept between calls while there is a context.
 * Call it before the first context and while nothing that the library allocated
 * is left: memory goes back to what is set then.
 * IBL_ERR_ARGUMENT: a function is NULL, or there is a context.
 */
ibl_status ibl_set_allocator(const ibl_allocator *allocator);

typedef struct ibl_ctx_options {
    int threads;               /* 1..1024; 0: ibl_cpu_count() */
    ibl_isa isa;               /* default IBL_ISA_AUTO */
    ibl_log_fn *log;           /* NULL: silence */
    void *log_cookie;          /* passed to log */
    ibl_progress_fn *progress; /* NULL: none */
    void *progress_cookie;     /* passed to progress */
    const char *bridge;        /* path of the image bridge; NULL: the path
                                  compiled in, see ibl/io.h. Copied. */
    size_t memory;             /* most bytes that a whole map, the texels of
                                  a file or what comes from a pipe may take;
                                  0: no limit */
} ibl_ctx_options;

typedef struct ibl_ctx ibl_ctx;

/* Number of CPUs that this process may use: online, in its affinity mask, and
 * within its cgroup's quota (rounded up). At least 1. */
int ibl_cpu_count(void);

/* Bytes of memory that this process may use: the machine's, or what its cgroup
 * allows. 0: unknown. */
size_t ibl_memory_allowed(void);

ibl_ctx_options ibl_ctx_options_default(void);

/*
 * Makes a context with its pool of threads. These threads block all signals
 * except faults, so handlers run on other threads. opts: NULL for defaults.
 * IBL_ERR_ARGUMENT: threads or isa out of range. IBL_ERR_UNSUPPORTED: the CPU
 * lacks the instruction set. IBL_ERR_MEMORY: no memory. *ctx is NULL after an
 * error. Threads that the system does not have do not work.
 */
ibl_status ibl_ctx_create(const ibl_ctx_options *opts, ibl_ctx **ctx);
void ibl_ctx_free(ibl_ctx *ctx); /* NULL is fine */

int ibl_ctx_threads(const ibl_ctx *ctx);
ibl_isa ibl_ctx_isa(const ibl_ctx *ctx); /* the set in use, never AUTO */

/*
 * The running call returns IBL_ERR_CANCELLED as soon as its running jobs end
 * (some milliseconds), and so does every later call. Callable from any thread
 * and from a signal handler.
 */
void ibl_ctx_cancel(ibl_ctx *ctx);

/* ---- images --------------------------------------------------------- */

/* Largest width or height that the library accepts, in pixels. */
#define IBL_MAX_EDGE 65536

/*
 * An equirectangular map: height rows of width texels of 3 floats R, G, B,
 * tightly packed, row 0 at the zenith. The bake calls accept any aspect ratio.
 * All values must be finite and >= 0, which bakes do not check: ibl_image_read
 * and ibl_source_of_pixels in ibl/io.h ensure it.
 */
typedef struct ibl_image {
    int width;   /* 1..IBL_MAX_EDGE */
    int height;  /* 1..IBL_MAX_EDGE */
    float *data; /* 3 * width * height floats */
} ibl_image;

/* Allocates an image, contents undefined. Free with ibl_image_free. */
ibl_status ibl_image_alloc(ibl_ctx *ctx, int width, int height, ibl_image *img);
void ibl_image_free(ibl_image *img); /* NULL and zeroed are fine */

#define IBL_FACES 6
#define IBL_MAX_CUBE_SIZE 16384 /* texels along a face's edge */
#define IBL_MAX_LEVELS 15       /* of a cube of IBL_MAX_CUBE_SIZE */

/*
 * How the texels of a level lie on the sphere. n is the edge of the faces that
 * the level has, or would have, as a cube.
 *   CUBE        six faces of n x n texels
 *   EQUIRECT    one image of 4n x 2n texels, as Equirect in CONVENTIONS
 *   OCTAHEDRAL  one image of 2n x 2n texels. Texel (i, j), with
 *               u = (i + .5) / n - 1, v = (j + .5) / n - 1, h = 1 - |u| - |v|,
 *               looks along (u, h, v), and where h < 0 along
 *               (sgn(u) (1 - |v|), h, sgn(v) (1 - |u|)), not normalised: +Y is
 *               in the middle, with u and v as on the face +Y; the borders are
 *               folded, each in its middle, and -Y is at all four corners
 *               (Engelhardt and Dachsbacher 2008, "Octahedron Environment
 *               Maps"). The largest texel is 1.3 times the largest of a cube.
 *               The texture has no border: ibl.glsl filters across the seams.
 */
typedef enum ibl_projection {
    IBL_PROJECTION_CUBE,
    IBL_PROJECTION_EQUIRECT,
    IBL_PROJECTION_OCTAHEDRAL
} ibl_projection;

/* "cube", "equirect" or "octahedral". */
const char *ibl_projection_name(ibl_projection projection);

/*
 * A map with its mip chain, RGB floats; a cube unless projection says
 * otherwise. Level l has faces of n = max(size >> l, 1) texels squared, or one
 * flat image, see ibl_projection. Order: levels from the largest, then the six
 * faces of a level, then the rows of a face from the top. No padding.
 * Functions take cubes only, unless they say so.
 */
typedef struct ibl_cube {
    int size;    /* n of level 0, 1..IBL_MAX_CUBE_SIZE; if flat, a multiple of
                    2^(levels - 1): every level halves the one before */
    int levels;  /* 1..floor(log2(size)) + 1 */
    float *data; /* RGB of every texel */
    ibl_projection projection;
} ibl_cube;

/* Allocates a cube, contents undefined. Free with ibl_cube_free.
 * IBL_ERR_ARGUMENT: size or levels out of range. */
ibl_status ibl_cube_alloc(ibl_ctx *ctx, int size, int levels, ibl_cube *cube);
void ibl_cube_free(ibl_cube *cube); /* NULL and zeroed are fine */

/* The same for any projection. IBL_ERR_ARGUMENT: also a projection out of
 * range, or a flat size that does not halve. */
ibl_status ibl_cube_alloc_as(ibl_ctx *ctx, ibl_projection projection, int size,
                             int levels, ibl_cube *map);
/* The image or the six images of a level, for any projection. */
typedef struct ibl_level_shape {
    ibl_projection projection;
    int width, height, faces;
} ibl_level_shape;

/* Shape of a level with faces of n x n texels, or with as much detail. */
ibl_level_shape ibl_level_shape_of(ibl_projection projection, int n);
/* Unit direction of the centre of texel (x, y) of an image. */
void ibl_level_direction(const ibl_level_shape *shape, int face, int x, int y,
                         double dir[3]);
/* Solid angle of texel (x, y), in steradians; those of a level sum to 4 pi. */
double ibl_level_solid_angle(const ibl_level_shape *shape, int x, int y);

/* The texel of a level that a direction of any length hits: its face, column
 * and row. */
void ibl_level_texel(const ibl_level_shape *shape, const double dir[3],
                     int at[3]);
/* What ibl.glsl's lookup sees of a level of a flat map: bilinear, without
 * seams. */
void ibl_flat_lookup(const ibl_cube *map, int level, const double dir[3],
                     double rgb[3]);
/*
 * A flat map as a cube (empty; free with ibl_cube_free) of twice its size, for
 * programs that draw cubes: each texel is ibl_flat_lookup of the same level.
 * IBL_ERR_ARGUMENT: flat is none, or larger than IBL_MAX_CUBE_SIZE / 2.
 */
ibl_status ibl_cube_from_flat(ibl_ctx *ctx, const ibl_cube *flat,
                              ibl_cube *cube);

/* Texels of the first `levels` levels of a cube of `size`, all faces. */
size_t ibl_cube_texels(int size, int levels);
/* Edge of a level in texels: max(size >> level, 1). */
int ibl_cube_edge(int size, int level);
/* The first texel of a level's face: 3 floats, row-major from there. For any
 * projection; a flat level has face 0. */
float *ibl_cube_face(const ibl_cube *cube, int level, int face);
/* Unit direction of the centre of texel (x, y) of a face of `size`. */
void ibl_cube_direction(int size, int face, int x, int y, double dir[3]);
/* Solid angle of texel (x, y) of a face of `size`, in steradians. All
 * 6 size^2 texels sum to 4 pi. */
double ibl_cube_solid_angle(int size, int x, int y);

/* ---- bakes ---------------------------------------------------------- */

/* In all bakes, NULL options mean the defaults. */

/* Mapping from level to roughness r; t = level / (levels - 1) (0 for a single
 * level). */
typedef enum ibl_roughness_map {
    IBL_ROUGHNESS_LINEAR,   /* r = t: a shader uses lod = r (levels - 1) */
    IBL_ROUGHNESS_FILAMENT, /* t = r (2 - r), r = 1 - sqrt(1 - t): a shader
                               uses lod = r (2 - r) (levels - 1) */
    IBL_ROUGHNESS_BABYLON   /* alpha = min(2^(level / 0.8) / size, 1), level 0
                               of roughness 0, whatever their number: a shader
                               uses lod = 0.8 log2(size alpha), as Babylon.js
                               does */
} ibl_roughness_map;

/* "linear", "filament" or "babylon". */
const char *ibl_roughness_map_name(ibl_roughness_map map);
/* Perceptual roughness of a level, for a chain over the whole range 0..1. Of
 * IBL_ROUGHNESS_BABYLON, for all levels down to 1x1: size 2^(levels - 1). */
double ibl_level_roughness(ibl_roughness_map map, int level, int levels);
/* The default number of levels: the last level is the smallest of at least 8x8
 * or, for cubes smaller than 8, 1x1. (IBL_ROUGHNESS_BABYLON: always 1x1.) */
int ibl_default_levels(int size);

/*
 * Level 0: the environment as a cube. Each source pixel is a patch of constant
 * radiance, and each texel is the average of these patches over its solid
 * angle. The result is linear in the source and never leaves its range. If
 * pixels are larger than texels (width < 4 size or height < 2 size), the source
 * is first divided into finer pixels, a row of them at least 4 size and 512, a
 * column at least 2 size: linear along a row, which wraps around, and between
 * rows such that every pixel keeps its energy; beyond a pole is the row next to
 * it, turned by 180 degrees.
 *   env       the map
 *   yaw_deg   turns the environment about +Y, counter-clockwise seen from
 *             above; any finite value
 *   cube      allocated, any size; only level 0 is written
 */
ibl_status ibl_cube_from_latlong(ibl_ctx *ctx, const ibl_image *env,
                                 double yaw_deg, ibl_cube *cube);

/*
 * The same for a flat map (allocated), all its levels: each texel is the
 * average over its solid angle, of the same patches. Constants stay constant
 * and no value leaves the range of the source. Exact for both projections.
 * IBL_ERR_ARGUMENT: map is a cube.
 */
ibl_status ibl_flat_from_latlong(ibl_ctx *ctx, const ibl_image *env,
                                 double yaw_deg, const ibl_cube *map);

/*
 * The inverse: fills map (allocated, width a multiple of 8, height even) from
 * level 0 of cube. Each texel is a patch of constant radiance, and each pixel
 * is the average of these patches over its solid angle. So a constant stays
 * constant, no value leaves the range of the cube, and each texel's energy is
 * kept to 1e-6.
 * IBL_ERR_ARGUMENT: width or height. IBL_ERR_MEMORY: map is unspecified.
 */
ibl_status ibl_latlong_from_cube(ibl_ctx *ctx, const ibl_cube *cube,
                                 ibl_image *map);
/* Width of a map that keeps the whole detail of a cube of this size: 8 size, at
 * least 256, at most IBL_MAX_EDGE. The height is half the width. */
int ibl_latlong_width(int size);

/*
 * Fills levels 1.. of cube from level 0. Each texel is the average of the 2x2
 * texels above it (3 along an odd edge), weighted by their solid angles.
 */
ibl_status ibl_cube_build_mips(ibl_ctx *ctx, ibl_cube *cube);

/* ---- axes ------------------------------------------------------------- */

typedef enum ibl_mirror { /* the axis of the world that is negated, or two
                             that change places */
    IBL_MIRROR_NONE,
    IBL_MIRROR_X, /* -X and +X change places */
    IBL_MIRROR_Z,
    IBL_MIRROR_XZ /* +X and +Z change places: (x, y, z) becomes (z, y, x) */
} ibl_mirror;

typedef enum ibl_up { /* the output's axis that is the world's +Y */
    IBL_UP_Y,
    IBL_UP_Z /* (x, y, z) becomes (x, -z, y) */
} ibl_up;

/*
 * The axes of outputs for a program with other conventions than the world's:
 * first the mirror, then the turn. Bakes are in the world's axes; the functions
 * below turn what was baked, exactly. Zeroed: the world's axes.
 */
typedef struct ibl_axes {
    ibl_mirror mirror;
    ibl_up up;
} ibl_axes;

/* "none", "x", "z" or "xz"; "y" or "z"; else "unknown". */
const char *ibl_mirror_name(ibl_mirror mirror);
const char *ibl_up_name(ibl_up up);

/* A direction of the world in other axes; back: 1 for the reverse. `from` and
 * `to` may be the same. axes must be in range. */
void ibl_axes_turn(ibl_axes axes, int back, const double from[3], double to[3]);

/*
 * A cube in other axes: a permutation of its texels, at every level. A flat map
 * can be mirrored.
 *   back  1: from other axes to the world's
 *   out   empty; allocated here, to be freed with ibl_cube_free
 * IBL_ERR_ARGUMENT: a cube or axes out of range, a flat map with +Z up.
 */
ibl_status ibl_cube_turn_axes(ibl_ctx *ctx, const ibl_cube *from, ibl_axes axes,
                              int back, ibl_cube *out);

/*
 * Spherical harmonics in other axes, changed in place: exact to the rounding of
 * doubles. Takes some 100 degree^4 steps: a second for IBL_MAX_SH_DEGREE.
 *   coeffs  3 (degree + 1)^2 doubles as in ibl_bake_sh
 * IBL_ERR_ARGUMENT: degree or axes out of range. IBL_ERR_MEMORY.
 */
ibl_status ibl_sh_turn_axes(ibl_ctx *ctx, int degree, ibl_axes axes, int back,
                            double *coeffs);

/*
 * The lobe that a level of a specular chain is convolved with. Its weight w
 * depends only on the angle psi from R to L. N = V = R, so N.L = cos(psi) and
 * N.H = cos(psi / 2); alpha = roughness^2. w is 0 below the horizon, at
 * psi > 90 degrees. If a chain begins at roughness 0, its level 0 is the
 * environment for every lobe.
 *
 *   GGX      D_ggx(N.H; alpha) N.L (Walter et al. 2007, eq. 33; Karis 2013).
 *   CHARLIE  D(N.H) N.L, D = (2 + 1/alpha) sin(theta_h)^(1/alpha) / 2pi: the
 *            sheen of glTF's KHR_materials_sheen (Estevez and Kulla 2017). It
 *            is 0 at the mirror direction. As alpha falls it becomes a ring on
 *            the horizon, not a mirror, so level 0 is not its limit. A shader
 *            should not go below the roughness of level 1.
 *   PHONG    (N.L)^(n + 1), n = (1/alpha^2 - 1) / 2: a cosine power about R
 *            times a cosine. n is a quarter of 2/alpha^2 - 2, the Blinn-Phong
 *            exponent as wide as GGX's alpha, because the angle to R is twice
 *            that to H (the 1/4 of Lagarde's CubemapGen and of cmft's
 *            "blinnbrdf").
 *
 * At roughness 1 GGX and PHONG are the cosine, so that level is irradiance/pi.
 */
typedef enum ibl_lobe {
    IBL_LOBE_GGX,
    IBL_LOBE_CHARLIE,
    IBL_LOBE_PHONG
} ibl_lobe;
#define IBL_LOBE_COUNT 3
#define IBL_LOBE_NAMES "ggx", "charlie", "phong" /* in that order */

/* One of IBL_LOBE_NAMES. */
const char *ibl_lobe_name(ibl_lobe lobe);

/* How the levels of a specular chain are made. */
typedef enum ibl_method {
    IBL_METHOD_SPECTRAL, /* exact: see ibl_bake_specular */
    IBL_METHOD_SAMPLED
} ibl_method;

/* A fifth of the rounding error of a half float. */
#define IBL_TOLERANCE_DEFAULT 1e-4

typedef struct ibl_specular_options {
    ibl_projection projection; /* default IBL_PROJECTION_CUBE; flat levels are
                                  never sampled */
    ibl_method method;         /* default IBL_METHOD_SPECTRAL */
    ibl_lobe lobe;             /* default IBL_LOBE_GGX */
    int size;                  /* edge of level 0, 1..IBL_MAX_CUBE_SIZE,
                                  default 256 */
    int levels;                /* 1..floor(log2(size)) + 1; default 0: see
                                  ibl_specular_layout */
    ibl_roughness_map mapping; /* default IBL_ROUGHNESS_FILAMENT */
    double roughness_min;      /* the range of roughness, in 0..1, default */
    double roughness_max;      /*   all of it: see ibl_specular_layout */
    double tolerance; /* 1e-6..1, default IBL_TOLERANCE_DEFAULT: the largest
                         relative error (95th percentile) accepted for every
                         spectral level and for irradiance */
    double yaw_deg;   /* as in ibl_cube_from_latlong */
    /* Only for sampled levels: */
    int samples;     /* per texel, 1..1048576, default 1024 */
    double lod_bias; /* added to the lookups' mip level, -4..4; a smaller value
                        shows single samples, a larger one blurs the horizon.
                        Default NAN: log2(samples / 64) / 6 of each level, but
                        within 0..1, the best in measurements of 32 to 4096
                        samples */
    int jitter;      /* 1: rotate the sample pattern by a hash of the texel;
                        default 0 */
    int pdf_mip;     /* 0: every lookup is at mip 0, as in the first version of
                        many tutorials; default 1 */
} ibl_specular_options;

ibl_specular_options ibl_specular_options_default(void);

/*
 * The levels of a specular chain, and the lod of a roughness r in a shader:
 *     lod = x lod_scale + lod_offset,   x = r       (linear mapping)
 *                                       x = r (2 - r)     (Filament's)
 *                                       x = log2(r^2)     (Babylon's)
 * clamped to 0..levels - 1.
 */
typedef struct ibl_specular_layout {
    int size, levels; /* of the cube that ibl_bake_specular makes */
    double roughness[IBL_MAX_LEVELS]; /* of each level */
    ibl_roughness_map mapping;
    double lod_scale, lod_offset;
} ibl_specular_layout;

/* The lod, 0..levels - 1. */
double ibl_lod_of_roughness(const ibl_specular_layout *layout,
                            double roughness);

/*
 * The layout for these options. Only this function defines a level's roughness.
 * The levels have equal steps of x from roughness_min to roughness_max;
 * Babylon's are for the whole range only. For the whole range, 0..1, this gives
 * r = ibl_level_roughness(mapping, level, levels), the given size and, by
 * default, ibl_default_levels(size); with Babylon's mapping all levels.
 *
 * For a part of the range:
 *   size    the given one if roughness_min is 0, else the edge that a lobe of
 *           roughness_min needs, 5 pi / (2 alpha) texels, but no more than the
 *           whole chain of the given size has there; rounded up so that every
 *           level halves it
 *   levels  by default, the number that brings the last edge nearest to that of
 *           roughness_max, at least two if the first edge has two texels. If
 *           roughness_min = roughness_max there is one, and more are an error
 * IBL_ERR_ARGUMENT: size, levels, mapping or range out of range; nothing is
 * written. Needs no context and logs nothing.
 */
ibl_status ibl_specular_layout_of(const ibl_specular_options *opts,
                                  ibl_specular_layout *layout);

/*
 * Relative error of a colour: |rgb - truth| / max(|truth|, floor). |.| is the
 * root of the sum of squares over R, G and B. The floor is a thousandth of |.|
 * of the environment's mean radiance; a difference below it is lost among
 * the rest of the scene.
 */
#define IBL_RELATIVE_FLOOR 1e-3
double ibl_relative_error(const double rgb[3], const double truth[3],
                          const double mean[3]);

/*
 * How a level of a specular chain was made: with samples, or with a degree. A
 * level without these is the environment itself.
 *
 * The error of a spectral level is twice the root mean square of what it leaves
 * out and of the interpolation of its texels, as estimated, relative to the
 * texel as in ibl_relative_error, at the 95th percentile over the texels;
 * without the integrals over single pixels and the rounding to a pixel format.
 * A level has as many degrees as keep it below the tolerance, up to a limit;
 * beyond it a warning says so if the tolerance is larger than the default.
 */
typedef struct ibl_specular_level {
    int samples;  /* of each texel; 0: not sampled */
    int degree;   /* of the spherical harmonics; 0: none */
    double error; /* of the degrees left out; -1: no degree */
} ibl_specular_level;

typedef struct ibl_specular_report {
    ibl_specular_layout layout;
    ibl_specular_level level[IBL_MAX_LEVELS];
    int lookup_size; /* edge of the cube for lookups; 0: there was none */
} ibl_specular_report;

/* How levels were made: "spectral", "sampled" or, without levels but the
 * environment itself, "environment". */
const char *ibl_specular_report_method(const ibl_specular_report *report);

/*
 * The specular chain: level l is the environment convolved with the lobe of
 * ibl_specular_layout_of's roughness[l], N = V = R,
 *   int L w dO / int w dO
 * over the sphere. Each pixel of the source is a patch of constant radiance L
 * with the solid angle in CONVENTIONS. At roughness 0 the level is the
 * environment itself (ibl_cube_from_latlong).
 *
 * A spectral level is that integral to the tolerance, for every lobe and any
 * size of the map, from roughness 0.05 up (how: iblbake-method(7)). A level has
 * at most 4,095 degrees; what a narrower lobe loses is in its estimated error.
 *
 * Levels are sampled only on request, by IBL_METHOD_SAMPLED. A sampled level
 * estimates the same integral by importance sampling of the lobe without N.L,
 * sum L_i w_i / sum w_i with w = N.L, of Hammersley points above the horizon.
 * L_i is a trilinear lookup in mips, at the level where a texel has the solid
 * angle of the sample, 1 / (samples pdf), plus lod_bias.
 *   out     empty; allocated here, to be freed with ibl_cube_free
 *   report  how each level was made; may be NULL
 * Sources: Karis 2013 (split sum); Ramamoorthi and Hanrahan 2001 (convolution
 * as a product); Walter et al. 2007 eq. 33 (GGX), 35, 36 (sampling); Krivanek
 * and Colbert 2008 (mip from pdf).
 * IBL_ERR_ARGUMENT: an option out of range.
 */
ibl_status ibl_bake_specular(ibl_ctx *ctx, const ibl_image *env,
                             const ibl_specular_options *opts, ibl_cube *out,
                             ibl_specular_report *report);

typedef struct ibl_irradiance_options {
    ibl_projection projection; /* default IBL_PROJECTION_CUBE; needs step 0 */
    int size;       /* edge of the faces, 1..IBL_MAX_CUBE_SIZE, default 32 */
    double step;    /* 0 (default): exact. > 0, at most 0.5: the classic grid
                       over the hemisphere in theta and phi, with midpoints
                       this many radians apart and bilinear lookups in a cube
                       of the environment */
    double yaw_deg; /* as in ibl_cube_from_latlong */
} ibl_irradiance_options;

ibl_irradiance_options ibl_irradiance_options_default(void);

/*
 * The diffuse map: irradiance / pi,
 *   int L max(N.L, 0) dO / pi,
 * so a shader only multiplies by albedo. Pixels are patches as for
 * ibl_bake_specular. The map equals the level of GGX at roughness 1, to the
 * default tolerance.
 *   out   empty; allocated here with one level, to be freed by the caller
 * IBL_ERR_ARGUMENT: an option out of range.
 */
ibl_status ibl_bake_irradiance(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               ibl_cube *out);

#define IBL_MAX_SH_DEGREE 64

/*
 * Spherical harmonics of the radiance, a_lm = int L Y_lm dO, with pixels as
 * patches. The basis is real and orthonormal, in the world's axes, polar axis
 * +Z:
 *   Y_lm = sqrt(2) K_l|m| P_l|m|(z) cos(m phi)       m > 0
 *          K_l0 P_l0(z)                              m = 0
 *          sqrt(2) K_l|m| P_l|m|(z) sin(|m| phi)     m < 0
 * with x = sin(t) cos(phi), y = sin(t) sin(phi), z = cos(t), P without the
 * Condon-Shortley phase: Y_1-1, Y_10, Y_11 are +sqrt(3/4pi) times y, z, x.
 *   degree   the highest l, 0..IBL_MAX_SH_DEGREE; 2 gives 9 coefficients
 *   yaw_deg  as in ibl_cube_from_latlong
 *   coeffs   3 (degree + 1)^2 doubles, the caller's: R, G, B of
 *            coefficient l (l + 1) + m
 */
ibl_status ibl_bake_sh(ibl_ctx *ctx, const ibl_image *env, int degree,
                       double yaw_deg, double *coeffs);

/*
 * Factor that turns radiance coefficients of degree l into those of
 * irradiance / pi: 1, 2/3, 1/4, 0, -1/24, ... (A_l / pi of Ramamoorthi and
 * Hanrahan 2001).
 */
double ibl_sh_cosine(int l);

/*
 * The harmonics of ibl_bake_sh up to a degree, 0..IBL_MAX_SH_DEGREE, in a unit
 * direction: y has room for (degree + 1)^2, at l (l + 1) + m.
 */
void ibl_sh_at(int degree, const double direction[3], double *y);

/*
 * A light that was taken out of a map: a disc of uniform radiance, far away. A
 * diffuse surface gets albedo / pi * irradiance * N.L from it, a specular one
 * the mean of the BRDF over the disc.
 */
typedef struct ibl_light {
    double direction[3];  /* unit, towards the middle of its light */
    double radius;        /* of the disc, in radians as seen */
    double irradiance[3]; /* on a surface that faces it: the sum over the pixels
                             of (radiance taken) dO; the cosine, 0.999 or more
                             for a radius of 2.5 degrees, is taken as 1 */
    double radiance[3];   /* mean: irradiance / (2 pi (1 - cos(radius))) */
} ibl_light;

#define IBL_MAX_LIGHTS 64

/*
 * Takes the strongest compact sources, such as the sun or lamps, out of a map.
 * Each becomes a light, or several if it has several parts, as lamps side by
 * side have. In their places the map becomes smooth, nowhere brighter or darker
 * than what is around; no other pixel changes. So map and lights together have
 * the light of the map as it was, and everything baked from the map has as much
 * less as the lights have: their irradiance / 4 pi in the mean of each output.
 *
 * A source is compact if this holds, in luminance (Rec. 709), at any share:
 *   bright  it has a pixel of more than 16 times the map's mean
 *   size    its disc has a radius of at most 2.5 degrees, or of one pixel's
 *           edge if that is larger, at most 6 degrees
 *   alone   a circle of at most twice that radius has it inside, and in the
 *           ring around the circle no pixel is brighter than 1/16 of its
 *           radiance. The ring's mean is below 16 times the map's or, in haze,
 *           below a tenth of its light over the circle
 *
 * A disc has the light and the integral of the squared radiance of what was
 * taken: its solid angle is (int L dO)^2 / int L^2 dO. What is 1.1 times as far
 * spread, in the mean square, is dealt to several, none with less than a
 * sixteenth of the light, or, if there is no room, to a disc as far spread, up
 * to 0.1.
 *
 *   map      changed in place
 *   yaw_deg  as in ibl_cube_from_latlong, for the directions; the map itself is
 *            not turned
 *   most     of lights, 1..IBL_MAX_LIGHTS: if there are more, those of the
 *            strongest sources, of which a pair that touches may stay one
 *   lights   room for `most`; written from the largest irradiance down
 *   count    their number. If it is less than most, a warning says why; if it
 *            is 0, the map is unchanged. So many of that map are the same
 * IBL_ERR_ARGUMENT: most, yaw_deg. After an error *count is 0; after
 * IBL_ERR_MEMORY the map is unspecified, else unchanged.
 */
ibl_status ibl_image_take_lights(ibl_ctx *ctx, ibl_image *map, double yaw_deg,
                                 int most, ibl_light *lights, int *count);

/*
 * An environment that is read once, row by row. read writes the next `rows`
 * rows from the zenith down: 3 * width * rows floats, finite and >= 0. The bake
 * calls it on its caller's thread. An error that it returns ends the bake.
 */
typedef struct ibl_environment {
    int width, height; /* 1..IBL_MAX_EDGE */
    ibl_status (*read)(void *cookie, int rows, float *rgb);
    void *cookie;
    const ibl_image *image; /* the environment in memory, or NULL. If it is
                               given, the members above are ignored: the size
                               is the image's */
} ibl_environment;

#define IBL_MAX_MORE_CHAINS 31

/* The outputs of one reading of an environment. */
typedef struct ibl_bake_options {
    int skybox; /* edge of a cube of the environment with all its mips,
                   1..IBL_MAX_CUBE_SIZE; default 0: none */
    ibl_projection skybox_projection; /* default IBL_PROJECTION_CUBE; a flat
                                         one has as many mips as halve */
    int specular;                     /* 0: none; default 1 */
    ibl_specular_options specular_options;
    int irradiance; /* 0: none; default 1 */
    ibl_irradiance_options irradiance_options;
    int sh_degree;  /* 0..IBL_MAX_SH_DEGREE; -1: none; default 2 */
    double yaw_deg; /* replaces those in the options above */
    const ibl_specular_options *more; /* further chains, with or without
                                         specular; default NULL */
    int more_count;                   /* 0..IBL_MAX_MORE_CHAINS, default 0 */
    const ibl_cube *level0; /* copied to level 0 of specular, not turned, if
                               that has roughness 0; then the environment must
                               be a map of this cube, and its size specular's.
                               Default NULL: made from the environment */
} ibl_bake_options;

ibl_bake_options ibl_bake_options_default(void);

typedef struct ibl_bake_result {
    ibl_cube skybox, specular, irradiance; /* empty if not requested */
    ibl_specular_report report;            /* of specular */
    ibl_cube *more;                        /* more_count chains, or NULL */
    ibl_specular_report *more_report;      /* of these */
    int more_count;
    int irradiance_degree; /* of the spherical harmonics; 0: not spectral */
    double *sh;            /* 3 (sh_degree + 1)^2 as in ibl_bake_sh, or NULL */
} ibl_bake_result;

void ibl_bake_result_free(ibl_bake_result *r); /* NULL and zeroed are fine */

/*
 * All outputs from one reading, row by row. The specular chain is that of
 * ibl_bake_specular. Irradiance and coefficients are those of
 * ibl_bake_irradiance and ibl_bake_sh, from the same spherical harmonics as the
 * levels. Irradiance has the tolerance of specular_options, with or without a
 * specular chain.
 *
 * All chains have one analysis, of as many degrees as the one that needs most.
 * So a chain is that of a bake of its own to the tolerance, and the same bytes
 * if no other output needs more degrees. A level that two chains have, equal in
 * edge, lobe, roughness and tolerance, is made once.
 *
 * The whole map stays in memory only if a level is sampled or
 * irradiance_options has a step. Else memory grows with the width of the map
 * and, by 24 bytes for each degree, with its height, not with its pixels.
 *   result  empty; to be freed with ibl_bake_result_free
 * IBL_ERR_ARGUMENT: an option out of range. The status of env->read.
 */
ibl_status ibl_bake_environment(ibl_ctx *ctx, const ibl_environment *env,
                                const ibl_bake_options *opts,
                                ibl_bake_result *result);

/*
 * Bytes that ibl_bake_environment takes of a map of width x height pixels,
 * results included, rounded up: what its arrays have, with room for maps that
 * need a finer grid than most. Excludes what env->read takes.
 * IBL_ERR_ARGUMENT: an option out of range.
 */
ibl_status ibl_bake_memory(ibl_ctx *ctx, int width, int height,
                           const ibl_bake_options *opts, size_t *bytes);

typedef enum ibl_geometry {
    IBL_GEOMETRY_SMITH,      /* Smith GGX, height-correlated (Heitz 2014) */
    IBL_GEOMETRY_SCHLICK_IBL /* Schlick, k = roughness^2 / 2 (Karis 2013) */
} ibl_geometry;

/* "smith" or "schlick-ibl". */
const char *ibl_geometry_name(ibl_geometry geometry);

/*
 * The mean over a disc light of f(V, L) N.L, which times the light's irradiance
 * is what a surface reflects of it: f is the GGX microfacet BRDF with Schlick's
 * Fresnel term F0, single scattering.
 *   alpha       roughness^2; below 1e-4 it counts as that
 *   radius_rad  of the disc: 0 to 0.1, as of an ibl_light
 *   normal, view, light   unit vectors; the light's is that of its middle
 * The lobe's share within the disc has a closed form, if the disc is projected
 * to slopes linearly; F, geometry and N.L are those of one direction in it.
 * nRMSE over all directions for alpha 0.0025 to 1, N.V 0.05 to 0.95: at most
 * 0.3 % for a radius of 0.25 degrees, 0.5 % for 1, 6 % for 3.
 * Source: Heitz and Hill 2017, "Linear-Light Shading with Linearly Transformed
 * Cosines".
 */
double ibl_disc_brdf(ibl_geometry geometry, double alpha, double f0,
                     double radius_rad, const double normal[3],
                     const double view[3], const double light[3]);

/* What a table holds; see ibl_bake_lut. */
typedef enum ibl_lut_kind {
    IBL_LUT_SPLIT,        /* 2 channels: scale and bias of F0 */
    IBL_LUT_MULTISCATTER, /* 3 channels: Filament's, with cloth */
    IBL_LUT_CHARLIE       /* 2 channels: the sheen of glTF */
} ibl_lut_kind;

#define IBL_LUT_NAMES "split", "multiscatter", "charlie" /* in that order */

const char *ibl_lut_name(ibl_lut_kind kind);
int ibl_lut_channels(ibl_lut_kind kind);

typedef struct ibl_lut_options {
    int size;              /* edge, 1..4096, default 256 */
    ibl_geometry geometry; /* default IBL_GEOMETRY_SMITH; SPLIT only */
    int samples;           /* 0 (default): deterministic quadrature; else
                              Hammersley points per texel, at most 1048576;
                              SPLIT only */
    ibl_lut_kind kind;     /* default IBL_LUT_SPLIT */
} ibl_lut_options;

ibl_lut_options ibl_lut_options_default(void);

/* size * size texels of ibl_lut_channels floats; see ibl_bake_lut. */
typedef struct ibl_lut {
    int size;
    float *data;
    ibl_lut_kind kind;
} ibl_lut;

void ibl_lut_free(ibl_lut *lut); /* NULL and zeroed are fine */

/*
 * The split-sum BRDF table. Texel (i, j) holds, for N.V = (i + .5) / size and
 * roughness = (j + .5) / size (memory row 0 is the smoothest),
 *   R = integral of (f / F) (1 - Fc) N.L dL   scale of F0
 *   G = integral of (f / F) Fc N.L dL         bias
 * f is the GGX microfacet BRDF, F its Fresnel term, and Fc = (1 - V.H)^5. The
 * quadrature is within 5e-5 of the integrals.
 *
 * Other kinds are over the same N.V and roughness, alpha = roughness^2:
 *   MULTISCATTER  R = integral of (f / F) Fc N.L dL
 *                 G = integral of (f / F) N.L dL
 *                 B = E of Ashikhmin's V
 *                 single scattering reflects (1 - F0) R + F0 G, and a shader
 *                 multiplies it by 1 + F0 (1 / G - 1)
 *   CHARLIE       R = E of Ashikhmin's V (lut_charlie of glTF-Sample-Viewer)
 *                 G = E of Charlie's V (lut_sheen_E)
 * E = integral of D V N.L dL is the albedo of sheen of colour 1, with
 *   D              (2 + 1/alpha) sin(theta_h)^(1/alpha) / 2pi
 *   Ashikhmin's V  1 / (4 (N.L + N.V - N.L N.V))
 *   Charlie's V    1 / (4 N.L N.V (1 + Lambda(N.V) + Lambda(N.L)))
 * and Lambda fitted by Estevez and Kulla 2017. E is above 1 at grazing views of
 * low roughness: neither V keeps energy there. Errors relative to the larger of
 * E and 1: 5e-5 up to size 2048, 1e-4 above.
 *   out   empty; allocated here, to be freed with ibl_lut_free
 * Source: Karis 2013, "Real Shading in Unreal Engine 4"; Filament's libs/ibl
 * (DFV_Multiscatter, DFV_Charlie_Uniform); KHR_materials_sheen; Neubelt and
 * Pettineo 2013.
 * IBL_ERR_ARGUMENT: an option out of range.
 */
ibl_status ibl_bake_lut(ibl_ctx *ctx, const ibl_lut_options *opts,
                        ibl_lut *out);

/* ---- reflections as rendered ----------------------------------------- */

#define IBL_LOBE_LAYERS 4

/* Surfaces that a lobe table is for. */
typedef enum ibl_f0 {
    IBL_F0_BOTH,
    IBL_F0_METALS,     /* F0 = 1 */
    IBL_F0_DIELECTRICS /* F0 = .04 */
} ibl_f0;

typedef struct ibl_lobe_table_options {
    int size;                   /* edge, 4..256, default 16 */
    ibl_specular_layout layout; /* of the chain, made with IBL_LOBE_GGX, its
                                   roughnesses rising; default: the chain of
                                   ibl_specular_options_default */
    ibl_f0 f0;                  /* default BOTH */
} ibl_lobe_table_options;

ibl_lobe_table_options ibl_lobe_table_options_default(void);

/* Layers of size * size texels of 4 floats; see ibl_bake_lobe_table. */
typedef struct ibl_lobe_table {
    int size;
    float *data;
    int layers; /* IBL_LOBE_LAYERS, or half as many: of one F0 */
} ibl_lobe_table;

void ibl_lobe_table_free(ibl_lobe_table *t); /* NULL and zeroed are fine */

/*
 * The lobe table: where in the chain a shader finds the reflection. The levels
 * are made with N = V = R; a surface seen at an angle has another lobe. The
 * table has the lookup whose lobe comes nearest to that of f N.L (GGX,
 * height-correlated Smith, Schlick's Fresnel).
 *
 * Texel (i, j) of a layer is for N.V = i / (size - 1) and the roughness
 * j / (size - 1) (memory row 0 is the smoothest): the outer texels are of 0 and
 * 1. All values are 0..1; only weights at roughness 1 may be up to 2.5:
 *   R  bend    of the direction, from R (0) to N (1)
 *   G  lod     over levels - 1 (0 in a chain of one level)
 *   B  weight  of irradiance / pi at N, the rest is that of the chain. Where
 *              it is above 1, the rest is taken away: that lobe is broader than
 *              the one of irradiance
 *   A  half the difference of the bends of the outer taps (0 for one)
 * Layers 0 and 1 are for one lookup in the chain, with F0 = 1 and F0 = .04;
 * layers 2 and 3 for four, with the same F0, the directions mix(R, N, b) for b
 * in equal steps from R - A to R + A, which may lie beyond R and N. Shaders mix
 * two layers by how metallic a surface is: ibl_lobe_taps of <ibl/ibl.glsl>,
 * also for two or three taps.
 *
 * A table for metals or dielectrics only has layer 0 for one lookup and layer 1
 * for four, which shaders take for all surfaces.
 *
 * The table depends on the roughnesses and sizes of the levels. It is smooth,
 * so that it can be interpolated; its values are those of halves. out   empty;
 * allocated here, to be freed with ibl_lobe_table_free IBL_ERR_ARGUMENT: an
 * option out of range. Source: the error of a lookup over all rotations of a
 * map of power C_l is sum C_l |S_lm - T_lm|^2, S and T the lobes of the lookup
 * and of the surface.
 */
ibl_status ibl_bake_lobe_table(ibl_ctx *ctx, const ibl_lobe_table_options *opts,
                               ibl_lobe_table *out);

IBL_API_END
#ifdef __cplusplus
}
#endif

#endif
