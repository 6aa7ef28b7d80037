/* SPDX-License-Identifier: MIT */
/* Images of scenes: PNG by libpng, JPEG by libjpeg, WebP by libwebp, which is
 * loaded on demand. */
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

#include <jerror.h>
#include <jpeglib.h>

#include "common/signals.h"
#include "core/alloc.h"
#include "core/context.h"
#include "engine/png.h"
#include "scene/gltf_reader.h"

enum {
    /* Texels, 1 GiB of them. */
    MOST_TEXELS = 1 << 28,
    /* Pixels that a byte of a JPEG can stand for: a block of 64 takes a bit */
    MOST_PACKED = 512,
    /* Texels of a WebP, which may be packed without limit: 4096 x 4096, or so
     * many of a byte */
    MOST_WEBP = 1 << 24,
    MOST_WEBP_PACKED = 4096
};

static const char damaged[] = "a damaged image, or one that is cut short";

/* Returns what is wrong, as all below: NULL: nothing. */
static const char *make_room(ibl_scene_image *i, int width, int height)
{
    if ((uint64_t)width * (uint64_t)height > MOST_TEXELS)
        return "an image of over 268435456 texels: make it smaller";
    i->rgba = ibl_alloc_array((size_t)width * (size_t)height, 4);
    i->width = width;
    i->height = height;
    return i->rgba ? NULL : "no memory for the image";
}

static const char *decode_png(ibl_scene_image *i)
{
    int width, height;

    if (!ibl_png_size(i->encoded, i->encoded_size, &width, &height))
        return damaged;
    const char *why = make_room(i, width, height);
    return why || ibl_png_decode(i->encoded, i->encoded_size, width, height,
                                 i->rgba)
               ? why
               : damaged;
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

static const char *read_rows(reader *r, ibl_scene_image *i, int reduce)
{
    struct jpeg_decompress_struct *j = &r->jpeg;

    jpeg_mem_src(j, i->encoded, i->encoded_size);
    jpeg_read_header(j, TRUE);
    if ((uint64_t)j->image_width * j->image_height / MOST_PACKED >
        i->encoded_size)
        return damaged;
    if (j->num_components == 4)
        return "a JPEG in CMYK: save it in RGB";
    j->out_color_space = JCS_EXT_RGBA;
    j->scale_denom = (unsigned)reduce;
    jpeg_calc_output_dimensions(j);
    const char *why = make_room(i, (int)j->output_width, (int)j->output_height);
    if (why)
        return why;
    jpeg_start_decompress(j);
    while (j->output_scanline < j->output_height) {
        unsigned char *row =
            i->rgba + 4 * (size_t)j->output_width * (size_t)j->output_scanline;
        jpeg_read_scanlines(j, &row, 1);
    }
    return NULL;
}

static const char *decode_jpeg(ibl_scene_image *i, int reduce)
{
    reader r;
    const char *volatile why = damaged;

    r.jpeg.err = jpeg_std_error(&r.errors);
    r.errors.error_exit = leave;
    r.errors.emit_message = listen;
    jpeg_create_decompress(&r.jpeg);
    if (!setjmp(r.failed))
        why = read_rows(&r, i, reduce);
    jpeg_destroy_decompress(&r.jpeg);
    return why;
}

/* ---- WebP ------------------------------------------------------------- */

static const char *decode_webp(ibl_scene_image *i)
{
    const ibl_decoders *d = ibl_gltf_decoders();
    int width, height;

    if (!d->webp)
        return "a WebP, and iblbake was built without libwebp-dev";
    if (!d->webp_size(i->encoded, i->encoded_size, &width, &height) ||
        (uint64_t)width * (uint64_t)height >
            MOST_WEBP + MOST_WEBP_PACKED * (uint64_t)i->encoded_size)
        return damaged;
    const char *why = make_room(i, width, height);
    if (!why && !d->webp(i->encoded, i->encoded_size, width, height, i->rgba))
        why = "a damaged WebP, or one that moves";
    return why;
}

/* ---- the calls -------------------------------------------------------- */

static bool begins(const ibl_scene_image *i, const char *bytes, size_t size)
{
    return i->encoded_size >= size && !memcmp(i->encoded, bytes, size);
}

static const char *decode(ibl_scene_image *i, int reduce)
{
    const char *why = "neither PNG nor JPEG nor WebP: convert it";

    if (i->rgba)
        return NULL;
    if (begins(i, "\x89PNG", 4))
        why = decode_png(i);
    else if (begins(i, "\xff\xd8\xff", 3))
        why = decode_jpeg(i, reduce);
    else if (begins(i, "RIFF", 4))
        why = decode_webp(i);
    else if (begins(i, "\xabKTX", 4))
        why = "a KTX texture, for which there is no decoder: use PNG or JPEG";
    else if (i->encoded_size > 12 && !memcmp(i->encoded + 4, "ftypavi", 7))
        why = "AVIF, for which there is no decoder: use PNG, JPEG or WebP";
    if (why) {
        ibl_free(i->rgba);
        i->rgba = NULL;
    }
    return why;
}

typedef struct wanted {
    ibl_scene *scene;
    int reduce;
    const int *images;
    const char **why; /* of each */
} wanted;

static void job(void *arg, int n, int worker)
{
    const wanted *w = arg;

    (void)worker;
    w->why[n] = decode(&w->scene->images[w->images[n]], w->reduce);
}

ibl_status ibl_scene_decode_all(ibl_ctx *ctx, ibl_scene *scene,
                                const int *images, int count, int reduce)
{
    const char **all =
        ibl_need(ibl_alloc_zeroed((size_t)count + 1, sizeof *all));
    wanted w = {scene, reduce, images, all};

    ibl_status status = ibl_run(ctx, NULL, count, job, &w);
    for (int i = 0; i < count && !status; i++) {
        const char *name = scene->images[images[i]].name;
        if (!all[i])
            continue;
        if (scene->strict)
            status = ibl_fail(ctx, IBL_ERR_FORMAT, "%s: %s", name, all[i]);
        else
            ibl_warn(ctx, "%s: %s; its factor stands for it", name, all[i]);
        ibl_scene_forget(scene, images[i]);
    }
    ibl_free(all);
    return status;
}
