/* SPDX-License-Identifier: MIT */
/* Memory: alignment, zeroes, sizes around where huge pages begin, refusals; a
 * program's own. */
#include "core/alloc.h"

#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "ibl/sidecar.h"
#include "test.h"

static const size_t sizes[] = {0,
                               1,
                               63,
                               64,
                               65,
                               4096,
                               (1 << 20) - 1,
                               1 << 20,
                               (1 << 21) - 1,
                               1 << 21,
                               (1 << 21) + 1,
                               5 << 20};

enum {
    SIZES = sizeof sizes / sizeof sizes[0]
};

enum {
    MIB = 1 << 20
};

/* Whether a block takes the memory of one that was freed, which fresh memory
 * of the system, all 0, cannot be. between: done meanwhile. */
static bool takes(int asked_mib, int freed_mib, ibl_ctx *between)
{
    const size_t freed = (size_t)freed_mib * MIB;
    const size_t asked = (size_t)asked_mib * MIB;
    unsigned char *p = ibl_alloc_array(freed, 1);
    if (!p)
        return false;
    memset(p, 77, freed);
    ibl_free(p);
    ibl_ctx_free(between);
    p = ibl_alloc_array(asked, 1);
    const bool same = p && p[asked / 2] == 77;
    ibl_free(p);
    return same;
}

/* Memory is kept as long as there is a context, whichever ends before. */
TEST(kept_for_contexts)
{
    if (TEST_SANITIZED)
        test_skip("sanitizers are to see every block go");
    ibl_ctx *a, *b;
    NEED(!ibl_ctx_create(NULL, &a) && !ibl_ctx_create(NULL, &b));
    for (int i = 0; i < 8; i++)
        CHECK(takes(8, 8, NULL));
    CHECK(takes(2, 16, NULL));
    CHECK(takes(8, 8, a));
    CHECK(!takes(8, 8, b));
    CHECK(!takes(8, 8, NULL));
}

/* Two rounds, so that memory is used again that was not zero. */
TEST(every_size)
{
    unsigned char *p[SIZES];
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < SIZES; i++) {
            p[i] = ibl_alloc_zeroed(sizes[i], 1);
            NEED(p[i]);
            CHECK((uintptr_t)p[i] % 64 == 0);
            size_t others = 0;
            for (size_t k = 0; k < sizes[i]; k++)
                others += p[i][k] != 0;
            CHECK_MSG(!others, "%zu of %zu bytes not 0", others, sizes[i]);
            memset(p[i], i + 1, sizes[i]);
        }
        for (int i = 0; i < SIZES; i++) {
            CHECK(!sizes[i] ||
                  (p[i][0] == i + 1 && p[i][sizes[i] - 1] == i + 1));
            ibl_free(p[i]);
        }
    }
    ibl_free(NULL);
}

/* More large blocks than the heap has room for, freed in another order: none
 * overlap. */
TEST(many_large)
{
    enum {
        BLOCKS = 200,
        EDGE = 1 << 20
    };
    static unsigned char *p[BLOCKS];
    size_t last[BLOCKS];
    test_random rnd = {5};

    ibl_alloc_hold();
    for (int n = 0; n < 600; n++) {
        const int i = (int)(test_random_u64(&rnd) % BLOCKS);
        if (p[i]) {
            CHECK(p[i][0] == i && p[i][last[i]] == i);
            ibl_free(p[i]);
            p[i] = NULL;
        } else {
            last[i] = EDGE + (size_t)(test_random_u64(&rnd) % (3 * EDGE));
            p[i] = ibl_alloc_array(last[i] + 1, 1);
            NEED(p[i]);
            for (int k = 0; k < BLOCKS; k++)
                CHECK(k == i || !p[k] || p[i] + last[i] < p[k] ||
                      p[k] + last[k] < p[i]);
            p[i][0] = p[i][last[i]] = (unsigned char)i;
        }
        if (n % 100 == 99) {
            ibl_alloc_release();
            ibl_alloc_hold();
        }
    }
    for (int i = 0; i < BLOCKS; i++)
        ibl_free(p[i]);
    ibl_alloc_release();
}

TEST(too_much)
{
    CHECK(!ibl_alloc_array(SIZE_MAX, 1));
    CHECK(!ibl_alloc_array(SIZE_MAX / 2, 1));
    CHECK(!ibl_alloc_array(SIZE_MAX / 2, 3));
    CHECK(!ibl_alloc_array(1, SIZE_MAX - 62));
    CHECK(!ibl_alloc_array((size_t)1 << 33, (size_t)1 << 33));
}

/* ---- a program's allocator --------------------------------------------- */

/* In front of each block that the library takes. */
typedef struct head {
    void *start;
    size_t mark;
} head;

enum {
    MARK = 0x1b1b1b
};

static struct {
    pthread_mutex_t lock;
    size_t blocks;    /* now */
    int calls, fails; /* the call that fails, from 1; 0: none */
    bool bad;         /* a block that is none, or is misaligned */
} own = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* What is not written before it is read is not 0 by chance. */
static void *own_alloc(void *cookie, size_t bytes, size_t alignment)
{
    pthread_mutex_lock(&own.lock);
    const bool ok = ++own.calls != own.fails;
    own.bad |= cookie != &own || !bytes || alignment < sizeof(head);
    own.blocks += ok;
    pthread_mutex_unlock(&own.lock);
    char *start = ok ? malloc(bytes + 2 * alignment) : NULL;
    if (!start)
        return NULL;
    char *p = start + 2 * alignment - (uintptr_t)start % alignment;
    ((head *)p)[-1] = (head){start, MARK};
    return memset(p, 0xa5, bytes);
}

static void own_release(void *cookie, void *p)
{
    const head h = ((head *)p)[-1];

    pthread_mutex_lock(&own.lock);
    own.bad |= cookie != &own || h.mark != MARK;
    own.blocks--;
    pthread_mutex_unlock(&own.lock);
    free(h.start);
}

static const ibl_allocator owns = {own_alloc, own_release, &own};

/* Reads a small EXR, bakes it, writes a file to memory, which kept gets, and
 * reads that. */
static ibl_status use(int threads, test_messages *said, char kept[1 << 14])
{
    ibl_ctx_options with = ibl_ctx_options_default();
    ibl_bake_options o = ibl_bake_options_default();
    ibl_lut_options lo = ibl_lut_options_default();
    ibl_lobe_table_options to = ibl_lobe_table_options_default();
    ibl_sidecar_options facts = ibl_sidecar_options_default();
    ibl_ctx *ctx = NULL;
    ibl_image map = {0};
    ibl_bake_result made = {0};
    ibl_lut lut = {0};
    ibl_lobe_table table = {0};
    ibl_texture tex = {0}, read = {0};
    void *bytes = NULL;
    size_t count = 0;

    facts.made = &made;
    with.threads = threads;
    with.log = test_keep;
    with.log_cookie = said;
    o.specular_options.size = o.irradiance_options.size = o.skybox = 8;
    ibl_specular_options sampled = o.specular_options;
    sampled.method = IBL_METHOD_SAMPLED;
    o.more = &sampled;
    o.more_count = 1;
    lo.size = to.size = 4;
    ibl_status status = ibl_ctx_create(&with, &ctx);
    if (!status)
        status = ibl_image_read(ctx, file_path("a.exr"), NULL, &map, NULL);
    const ibl_environment env = {.image = &map};
    if (!status)
        status = ibl_bake_environment(ctx, &env, &o, &made);
    if (!status)
        status = ibl_bake_lut(ctx, &lo, &lut);
    if (!status)
        status = ibl_bake_lobe_table(ctx, &to, &table);
    if (!status)
        status = ibl_texture_from_cube(ctx, &made.specular, NULL, &tex, NULL);
    if (!status)
        status = ibl_texture_describe(
            ctx, &tex, &facts,
            &(ibl_sidecar_output){.content = IBL_CONTENT_SPECULAR});
    if (!status)
        status =
            ibl_texture_encode(ctx, &tex, IBL_CONTAINER_KTX2, &bytes, &count);
    if (!status)
        status = ibl_texture_decode(ctx, "texture", bytes, count, &read, NULL);
    if (!status)
        memcpy(kept, bytes, count < 1 << 14 ? count : 1 << 14);
    ibl_bytes_free(bytes);
    ibl_texture_free(&read);
    ibl_texture_free(&tex);
    ibl_lobe_table_free(&table);
    ibl_lut_free(&lut);
    ibl_bake_result_free(&made);
    ibl_image_free(&map);
    ibl_ctx_free(ctx);
    return status;
}

static void make_file(void)
{
    float data[3 * 8 * 4];
    const ibl_image map = {8, 4, data};

    for (int i = 0; i < 3 * 8 * 4; i++)
        data[i] = (float)(i % 7);
    if (!file_save_exr(file_path("a.exr"), &map, NULL))
        exit(1);
}

/* With all memory nothing is left; without one piece that is told once, and
 * nothing is left, either. */
TEST(memory_of_the_program)
{
    static char first[1 << 14], other[1 << 14];
    const ibl_allocator half = {own_alloc, NULL, NULL};
    test_messages said = {0};
    ibl_ctx *ctx;
    int calls = 0;

    make_file();
    NEED(!use(1, &said, first));
    CHECK(ibl_set_allocator(&half) == IBL_ERR_ARGUMENT);
    NEED(!ibl_set_allocator(&owns));
    NEED(!use(2, &said, other));
    CHECK(!memcmp(first, other, sizeof first));
    CHECK_MSG(!own.bad && !own.blocks && own.calls > 100,
              "%zu blocks left of %d", own.blocks, own.calls);
    NEED(!ibl_ctx_create(NULL, &ctx));
    CHECK(own.blocks > 0);
    CHECK(ibl_set_allocator(NULL) == IBL_ERR_ARGUMENT);
    ibl_ctx_free(ctx);
    for (int n = 1; !calls; n += TEST_SANITIZED ? 7 : 1) {
        own.calls = 0;
        own.fails = n;
        memset(&said, 0, sizeof said);
        const ibl_status status = use(1, &said, other);
        const bool failed = own.calls >= n;
        CHECK_MSG(!own.bad && !own.blocks, "call %d: %zu blocks left", n,
                  own.blocks);
        CHECK_MSG(failed ? status == IBL_ERR_MEMORY &&
                               strstr(said.text[0], "memory")
                         : !status,
                  "call %d: status %d: %s", n, status, said.text[0]);
        calls = failed ? 0 : n;
    }
    own.fails = 0;
    CHECK(calls > 100 && !ibl_set_allocator(NULL));
}
