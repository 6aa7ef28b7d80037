/* SPDX-License-Identifier: MIT */
#include "view/message.h"

#include <stdarg.h>
#include <string.h>

#include "common/process.h"

static bool quiet;
static char last_failure[IBL_LINE_BYTES];

bool view_fail(const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    vsnprintf(last_failure, sizeof last_failure, fmt, ap);
    va_end(ap);
    ibl_print_line("", last_failure);
    return false;
}

const char *view_last_failure(void)
{
    return last_failure;
}

void view_note(const char *fmt, ...)
{
    char text[IBL_LINE_BYTES];
    va_list ap;

    if (quiet)
        return;
    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    ibl_print_line("note: ", text);
}

void view_add(char *text, size_t size, const char *fmt, ...)
{
    const size_t used = strlen(text);
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text + used, size - used, fmt, ap);
    va_end(ap);
}

void view_quiet(void)
{
    quiet = true;
}

void view_log(void *cookie, ibl_log_level level, const char *text)
{
    (void)cookie;
    if (level == IBL_LOG_ERROR)
        view_fail("%s", text);
    else if (level == IBL_LOG_WARNING)
        view_note("%s", text);
}
