/* SPDX-License-Identifier: MIT */
#include "view/picture.h"

#include "common/signals.h"
#include "engine/picture.h"
#include "view/gl.h"
#include "view/message.h"
#include <stdlib.h>
#include <string.h>
#include <strings.h>

void view_picture_flip(void *pixels, size_t row_bytes, int height)
{
    for (int i = 0; i < height / 2; i++) {
        unsigned char *a = (unsigned char *)pixels + (size_t)i * row_bytes;
        unsigned char *b = a + (size_t)(height - 1 - 2 * i) * row_bytes;
        for (size_t x = 0; x < row_bytes; x++) {
            const unsigned char kept = a[x];
            a[x] = b[x];
            b[x] = kept;
        }
    }
}

unsigned char *view_picture_read(GLuint framebuffer, int width, int height)
{
    const size_t row_bytes = 3 * (size_t)width;
    unsigned char *rgb = ibl_need(malloc(row_bytes * (size_t)height));

    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    gl.ReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, rgb);
    view_picture_flip(rgb, row_bytes, height);
    return rgb;
}

bool view_picture_is_linear(const char *path)
{
    const size_t length = strlen(path);

    return length > 4 && !strcasecmp(path + length - 4, ".exr");
}

bool view_picture_write(ibl_ctx *ctx, const char *path, int width, int height,
                        const void *rgb)
{
    static const ibl_picture_options exr = {.kind = IBL_PICTURE_EXR};
    ibl_outputs *outputs = NULL;
    ibl_blob file = {0};
    bool ok;

    if (view_picture_is_linear(path))
        ok = !ibl_picture_encode(ctx, path, &exr, width, height, rgb, &file);
    else
        ok = ibl_png_encode(rgb, 3, width, height, NULL, &file) ||
             view_fail("%s: no memory for a PNG of %d x %d pixels", path, width,
                       height);
    ok = ok && !ibl_outputs_create(ctx, 0, &outputs) &&
         !ibl_outputs_add(outputs, path, file.bytes, file.size) &&
         !ibl_outputs_commit(outputs);
    ibl_outputs_free(outputs);
    ibl_blob_free(&file);
    return ok;
}
