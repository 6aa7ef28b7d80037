/* SPDX-License-Identifier: MIT */
#include "files.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "float_exr.h"
#include "test.h"

const char *file_path(const char *name)
{
    return test_text("%s/%s", test_dir(), name);
}

bool file_run(const char *fmt, ...)
{
    static char command[16384];
    va_list ap;
    const int n =
        snprintf(command, sizeof command, "cd '%s' && { ", test_dir());
    va_start(ap, fmt);
    const int m = vsnprintf(command + n, sizeof command - (size_t)n, fmt, ap);
    va_end(ap);
    if (n + m + 40 > (int)sizeof command)
        return false;
    strcat(command, "\n} >command.log 2>&1");
    return system(command) == 0;
}

bool file_have(const char *program)
{
    return file_run("command -v %s", program);
}

unsigned char *file_load(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    unsigned char *bytes = NULL;
    long end = -1;
    if (f && !fseek(f, 0, SEEK_END))
        end = ftell(f);
    if (end >= 0)
        bytes = malloc((size_t)end + 1);
    if (!bytes || fseek(f, 0, SEEK_SET) ||
        fread(bytes, 1, (size_t)end, f) != (size_t)end) {
        printf("%s: cannot be read\n", path);
        exit(1);
    }
    fclose(f);
    test_defer(free, bytes);
    *size = (size_t)end;
    return bytes;
}

bool file_save(const char *path, const void *bytes, size_t size)
{
    FILE *f = fopen(path, "wb");
    if (!f)
        return false;
    const bool ok = fwrite(bytes, 1, size, f) == size;
    return !fclose(f) && ok;
}

uint32_t file_u32(const unsigned char *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 |
           (uint32_t)p[3] << 24;
}

void file_set_u32(unsigned char *p, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(value >> 8 * i);
}

bool file_save_pfm(const char *path, const ibl_image *img)
{
    FILE *f = fopen(path, "wb");
    if (!f)
        return false;
    fprintf(f, "PF\n%d %d\n-1.0\n", img->width, img->height);
    bool ok = true;
    for (int y = img->height - 1; y >= 0; y--)
        ok &= fwrite(img->data + 3 * (size_t)y * (size_t)img->width,
                     3 * sizeof(float), (size_t)img->width,
                     f) == (size_t)img->width;
    return !fclose(f) && ok;
}

bool file_save_exr(const char *path, const ibl_image *img, const float *alpha)
{
    const size_t count = (size_t)img->width * (size_t)img->height;
    float *samples = malloc(4 * count * sizeof *samples), *to = samples;
    FILE *f = fopen(path, "wb");

    if (!f || !samples)
        return false;
    for (size_t i = 0; alpha && i < count; i++)
        *to++ = alpha[i];
    for (size_t c = 3; c-- > 0;)
        for (size_t i = 0; i < count; i++)
            *to++ = img->data[3 * i + c];
    const bool ok = test_write_float_exr(f, img->width, img->height,
                                         alpha ? "ABGR" : "BGR", samples);
    free(samples);
    return !fclose(f) && ok;
}

ibl_status file_read_rows(ibl_rows *rows, ibl_image *img)
{
    static test_random r = {12};
    const size_t floats = 3 * (size_t)rows->width;
    ibl_status status =
        ibl_image_alloc(rows->ctx, rows->width, rows->height, img);
    const int longest = test_random_u64(&r) % 2 ? 3 : 80;
    while (!status && rows->row < rows->height) {
        const int left = rows->height - rows->row;
        const int some = 1 + (int)(test_random_u64(&r) % (uint64_t)longest);
        status = ibl_rows_read(rows, some < left ? some : left,
                               img->data + floats * (size_t)rows->row);
    }
    if (status)
        ibl_image_free(img);
    return status;
}

const char *file_built(const char *name)
{
    static char path[600];
    char self[512];
    const ssize_t n = readlink("/proc/self/exe", self, sizeof self - 1);
    if (n < 0)
        return NULL;
    self[n] = 0;
    for (int i = 0; i < 2; i++) { /* up from tests/check_x */
        char *slash = strrchr(self, '/');
        if (!slash)
            return NULL;
        *slash = 0;
    }
    snprintf(path, sizeof path, "%s/%.60s", self, name);
    return access(path, R_OK) ? NULL : path;
}

const char *file_bridge(void)
{
    static char path[600];
    const char *built = file_built("libiblbridge.so");

    if (!built)
        return NULL;
    snprintf(path, sizeof path, "%s", built);
    return path;
}

void file_need_oiio(void)
{
    if (!file_bridge() || !file_have("oiiotool"))
        test_skip("needs the image bridge and oiiotool");
}

ibl_ctx *file_ctx(int threads, void *kept, const char *bridge)
{
    ibl_ctx_options opts = ibl_ctx_options_default();
    opts.threads = threads;
    opts.log = test_keep;
    opts.log_cookie = kept;
    opts.bridge = bridge ? bridge : "/nonexistent/libiblbridge.so";
    return test_ctx_of(&opts);
}
