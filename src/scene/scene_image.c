/* SPDX-License-Identifier: MIT */
/* Images of scenes: PNG by libpng, JPEG by libjpeg. */
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

#include <jerror.h>
#include <jpeglib.h>

#include "core/alloc.h"
#include "core/context.h"
#include "engine/png.h"
#include "scene/scene.h"

enum {
    /* Texels, 1 GiB of them. */
    MOST_TEXELS = 1 << 28,
    /* Pixels that a byte of a JPEG can stand for: a block of 64 takes a bit */
    MOST_PACKED = 512
};

static ibl_status make_room(ibl_scene_image *i, int width, int height)
{
    if ((uint64_t)width * (uint64_t)height > MOST_TEXELS)
        return IBL_ERR_UNSUPPORTED;
    i->rgba = ibl_alloc_array((size_t)width * (size_t)height, 4);
    i->width = width;
    i->height = height;
    return i->rgba ? IBL_OK : IBL_ERR_MEMORY;
}

/* ---- PNG -------------------------------------------------------------- */

static ibl_status decode_png(ibl_scene_image *i)
{
    int width, height;

    if (!ibl_png_size(i->encoded, i->encoded_size, &width, &height) ||
        !ibl_png_holds(i->encoded, i->encoded_size))
        return IBL_ERR_FORMAT;
    const ibl_status status = make_room(i, width, height);
    if (status)
        return status;
    return ibl_png_decode(i->encoded, i->encoded_size, width, height, i->rgba)
               ? IBL_OK
               : IBL_ERR_FORMAT;
}

/* ---- JPEG ------------------------------------------------------------- */

typedef struct reader {
    struct jpeg_error_mgr errors;
    jmp_buf failed;
    struct jpeg_decompress_struct jpeg;
} reader;

static void leave(j_common_ptr jpeg)
{
    longjmp(((reader *)(void *)jpeg->err)->failed, 1);
}

/* Warnings are for damage that leaves a picture, but for the file's end. */
static void listen(j_common_ptr jpeg, int level)
{
    if (level < 0 && jpeg->err->msg_code == JWRN_JPEG_EOF)
        leave(jpeg);
}

static ibl_status read_rows(reader *r, ibl_scene_image *i, int reduce)
{
    struct jpeg_decompress_struct *j = &r->jpeg;

    jpeg_mem_src(j, i->encoded, i->encoded_size);
    jpeg_read_header(j, TRUE);
    if ((uint64_t)j->image_width * j->image_height / MOST_PACKED >
        i->encoded_size)
        return IBL_ERR_FORMAT;
    j->out_color_space = JCS_EXT_RGBA;
    j->scale_denom = (unsigned)reduce;
    jpeg_calc_output_dimensions(j);
    const ibl_status status =
        make_room(i, (int)j->output_width, (int)j->output_height);
    if (status)
        return status;
    jpeg_start_decompress(j);
    while (j->output_scanline < j->output_height) {
        unsigned char *row =
            i->rgba + 4 * (size_t)j->output_width * (size_t)j->output_scanline;
        jpeg_read_scanlines(j, &row, 1);
    }
    return IBL_OK;
}

static ibl_status decode_jpeg(ibl_scene_image *i, int reduce)
{
    reader r;
    volatile ibl_status status = IBL_ERR_FORMAT;

    r.jpeg.err = jpeg_std_error(&r.errors);
    r.errors.error_exit = leave;
    r.errors.emit_message = listen;
    jpeg_create_decompress(&r.jpeg);
    if (!setjmp(r.failed))
        status = read_rows(&r, i, reduce);
    jpeg_destroy_decompress(&r.jpeg);
    return status;
}

/* ---- the calls -------------------------------------------------------- */

static bool begins(const ibl_scene_image *i, const char *bytes, size_t size)
{
    return i->encoded_size >= size && !memcmp(i->encoded, bytes, size);
}

/* Decodes without a message. */
static ibl_status decode(ibl_scene_image *i, int reduce)
{
    ibl_status status = IBL_ERR_ARGUMENT; /* another format */

    if (i->rgba)
        return IBL_OK;
    if (begins(i, "\x89PNG", 4))
        status = decode_png(i);
    else if (begins(i, "\xff\xd8\xff", 3))
        status = decode_jpeg(i, reduce);
    if (status) {
        ibl_free(i->rgba);
        i->rgba = NULL;
        i->width = i->height = 0;
    }
    return status;
}

static ibl_status report(ibl_ctx *ctx, const ibl_scene_image *i,
                         ibl_status status)
{
    switch (status) {
    case IBL_OK:
        return status;
    case IBL_ERR_ARGUMENT:
        return ibl_fail(ctx, IBL_ERR_UNSUPPORTED,
                        "%s: neither PNG nor JPEG: convert it", i->name);
    case IBL_ERR_UNSUPPORTED:
        return ibl_fail(ctx, status,
                        "%s: an image of over %d texels: make it smaller",
                        i->name, MOST_TEXELS);
    case IBL_ERR_MEMORY:
        return ibl_no_memory(ctx, "an image of a scene");
    default:
        return ibl_fail(ctx, status,
                        "%s: a damaged image, or one that is cut "
                        "short",
                        i->name);
    }
}

typedef struct wanted {
    ibl_scene *scene;
    int reduce;
    const int *images;
    ibl_status *status;
} wanted;

static void job(void *arg, int n, int worker)
{
    const wanted *w = arg;

    (void)worker;
    w->status[n] = decode(&w->scene->images[w->images[n]], w->reduce);
}

ibl_status ibl_scene_decode_all(ibl_ctx *ctx, ibl_scene *scene,
                                const int *images, int count, int reduce)
{
    ibl_status *all = ibl_alloc_zeroed((size_t)count + 1, sizeof *all);
    wanted w = {scene, reduce, images, all};

    if (!all)
        return ibl_no_memory(ctx, "images");
    ibl_status status = ibl_run(ctx, NULL, count, job, &w);
    for (int i = 0; i < count && !status; i++)
        status = report(ctx, &scene->images[images[i]], all[i]);
    ibl_free(all);
    return status;
}

ibl_status ibl_scene_decode(ibl_ctx *ctx, ibl_scene *scene, int image,
                            int reduce)
{
    return ibl_scene_decode_all(ctx, scene, &image, 1, reduce);
}
