/* SPDX-License-Identifier: MIT */
/* Damaged EXR files are refused with one line, and those of other kinds; and
 * memory that runs out is not taken for damage. */
#include <OpenEXR/openexr.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "exr.h"
#include "files.h"

/* ---- OpenEXRCore's memory, which the linker lets us give (--wrap) ------ */

static atomic_int grants = -1; /* of memory that are left; -1: no end */

static void *grant(size_t bytes)
{
    int left = grants;
    while (left > 0 && !atomic_compare_exchange_weak(&grants, &left, left - 1))
        ;
    return left ? malloc(bytes) : NULL;
}

exr_result_t __real_exr_start_read(exr_context_t *exr, const char *name,
                                   const exr_context_initializer_t *init);
exr_result_t __wrap_exr_start_read(exr_context_t *exr, const char *name,
                                   const exr_context_initializer_t *init);

exr_result_t __wrap_exr_start_read(exr_context_t *exr, const char *name,
                                   const exr_context_initializer_t *init)
{
    exr_context_initializer_t with = *init;
    with.alloc_fn = grant;
    with.free_fn = free;
    return __real_exr_start_read(exr, name, &with);
}

/* ---- files ------------------------------------------------------------- */

/* Decodes bytes in memory of just their size, so that a sanitizer sees every
 * byte too far. True if it went well or was refused with one line. */
static bool survives(const unsigned char *bytes, size_t size,
                     ibl_status *status)
{
    ibl_read_options opts = ibl_read_options_default();
    ibl_read_report report = {.format = ""};
    ibl_image img = {0};
    unsigned char *copy = malloc(size ? size : 1);
    memcpy(copy, bytes, size);
    memset(&test_exr_kept, 0, sizeof test_exr_kept);
    opts.any_aspect = 1;
    opts.alpha = IBL_ALPHA_FILE;
    *status = test_exr_decode_bytes(copy, size, &opts, &img, &report);
    free(copy);
    if (!*status) {
        ibl_image_free(&img);
        return true;
    }
    return test_exr_kept.text[0][0] && !img.data &&
           !strchr(test_exr_kept.text[0], '\n');
}

/* The files of most tests, which the first of them writes. */
static void begin(void)
{
    static bool written;

    test_exr_begin(2, 24, 40);
    NEED(written ||
         file_run("oiiotool s.pfm -d half --compression zip -o zip.exr "
                  "--compression piz -o piz.exr --compression none -o none.exr "
                  "--tile 16 16 --compression zip -o tiles.exr --compression "
                  "piz -o piz_tiles.exr --compression b44 -o b44.exr "
                  "--scanline --compression zip s.pfm s.pfm --siappend -o "
                  "parts.exr"));
    written = true;
}

TEST(cut_short)
{
    static const char *const names[] = {"zip.exr", "piz.exr", "b44.exr",
                                        "parts.exr"};
    begin();
    for (int i = 0; i < 4; i++) {
        const char *name = names[i];
        size_t size;
        unsigned char *bytes = file_load(file_path(name), &size);
        ibl_status status;
        /* A multi-part file's first part may be whole in a cut file. */
        const size_t end = i == 3 ? size / 2 : size;
        for (size_t n = 0; n < end; n += n < 600 ? 1 : 7) {
            CHECK_MSG(survives(bytes, n, &status), "%s at %zu", name, n);
            CHECK_MSG(status == IBL_ERR_FORMAT, "%s at %zu: %d", name, n,
                      status);
        }
    }
}

/* What libiblexr.so reads, cut and with flipped bits, some in its header:
 * smooth, or it would be stored as it is. Other damage at random is the
 * fuzzers'. */
TEST(dwa)
{
    test_exr_begin(2, 64, 72);
    test_random r = {2025};

    for (int i = 0; i < 3 * 64 * 72; i++)
        test_exr_img.data[i] = 0.01f * (float)(i / 96);
    NEED(file_save_pfm(file_path("s.pfm"), &test_exr_img));
    NEED(file_run("oiiotool s.pfm -d half --compression dwaa -o lines.exr "
                  "--tile 32 32 --compression dwab -o tiles.exr"));
    for (int i = 0; i < 2; i++) {
        const char *name = i ? "tiles.exr" : "lines.exr";
        size_t size;
        unsigned char *bytes = file_load(file_path(name), &size);
        ibl_status status;
        int refused = 0;
        CHECK(size < 3 * 64 * 72);
        for (size_t n = 0; n < size; n += 17)
            CHECK_MSG(survives(bytes, n, &status) && status == IBL_ERR_FORMAT,
                      "%s at %zu: %d", name, n, status);
        for (int round = 0; round < 200; round++) {
            const int range = round % 2 ? (int)size : 700;
            unsigned char *at = bytes + test_random_below(&r, range);
            const unsigned char bit =
                (unsigned char)(1 << test_random_below(&r, 8));
            *at ^= bit;
            CHECK_MSG(survives(bytes, size, &status), "%s round %d", name,
                      round);
            refused += status != IBL_OK;
            *at ^= bit;
        }
        CHECK(refused > 20);
    }
}

/* Where the value of an attribute begins. */
static unsigned char *attribute(unsigned char *bytes, size_t size,
                                const char *name, const char *type)
{
    const size_t n = strlen(name) + 1, t = strlen(type) + 1;
    for (size_t i = 8; i + n + t + 4 < size; i++)
        if (!memcmp(bytes + i, name, n) && !memcmp(bytes + i + n, type, t))
            return bytes + i + n + t + 4;
    return NULL;
}

TEST(absurd_claims)
{
    static const int32_t boxes[][4] = {{0, 0, 65535, 32767},
                                       {0, 0, 0x3ffffffe, 0x3ffffffe},
                                       {0, 0, -1, -1},
                                       {5, 5, 4, 4},
                                       {-0x7fffffff, 0, 0, 9},
                                       {0, 0, 0x7fffffff, 9},
                                       {0, 0, 65535, 39},
                                       {0, 0, 23, 0x3ffffff},
                                       {0x3ffffff0, 0, 0x3ffffff8, 9}};
    static const char *const names[] = {"zip.exr", "tiles.exr", "none.exr"};
    begin();
    for (int i = 0; i < 3; i++) {
        size_t size;
        ibl_status status;
        unsigned char *bytes = file_load(file_path(names[i]), &size);
        unsigned char *box[] = {
            attribute(bytes, size, "dataWindow", "box2i"),
            attribute(bytes, size, "displayWindow", "box2i")};
        unsigned char was[2][16];
        for (int w = 0; w < 2; w++)
            memcpy(was[w], box[w], 16);
        for (size_t b = 0; b < sizeof boxes / sizeof boxes[0]; b++) {
            for (int w = 0; w < 2; w++) { /* of the data, and of both */
                for (int k = 0; k < 4; k++)
                    file_set_u32(box[w] + 4 * k, (uint32_t)boxes[b][k]);
                CHECK_MSG(survives(bytes, size, &status) &&
                              (status == IBL_ERR_FORMAT ||
                               status == IBL_ERR_UNSUPPORTED),
                          "%s box %zu: %d %s", names[i], b, status,
                          test_exr_kept.text[0]);
            }
            memcpy(box[1], was[1], 16);
        }
        memcpy(box[0], was[0], 16);
        unsigned char *tile = attribute(bytes, size, "tiles", "tiledesc");
        for (uint32_t v = 0; tile && v < 0x40000000u; v = v * 2 + 1) {
            file_set_u32(tile, v);
            CHECK(survives(bytes, size, &status));
        }
    }
}

/* Where the first block's number of bytes and its bytes are. */
static size_t first_block(const char *path)
{
    const exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_chunk_info_t info = {.data_offset = 0};
    exr_context_t exr;

    if (!exr_start_read(&exr, path, &init)) {
        exr_read_scanline_chunk_info(exr, 0, 0, &info);
        exr_finish(&exr);
    }
    return info.data_offset;
}

/* A block of ZIP must inflate to what it has pixels for, no byte less or more,
 * and its checksum must be right. What follows it is nobody's. */
TEST(zip_streams)
{
    enum {
        PIXELS = 16 * 24 * 6
    };
    static const struct {
        uLong raw; /* bytes that are deflated */
        int more;  /* bytes that the block is longer than that takes */
        int flip;  /* this many bytes before the end */
        bool good;
    } blocks[] = {{PIXELS, 0, 0, true},      {PIXELS, 9, 0, true},
                  {PIXELS, -1, 0, false},    {PIXELS, 0, 1, false},
                  {PIXELS, 0, 6, false},     {PIXELS - 1, 0, 0, false},
                  {PIXELS + 1, 0, 0, false}, {PIXELS / 2, 0, 0, false},
                  {0, 0, 0, false},          {9 * PIXELS, 0, 0, false}};
    static const Bytef raw[9 * PIXELS];
    begin();
    size_t size;
    unsigned char *bytes = file_load(file_path("zip.exr"), &size);
    unsigned char *data = bytes + first_block(file_path("zip.exr"));
    NEED(data > bytes);
    for (size_t b = 0; b < sizeof blocks / sizeof blocks[0]; b++) {
        uLongf packed = PIXELS / 2;
        ibl_status status;
        NEED(compress(data, &packed, raw, blocks[b].raw) == Z_OK);
        file_set_u32(data - 4, (uint32_t)((int)packed + blocks[b].more));
        if (blocks[b].flip)
            data[packed - (uLong)blocks[b].flip] ^= 1;
        CHECK(survives(bytes, size, &status));
        CHECK_MSG(status == (blocks[b].good ? IBL_OK : IBL_ERR_FORMAT),
                  "%zu: %d %s", b, status, test_exr_kept.text[0]);
    }
}

/* However early memory runs out, whatever attribute it was for: OpenEXRCore
 * itself opens a file whose compression it had no room to remember. */
TEST(out_of_memory)
{
    static const char *const names[] = {"zip.exr", "piz_tiles.exr"};
    begin();
    for (int i = 0; i < 2; i++) {
        const char *name = names[i];
        ibl_status status = IBL_ERR_MEMORY;
        size_t size;
        int n = 0;
        unsigned char *bytes = file_load(file_path(name), &size);
        for (; n < 200 && status; n++) {
            grants = n;
            CHECK(survives(bytes, size, &status));
            grants = -1;
            CHECK_MSG(!status || status == IBL_ERR_MEMORY, "%s, %d: %d %s",
                      name, n, status, test_exr_kept.text[0]);
        }
        CHECK_MSG(n > 10 && !status, "%s: %d", name, n);
    }
}

TEST(refused_kinds)
{
    test_exr_begin(2, 70, 35);
    NEED(file_run("oiiotool s.pfm --ch R,G,B,A=1,Z=1 -d half --deepen -o "
                  "deep.exr s.pfm --ch Z=1,id=2 -o z.exr"));
    test_exr_refused("deep.exr", NULL, -1, IBL_ERR_UNSUPPORTED, "deep");
    test_exr_refused("z.exr", NULL, -1, IBL_ERR_FORMAT, "Z, id");
}
