/* SPDX-License-Identifier: MIT */
/* JSON files: whole ones, and what is none, which hangs nothing. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "files.h"
#include "test.h"
#include "json/json_load.h"

/* Longer than what is read at once. */
TEST(large)
{
    enum {
        COUNT = 100000
    };
    ibl_json_why why;
    char *numbers = malloc(2 * COUNT + 2);
    NEED(numbers);
    for (int i = 0; i < COUNT; i++)
        memcpy(numbers + 2 * i, i ? ",7" : "[7", 2);
    numbers[2 * COUNT] = ']';
    NEED(file_save(file_path("large.json"), numbers, 2 * COUNT + 1));
    free(numbers);
    json_t *root = ibl_json_load(file_path("large.json"), 0, &why);
    CHECK(json_array_size(root) == COUNT);
    json_decref(root);
}

TEST(refused)
{
    static const struct {
        const char *name, *said;
        bool damaged;
    } cases[] = {
        {"none.json", "none.json: cannot be read: No such file", false},
        {"directory", "directory: is a directory", false},
        {"fifo", "fifo: is no file", false},
        {"zeros", "zeros: is no file", false},
        {"huge.json", "huge.json: over 256 MiB", true},
        {"empty.json", "empty.json:1:0: no JSON: ", true},
        {"cut.json", "cut.json:2:", true},
        {"nul.json", "nul.json:1:", true},
        {"twice.json", "twice.json:1:", true},
    };
    NEED(file_run("mkdir directory && mkfifo fifo && ln -s /dev/zero zeros && "
                  "truncate -s 1G huge.json && : >empty.json && "
                  "printf '{\"a\":\\n 1' >cut.json && "
                  "printf '[1]\\0' >nul.json && "
                  "echo '{\"a\": 1, \"a\": 2}' >twice.json"));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ibl_json_why why = {0};
        CHECK(!ibl_json_load(file_path(cases[i].name), JSON_REJECT_DUPLICATES,
                             &why));
        CHECK_MSG(strstr(why.line, cases[i].said) &&
                      (why.status == IBL_ERR_FORMAT) == cases[i].damaged,
                  "%s: %s", cases[i].name, why.line);
    }
}

/* ---- no memory --------------------------------------------------------- */

static int left = -1; /* allocations until one fails, and, if it stays, all */
static bool stays;

/* A block that ends where a page ends behind which there is nothing. */
static void *guarded(size_t size)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t used = (size + 7) / 8 * 8 + sizeof(size_t[2]);
    const size_t all = (used + page - 1) / page * page + page;

    if (left >= 0 && left-- == 0) {
        left = stays ? 0 : -1;
        return NULL;
    }
    char *at = mmap(NULL, all, PROT_READ | PROT_WRITE,
                    MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED || mprotect(at + all - page, page, PROT_NONE))
        return NULL;
    size_t *head = (size_t *)(at + all - page - used);
    head[0] = (size_t)at;
    head[1] = all;
    return head + 2;
}

static void unmap(void *block)
{
    const size_t *head = block;

    if (block)
        munmap((void *)head[-2], head[-1]);
}

/* Whichever allocation fails, alone or with all after it, that is what is said.
 * Strings, escapes and numbers end on both sides of where jansson's lexer,
 * which overlooks it, asks for more.
 */
TEST(without_memory)
{
    json_malloc_t ask;

    json_set_alloc_funcs(guarded, unmap);
    for (int length = 8; length < 132; length++) {
        const char *x = test_text("%0*d", length, 0);
        const char *told = test_text(
            "{\"%s\": [\"%s\\u00e9\", \"\\\"%s\"],\n \"\": 1.%s}", x, x, x, x);
        json_t *root = NULL;
        int n = 0;
        if (length % 16 > 0 && length % 16 < 8)
            continue;
        for (; n < 1000; n += stays, stays = !stays) {
            ibl_json_why why = {0};
            left = n;
            root = ibl_json_parse("it", told, strlen(told), 0, &why);
            left = -1;
            if (root)
                break;
            CHECK_MSG(strstr(why.line, "it: no memory") &&
                          why.status == IBL_ERR_MEMORY,
                      "%d digits, after %d: %s", length, n, why.line);
        }
        CHECK_MSG(json_number_value(json_object_get(root, "")) == 1 && n > 10,
                  "%d digits, %d allocations", length, n);
        json_decref(root);
    }
    json_get_alloc_funcs(&ask, NULL);
    CHECK(ask == guarded);
    json_set_alloc_funcs(malloc, free);
}

/* 36 MB of empty arrays, which would take 1.3 GB. */
TEST(bomb)
{
    const char *large = getenv("IBL_TEST_LARGE");
    ibl_json_why why = {0};

    if (!large || !*large)
        test_skip("LARGE=1 runs it");
    NEED(file_run("{ echo '['; yes '[],' | head -n 12000000; } >bomb.json"));
    CHECK(!ibl_json_load(file_path("bomb.json"), 0, &why));
    CHECK_MSG(why.status == IBL_ERR_FORMAT &&
                  strstr(why.line, "bomb.json: takes over"),
              "%s", why.line);
}
