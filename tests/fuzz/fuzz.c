/* SPDX-License-Identifier: MIT */
#include "fuzz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

#include "common/process.h"

ibl_ctx *fuzz_ctx;
size_t fuzz_longest_read;

/* Kernels of plain C, where the sanitizers see all, and the CPU's own. */
static ibl_ctx *contexts[2];
static char folder[256];
static int errors;

void fuzz_fail(int line, const char *expr)
{
    fprintf(stderr, "fuzz: line %d: not %s\n", line, expr);
    abort();
}

int fuzz_choice(fuzz_input *in, int count)
{
    return in->size ? in->bytes[--in->size] % count : 0;
}

/* ---- messages ---------------------------------------------------------- */

static void check_line(const char *text)
{
    FUZZ_NEED(*text && !strchr(text, '\n'));
}

static void count_line(void *cookie, ibl_log_level level, const char *text)
{
    (void)cookie;
    check_line(text);
    errors += level == IBL_LOG_ERROR;
}

/* In place of the function that prints on standard error (--wrap). */
void __wrap_ibl_print_line(const char *kind, const char *text);
void __wrap_ibl_print_line(const char *kind, const char *text)
{
    char line[IBL_LINE_BYTES];

    snprintf(line, sizeof line, "%s", text);
    ibl_one_line(line);
    check_line(line);
    errors += strcmp(kind, "note: ") && strcmp(kind, "warning: ");
}

void fuzz_said(bool failed)
{
    FUZZ_NEED(failed ? errors > 0 : !errors);
    errors = 0;
}

/* ---- files ------------------------------------------------------------- */

const char *fuzz_path(const char *name)
{
    static char paths[4][512];
    static int next;
    char *path = paths[next++ % 4];

    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

const char *fuzz_save(const char *name, const void *bytes, size_t size)
{
    const char *path = fuzz_path(name);
    FILE *file = fopen(path, "wb");

    FUZZ_NEED(file);
    FUZZ_NEED(fwrite(bytes, 1, size, file) == size);
    FUZZ_NEED(!fclose(file));
    return path;
}

static size_t shorten(size_t size)
{
    return fuzz_longest_read && size > fuzz_longest_read ? fuzz_longest_read
                                                         : size;
}

/* In place of the system's calls (--wrap). */
ssize_t __real_read(int fd, void *to, size_t size);
ssize_t __wrap_read(int fd, void *to, size_t size);
ssize_t __real_pread(int fd, void *to, size_t size, off_t at);
ssize_t __wrap_pread(int fd, void *to, size_t size, off_t at);

ssize_t __wrap_read(int fd, void *to, size_t size)
{
    return __real_read(fd, to, shorten(size));
}

ssize_t __wrap_pread(int fd, void *to, size_t size, off_t at)
{
    return __real_pread(fd, to, shorten(size), at);
}

/* ---- textures ---------------------------------------------------------- */

ibl_texture fuzz_texture(ibl_pixel pixel, int size, int levels, int faces)
{
    ibl_texture tex = {.pixel = pixel,
                       .width = size,
                       .height = size,
                       .levels = levels,
                       .layers = 1,
                       .faces = faces};

    for (int l = 0; l < levels; l++)
        tex.bytes += (size_t)(size >> l) * (size_t)(size >> l) * (size_t)faces *
                     ibl_pixel_bytes(pixel);
    tex.data = malloc(tex.bytes);
    FUZZ_NEED(tex.data);
    /* In halves and floats 0.5 or a little more. */
    memset(tex.data, 0x3f, tex.bytes);
    return tex;
}

/* ---- libFuzzer's two functions ------------------------------------------- */

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    ibl_ctx_options opts = ibl_ctx_options_default();
    const char *tmp = getenv("TMPDIR");

    (void)argc;
    (void)argv;
    opts.threads = 1;
    opts.log = count_line;
    for (int i = 0; i < 2; i++) {
        opts.isa = i ? IBL_ISA_AUTO : IBL_ISA_C;
        FUZZ_NEED(!ibl_ctx_create(&opts, &contexts[i]));
    }
    fuzz_ctx = contexts[0];
    snprintf(folder, sizeof folder, "%s/fuzz-XXXXXX", tmp ? tmp : "/tmp");
    FUZZ_NEED(mkdtemp(folder));
    fuzz_begin();
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    errors = 0;
    fuzz_longest_read = 0;
    fuzz_ctx = contexts[size % 2];
    fuzz_one((fuzz_input){bytes, size});
    return 0;
}
