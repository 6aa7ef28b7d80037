/* SPDX-License-Identifier: MIT */
/*
 * iblbake: image-based lighting from an equirectangular environment map.
 *
 * This header is the bake: types, conventions, options and calls. Reading
 * images and writing textures is in <ibl/io.h>.
 *
 * CONVENTIONS (the whole library keeps them; nothing else defines them)
 *
 *   World        right-handed, +Y up.
 *   Equirect     row 0 is the zenith (+Y), columns run with
 *                u = atan2(z, x) / 2pi + 1/2, so the centre column looks
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
 *                which is the rule of OpenGL, Direct3D, Vulkan, KTX and DDS.
 *   Colour       linear RGB, the primaries of the source, scene-referred;
 *                no tone mapping anywhere.
 *   Roughness    perceptual, 0..1. A lobe's width is alpha = roughness^2.
 *   Threads      a context belongs to one caller at a time; its calls run on
 *                its own pool. Different contexts are independent. Every
 *                output is the same bytes for any number of threads.
 *   Errors       functions that can fail return ibl_status, 0 for success,
 *                and explain themselves through the context's log callback
 *                (one line, naming file, value and limit). Unless a function
 *                says otherwise its output is untouched by an ARGUMENT error
 *                and holds nothing to free after any error. A pointer is
 *                NULL only where it may be, by what is said of it: functions
 *                that return ibl_status answer others with IBL_ERR_ARGUMENT,
 *                in silence where it is the context, or what has one, that
 *                is not there; those that return none must not be given any.
 */
#ifndef IBL_IBL_H
#define IBL_IBL_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define IBL_VERSION "0.1.0"

typedef enum ibl_status {
    IBL_OK = 0,
    IBL_ERR_ARGUMENT,    /* a value outside its documented range */
    IBL_ERR_MEMORY,      /* out of memory, or larger than the library takes */
    IBL_ERR_IO,          /* the system refused to open, read or write */
    IBL_ERR_FORMAT,      /* not the format it claims, corrupt or cut short */
    IBL_ERR_UNSUPPORTED, /* valid, but not possible with what is installed */
    IBL_ERR_CANCELLED    /* ibl_ctx_cancel was called */
} ibl_status;

/* A short English phrase for a status; never NULL, not to be freed. */
const char *ibl_status_text(ibl_status status);

/* ---- context -------------------------------------------------------- */

/* Instruction sets of the hot loops. Results of different sets agree to
 * rounding, not to the byte. */
typedef enum ibl_isa {
    IBL_ISA_AUTO = 0, /* the best that this CPU has */
    IBL_ISA_C,        /* the plain version, the reference for the others */
    IBL_ISA_SSE2,
    IBL_ISA_AVX2,  /* AVX2 + FMA + F16C */
    IBL_ISA_AVX512 /* AVX-512 F, BW, DQ, VL */
} ibl_isa;

/* "auto", "c", "sse2", "avx2" or "avx512"; else "unknown". */
const char *ibl_isa_name(ibl_isa isa);
/* The best set that this CPU and build have; never IBL_ISA_AUTO. */
ibl_isa ibl_isa_best(void);

typedef enum ibl_log_level {
    IBL_LOG_ERROR,   /* why a call failed */
    IBL_LOG_WARNING, /* the call went on, but the user should know */
    IBL_LOG_INFO     /* what was done */
} ibl_log_level;

/* Receives one line without a newline, on the thread that made the call. */
typedef void ibl_log_fn(void *cookie, ibl_log_level level, const char *text);

/* Receives the running stage ("decode", "level 0", "specular 3", ...) and how
 * much of it is done, 0..1, on the thread that made the call. A stage reports
 * at least its start (0) and its end (1). stage stays valid only during the
 * call. */
typedef void ibl_progress_fn(void *cookie, const char *stage, double done);

typedef struct ibl_ctx_options {
    int threads;               /* 1..1024; 0: ibl_cpu_count() */
    ibl_isa isa;               /* default IBL_ISA_AUTO */
    ibl_log_fn *log;           /* NULL: silence */
    void *log_cookie;          /* passed to log */
    ibl_progress_fn *progress; /* NULL: none */
    void *progress_cookie;     /* passed to progress */
    const char *bridge;        /* path of the image bridge, NULL: the one that
                                  was compiled in; see ibl/io.h. Copied. */
} ibl_ctx_options;

typedef struct ibl_ctx ibl_ctx;

/* CPUs this process may use: online, in its affinity mask, and within its
 * cgroup's quota (rounded up). At least 1. */
int ibl_cpu_count(void);

ibl_ctx_options ibl_ctx_options_default(void);

/*
 * Makes a context with its pool of threads, which block all signals but those
 * of faults: handlers run on other threads. opts may be NULL for defaults.
 * IBL_ERR_ARGUMENT: threads or isa out of range. IBL_ERR_UNSUPPORTED: the CPU
 * lacks the instruction set. IBL_ERR_MEMORY: no memory or no threads. *ctx is
 * NULL after an error.
 */
ibl_status ibl_ctx_create(const ibl_ctx_options *opts, ibl_ctx **ctx);
void ibl_ctx_free(ibl_ctx *ctx); /* NULL is fine */

int ibl_ctx_threads(const ibl_ctx *ctx);
ibl_isa ibl_ctx_isa(const ibl_ctx *ctx); /* the set in use, never AUTO */

/*
 * Makes the running call, and every later one, return IBL_ERR_CANCELLED as
 * soon as its jobs in flight end (some milliseconds). Callable from any
 * thread and from a signal handler.
 */
void ibl_ctx_cancel(ibl_ctx *ctx);

/* ---- images --------------------------------------------------------- */

/* Largest width or height that the library takes, in pixels. */
#define IBL_MAX_EDGE 65536

/*
 * An equirectangular map: height rows of width texels of 3 floats R, G, B,
 * tightly packed, row 0 at the zenith. The bake calls take finite values
 * >= 0 only (ibl_image_read in ibl/io.h sees to that) and any aspect ratio.
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
 * A cube map with its mip chain, RGB floats. Level l has faces of
 * max(size >> l, 1) texels squared. Levels follow each other from the
 * largest, in a level the six faces, in a face the rows from the top, no
 * padding anywhere.
 */
typedef struct ibl_cube {
    int size;    /* edge of level 0 in texels, 1..IBL_MAX_CUBE_SIZE */
    int levels;  /* 1..floor(log2(size)) + 1 */
    float *data; /* 3 * ibl_cube_texels(size, levels) floats */
} ibl_cube;

/* Allocates a cube, contents undefined. Free with ibl_cube_free.
 * IBL_ERR_ARGUMENT: size or levels out of range. */
ibl_status ibl_cube_alloc(ibl_ctx *ctx, int size, int levels, ibl_cube *cube);
void ibl_cube_free(ibl_cube *cube); /* NULL and zeroed are fine */

/* Texels of the first `levels` levels of a cube of `size`, all faces. */
size_t ibl_cube_texels(int size, int levels);
/* Edge of a level in texels: max(size >> level, 1). */
int ibl_cube_edge(int size, int level);
/* The first texel of a level's face: 3 floats, row-major from there. */
float *ibl_cube_face(const ibl_cube *cube, int level, int face);
/* Unit direction of the centre of texel (x, y) of a face of `size`. */
void ibl_cube_direction(int size, int face, int x, int y, double dir[3]);
/* Solid angle of texel (x, y) of a face of `size`, in steradians; the 6 n^2
 * of them sum to 4 pi. */
double ibl_cube_solid_angle(int size, int x, int y);

/* ---- bakes ---------------------------------------------------------- */

/* Where a bake takes options, NULL stands for the defaults. */

/* How a level's roughness follows from its index; t = level / (levels - 1)
 * (0 for a single level). */
typedef enum ibl_roughness_map {
    IBL_ROUGHNESS_LINEAR,  /* r = t: a shader uses lod = r (levels - 1) */
    IBL_ROUGHNESS_FILAMENT /* t = r (2 - r), r = 1 - sqrt(1 - t): a shader
                              uses lod = r (2 - r) (levels - 1) */
} ibl_roughness_map;

/* "linear" or "filament". */
const char *ibl_roughness_map_name(ibl_roughness_map map);
/* Perceptual roughness of a level of a chain over the whole range, 0..1. */
double ibl_level_roughness(ibl_roughness_map map, int level, int levels);
/* The default number of levels: down to a last level of 8x8 or, for cubes
 * smaller than 8, down to 1x1. */
int ibl_default_levels(int size);

/*
 * Level 0: the environment as a cube. Each texel is the average over its solid
 * angle of the source's pixels as constant patches. Linear, and never outside
 * the range of the source.
 *
 * Where pixels are larger than texels, width < 4 size or height < 2 size, the
 * source is first interpolated: each pixel becomes sx by sy finer ones, and
 * those are the patches. sx and sy are the least whole numbers by which a row
 * has 4 size finer pixels, 512 and an even number at least, and a column
 * 2 size. A finer pixel has the value at its centre:
 *   - along a row linear from centre to centre of the source's pixels, once
 *     around;
 *   - between the centres of two rows with the weight t + b t (1 - t) for the
 *     lower one and the rest for the upper, t going from 0 to 1 evenly. b is
 *     such that, by solid angle, the finer rows between these centres that are
 *     above the border of the two have all of the upper row's weight in sum,
 *     those below it all of the lower's: every pixel keeps its energy;
 *   - beyond a pole lies the row next to it, half a turn away, and b is 0.
 *   env       the map
 *   yaw_deg   turns the environment about +Y, counter-clockwise seen from
 *             above; any finite value
 *   cube      allocated, any size; level 0 is written, the others untouched
 */
ibl_status ibl_cube_from_latlong(ibl_ctx *ctx, const ibl_image *env,
                                 double yaw_deg, ibl_cube *cube);

/*
 * The other way: fills map (allocated, width a multiple of 8, height even) from
 * level 0 of cube. Each pixel is the mean over its solid angle of the texels as
 * constant patches, so that the map is the same light: a constant stays that,
 * nothing leaves the range of the cube, and a texel's energy arrives. The
 * integral is exact along meridians, of which there are four between the edges
 * of pixels and of the columns of texels of the four upright faces: 1e-5 of
 * what such a texel holds, and 0.5 % (root mean square; 3 % at most) of a
 * single texel of +Y or -Y, goes to its neighbours instead or comes from them.
 * IBL_ERR_ARGUMENT: width or height. IBL_ERR_MEMORY: map unspecified.
 */
ibl_status ibl_latlong_from_cube(ibl_ctx *ctx, const ibl_cube *cube,
                                 ibl_image *map);
/* Width of the map that has all that a cube of a size has: 8 size, at least
 * 256, at most IBL_MAX_EDGE. It is half as high. */
int ibl_latlong_width(int size);

/*
 * Fills levels 1.. of cube from level 0: each texel the average of the 2x2
 * texels above it (3 of an odd row's or column's), weighted by their solid
 * angles.
 */
ibl_status ibl_cube_build_mips(ibl_ctx *ctx, ibl_cube *cube);

/*
 * What a level of a specular chain is convolved with: a weight w of the angle
 * psi from R to L alone, N = V = R, so N.L = cos(psi) and N.H = cos(psi / 2);
 * alpha = roughness^2, and w is 0 below the horizon, psi > 90 degrees. Level 0
 * of a chain from roughness 0 is the environment for every lobe.
 *
 *   GGX      D_ggx(N.H; alpha) N.L (Walter et al. 2007, eq. 33; Karis 2013).
 *   CHARLIE  D(N.H) N.L, D = (2 + 1/alpha) sin(theta_h)^(1/alpha) / 2pi: sheen
 *            as of glTF's KHR_materials_sheen (Estevez and Kulla 2017). It is
 *            0 at the mirror direction and has no mirror for a limit: as
 *            alpha falls it becomes a ring on the horizon, which level 0 is
 *            not. A shader should not go below the roughness of level 1.
 *   PHONG    (N.L)^(n + 1), n = (1/alpha^2 - 1) / 2: a cosine power about R
 *            and a cosine. n is a quarter of 2/alpha^2 - 2, the exponent of
 *            Blinn and Phong that is as wide as GGX's alpha, since the angle to
 *            R is twice that to H (the 1/4 of Lagarde's CubemapGen and of
 *            cmft's "blinnbrdf").
 *
 * At roughness 1 GGX and PHONG are the cosine, so that level is irradiance/pi.
 */
typedef enum ibl_lobe {
    IBL_LOBE_GGX,
    IBL_LOBE_CHARLIE,
    IBL_LOBE_PHONG
} ibl_lobe;

/* "ggx", "charlie" or "phong". */
const char *ibl_lobe_name(ibl_lobe lobe);

/* How the levels of a specular chain are made. */
typedef enum ibl_method {
    IBL_METHOD_AUTO,     /* spectral, but a level with a number of samples of
                            its own is sampled */
    IBL_METHOD_SPECTRAL, /* exact: see ibl_bake_specular */
    IBL_METHOD_SAMPLED
} ibl_method;

/* "auto", "spectral" or "sampled". */
const char *ibl_method_name(ibl_method method);

/* A fifth of what rounding to a half float leaves. */
#define IBL_TOLERANCE_DEFAULT 5e-5

typedef struct ibl_specular_options {
    ibl_method method;         /* default IBL_METHOD_AUTO */
    ibl_lobe lobe;             /* default IBL_LOBE_GGX */
    int size;                  /* edge of level 0, 1..IBL_MAX_CUBE_SIZE,
                                  default 256 */
    int levels;                /* 1..floor(log2(size)) + 1; default 0: see
                                  ibl_specular_layout */
    ibl_roughness_map mapping; /* default IBL_ROUGHNESS_LINEAR */
    double roughness_min;      /* the range that is used, in 0..1, default */
    double roughness_max;      /*   all of it: see ibl_specular_layout */
    double tolerance; /* 1e-6..1, default IBL_TOLERANCE_DEFAULT: the relative
                         error (95th percentile) that is accepted of every
                         spectral level, and of irradiance */
    double yaw_deg;   /* as in ibl_cube_from_latlong */
    /* Of sampled levels alone: */
    int samples;                       /* per texel, 1..1048576, default 1024 */
    int level_samples[IBL_MAX_LEVELS]; /* > 0 overrides samples there */
    double lod_bias; /* added to the lookups' mip level, -4..4, default 1:
                        less shows single samples, more blurs the horizon */
    int jitter;      /* 1: turn the sample pattern by a hash of the texel;
                        default 0 */
    int pdf_mip;     /* 0: every lookup at mip 0 (the tutorial's first
                        version); default 1 */
} ibl_specular_options;

ibl_specular_options ibl_specular_options_default(void);

/*
 * The levels of a specular chain, and where a shader finds a roughness r:
 *     lod = x lod_scale + lod_offset,   x = r       (linear mapping)
 *                                       x = r (2 - r)     (Filament's)
 * clamped to 0..levels - 1.
 */
typedef struct ibl_specular_layout {
    int size, levels; /* of the cube that ibl_bake_specular makes */
    double roughness[IBL_MAX_LEVELS]; /* of each level */
    double lod_scale, lod_offset;
} ibl_specular_layout;

/*
 * The layout that options ask for; the one place where a level's roughness
 * comes from. The levels go in equal steps of x from roughness_min to
 * roughness_max. With the whole range, 0..1, that is
 * r = ibl_level_roughness(mapping, level, levels), size as asked for and, by
 * default, ibl_default_levels(size).
 *
 * Of a part of the range only what it needs is made:
 *   size    as asked for if roughness_min is 0: level 0 is the environment.
 *           Else what a lobe of roughness_min needs, 5 pi / (2 alpha) texels
 *           along an edge, or what the whole chain of that size has for it,
 *           whichever is less, rounded up so that every level halves it.
 *   levels  by default as many as bring the last one nearest to what a lobe
 *           of roughness_max needs, or to what the whole chain has for it; two
 *           at least, unless roughness_min = roughness_max: that is one level,
 *           and asking for more an error.
 * IBL_ERR_ARGUMENT: size, levels, mapping or range out of range; nothing is
 * written. Needs no context and explains nothing.
 */
ibl_status ibl_specular_layout_of(const ibl_specular_options *opts,
                                  ibl_specular_layout *layout);

/*
 * The specular chain: level l is the environment convolved with the lobe of
 * ibl_specular_layout_of's roughness[l], N = V = R,
 *   int L w dO / int w dO
 * over the sphere, where each pixel of the source is a patch of constant
 * radiance L, as large as CONVENTIONS say. Where that roughness is 0 it is the
 * environment itself (ibl_cube_from_latlong).
 *
 * A spectral level is that integral to the tolerance, for every lobe and any
 * size of the map, from roughness 0.02 up: a product for each degree of the
 * spherical harmonics of the map, of as many degrees as the tolerance needs.
 * The few pixels that outshine all around them are integrated by the lobe's
 * own formula. Where a narrow lobe would need too high a degree the harmonics
 * have its far part, and the pixels in reach of the near part are integrated
 * one by one (Ewald's split). No level is sampled that is not asked to be, by
 * IBL_METHOD_SAMPLED or with IBL_METHOD_AUTO by level_samples;
 * IBL_METHOD_SPECTRAL does not look at samples.
 *
 * A sampled level is importance sampling of the same,
 *   sum L_i w_i / sum w_i,  w = N.L,
 * L_i by trilinear lookups, seamless across faces, in a solid-angle-weighted
 * mip chain, at the level where a texel's solid angle is that of the sample,
 * 1 / (samples pdf), and lod_bias levels further. The pdf is without N.L: for
 * GGX D(N.H) N.H / (4 V.H), for Charlie and Phong as (1 - N.L)^(1 / (2 alpha))
 * and (N.L)^n. Charlie's ring is a larger place than a peak and takes several
 * times the samples for the same error.
 * Hammersley points, all of them in the part of the lobe above the horizon,
 * moved by what takes the blur of the lookups back. The chain that is looked
 * up is not the output's, nor that of ibl_cube_build_mips: its means are
 * taken under the tent of bilinear filtering, not over 2x2 texels, which
 * would move small lights to the middles of texels.
 *   out   empty; allocated here, the caller's to free with ibl_cube_free
 * Sources: Karis 2013 (split sum); Ramamoorthi and Hanrahan 2001 (convolution
 * as a product); Walter et al. 2007 eq. 33 (GGX), 35, 36 (sampling); Krivanek
 * and Colbert 2008 (mip from pdf).
 * IBL_ERR_ARGUMENT: an option out of range.
 */
ibl_status ibl_bake_specular(ibl_ctx *ctx, const ibl_image *env,
                             const ibl_specular_options *opts, ibl_cube *out);

/*
 * Relative error of a colour: |rgb - truth| / max(|truth|, floor), |.| the
 * root of the sum of squares over R, G and B. The floor is a thousandth of the
 * |.| of the environment's mean radiance: below it a difference is lost beside
 * everything else in the scene.
 */
#define IBL_RELATIVE_FLOOR 1e-3
double ibl_relative_error(const double rgb[3], const double truth[3],
                          const double mean[3]);

/* How a level of a specular chain was made: with samples; or with a degree, a
 * reach or both; or with none of them: the environment itself. */
typedef struct ibl_specular_level {
    int samples;  /* of each texel; 0: not sampled */
    int degree;   /* of the spherical harmonics; 0: none */
    double reach; /* angle around R, in radians, within which pixels were summed
                     up one by one; 0: none were */
    double error; /* the estimate of what the degrees leave, see
                     ibl_bake_specular_report; -1: no degree */
} ibl_specular_level;

typedef struct ibl_specular_report {
    ibl_specular_layout layout;
    ibl_specular_level level[IBL_MAX_LEVELS];
    int lookup_size; /* edge of the cube that was looked up; 0: none was */
} ibl_specular_report;

/*
 * ibl_bake_specular that tells how. report may be NULL.
 *
 * The error of a spectral level is estimated from the power in the degrees that
 * it leaves out and from how its texels are interpolated: the 95th percentile
 * over its texels of three times that root mean square, in parts of the texel
 * as in ibl_relative_error. A level has as many degrees as keep the estimate
 * below the tolerance; a warning tells where none suffice. The integrals over
 * single pixels and the rounding to a pixel format are no part of it, and
 * sampled levels have no estimate.
 */
ibl_status ibl_bake_specular_report(ibl_ctx *ctx, const ibl_image *env,
                                    const ibl_specular_options *opts,
                                    ibl_cube *out, ibl_specular_report *report);

typedef struct ibl_irradiance_options {
    int size;       /* edge of the faces, 1..IBL_MAX_CUBE_SIZE, default 32 */
    double step;    /* 0 (default): exact; > 0, at most 0.5: the classic grid
                       over the hemisphere in theta and phi, midpoints, this
                       many radians apart, looked up bilinearly in a cube of
                       the environment */
    double yaw_deg; /* as in ibl_cube_from_latlong */
} ibl_irradiance_options;

ibl_irradiance_options ibl_irradiance_options_default(void);

/*
 * The diffuse map: irradiance / pi,
 *   int L max(N.L, 0) dO / pi,
 * so a shader multiplies by albedo alone. Pixels are patches as for
 * ibl_bake_specular; it is the level of GGX at roughness 1, to the default
 * tolerance.
 *   out   empty; allocated here with one level, the caller's to free
 * IBL_ERR_ARGUMENT: an option out of range.
 */
ibl_status ibl_bake_irradiance(ibl_ctx *ctx, const ibl_image *env,
                               const ibl_irradiance_options *opts,
                               ibl_cube *out);

#define IBL_MAX_SH_DEGREE 1000

/*
 * Spherical harmonics of the radiance, a_lm = int L Y_lm dO, pixels as patches,
 * with the real orthonormal basis in the world's axes, polar axis +Z:
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
 * An environment that is read once, row by row. read writes the next `rows`
 * rows from the zenith down, 3 * width * rows floats, finite and >= 0; it is
 * called on the thread of the bake, and a status of its own ends the bake.
 */
typedef struct ibl_environment {
    int width, height; /* 1..IBL_MAX_EDGE */
    ibl_status (*read)(void *cookie, int rows, float *rgb);
    void *cookie;
    const ibl_image *image; /* the environment in memory, or NULL. Where it is
                               given nothing above is looked at: the size is
                               the image's */
} ibl_environment;

/* The cubes and coefficients that one reading of an environment gives. */
typedef struct ibl_bake_options {
    int skybox;   /* edge of a cube of the environment with all its mips,
                     1..IBL_MAX_CUBE_SIZE; default 0: none */
    int specular; /* 0: none; default 1 */
    ibl_specular_options specular_options;
    int irradiance; /* 0: none; default 1 */
    ibl_irradiance_options irradiance_options;
    int sh_degree;          /* 0..IBL_MAX_SH_DEGREE; -1: none; default 2 */
    double yaw_deg;         /* in place of those in the options above */
    const ibl_cube *level0; /* level 0 of specular where that has roughness 0,
                               not turned: the environment is a map of this
                               cube. Its size is specular's. Default NULL: made
                               of the environment */
} ibl_bake_options;

ibl_bake_options ibl_bake_options_default(void);

typedef struct ibl_bake_result {
    ibl_cube skybox, specular, irradiance; /* empty where not wanted */
    ibl_specular_report report;            /* of specular */
    int irradiance_degree; /* of the spherical harmonics; 0: not spectral */
    double *sh;            /* 3 (sh_degree + 1)^2 as of ibl_bake_sh, or NULL */
} ibl_bake_result;

void ibl_bake_result_free(ibl_bake_result *r); /* NULL and zeroed are fine */

/*
 * Everything from one reading, row by row. The specular chain is that of
 * ibl_bake_specular_report. Irradiance and coefficients are those of
 * ibl_bake_irradiance and ibl_bake_sh, from the same spherical harmonics as the
 * levels, irradiance to the tolerance of specular_options, whether or not a
 * specular chain is wanted.
 *
 * The map is kept whole where a level is sampled and for a step of
 * irradiance_options. Else what is needed of memory grows with the width of the
 * map and, by 24 bytes for each degree, with its height, not with its pixels.
 *   result  empty; the caller's to free with ibl_bake_result_free
 * IBL_ERR_ARGUMENT: an option out of range. The status of env->read.
 */
ibl_status ibl_bake_environment(ibl_ctx *ctx, const ibl_environment *env,
                                const ibl_bake_options *opts,
                                ibl_bake_result *result);

typedef enum ibl_geometry {
    IBL_GEOMETRY_SMITH,      /* Smith GGX, height-correlated (Heitz 2014) */
    IBL_GEOMETRY_SCHLICK_IBL /* Schlick, k = roughness^2 / 2 (Karis 2013) */
} ibl_geometry;

/* "smith" or "schlick-ibl". */
const char *ibl_geometry_name(ibl_geometry geometry);

typedef struct ibl_lut_options {
    int size;              /* edge, 1..4096, default 256 */
    ibl_geometry geometry; /* default IBL_GEOMETRY_SMITH */
    int samples;           /* 0 (default): deterministic quadrature; else
                              Hammersley points per texel, at most 1048576 */
} ibl_lut_options;

ibl_lut_options ibl_lut_options_default(void);

/* size * size texels of 2 floats; see ibl_bake_lut. */
typedef struct ibl_lut {
    int size;
    float *data;
} ibl_lut;

void ibl_lut_free(ibl_lut *lut); /* NULL and zeroed are fine */

/*
 * The split-sum BRDF table. Texel (i, j) holds, for N.V = (i + .5) / size and
 * roughness = (j + .5) / size (memory row 0 is the smoothest),
 *   R = integral of (f / F) (1 - Fc) N.L dL   scale of F0
 *   G = integral of (f / F) Fc N.L dL         bias
 * with f the GGX microfacet BRDF, F its Fresnel term and
 * Fc = (1 - V.H)^5. The quadrature is within 5e-5 of the integrals.
 *   out   empty; allocated here, the caller's to free with ibl_lut_free
 * Source: Karis 2013, "Real Shading in Unreal Engine 4".
 * IBL_ERR_ARGUMENT: an option out of range.
 */
ibl_status ibl_bake_lut(ibl_ctx *ctx, const ibl_lut_options *opts,
                        ibl_lut *out);

#ifdef __cplusplus
}
#endif

#endif
