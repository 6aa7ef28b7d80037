/* SPDX-License-Identifier: MIT */
#ifndef CLI_JSON_TEXT_H
#define CLI_JSON_TEXT_H

#include <jansson.h>

/*
 * JSON for people and programs: indented, arrays of plain values on one line,
 * each number with the fewest digits that read back as the same double. The
 * text ends with a newline and is the caller's to free; NULL: no memory.
 */
char *ibl_json_text(const json_t *root);

/* A string of any bytes: those that are not UTF-8 become U+FFFD. */
json_t *ibl_json_string(const char *bytes);

#endif
