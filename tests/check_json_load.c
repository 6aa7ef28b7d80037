/* SPDX-License-Identifier: MIT */
/* JSON files: whole ones, and what is none, which hangs nothing. */
#include <stdlib.h>
#include <string.h>

#include "files.h"
#include "test.h"
#include "json/json_load.h"

/* Longer than what is read at once. */
TEST(large)
{
    ibl_json_why why;

    NEED(file_run("{ printf '[7'; yes ,7 | head -n 99999; echo ']'; } "
                  ">large.json"));
    json_t *root = ibl_json_load(file_path("large.json"), 0, &why);
    CHECK(json_array_size(root) == 100000);
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

/* 36 MB of empty arrays, which would take 1.3 GB. */
TEST(bomb)
{
    ibl_json_why why = {0};

    NEED(file_run("{ echo '['; yes '[],' | head -n 12000000; } >bomb.json"));
    CHECK(!ibl_json_load(file_path("bomb.json"), 0, &why));
    CHECK_MSG(why.status == IBL_ERR_FORMAT &&
                  strstr(why.line, "bomb.json: over 8388608 values"),
              "%s", why.line);
}

/* Arrays of plain values are on one line, whatever their strings have. */
TEST(text)
{
    json_t *root = json_pack("{s[[ff][]] s[s s] s[{}]}", "a", .1, 1e-20, "b",
                             "[{\"\\", "]\n", "c");
    char *text = ibl_json_text(root);

    CHECK_MSG(text && !strcmp(text, "{\n"
                                    "  \"a\": [\n"
                                    "    [0.1, 1e-20],\n"
                                    "    []\n"
                                    "  ],\n"
                                    "  \"b\": [\"[{\\\"\\\\\", \"]\\n\"],\n"
                                    "  \"c\": [\n"
                                    "    {}\n"
                                    "  ]\n"
                                    "}\n"),
              "%s", text);
    free(text);
    json_decref(root);
    CHECK(!ibl_json_text(NULL));
}
