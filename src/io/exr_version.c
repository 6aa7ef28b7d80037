/* SPDX-License-Identifier: MIT */
#include <pthread.h>
#include <stdio.h>

#include "ibl/io.h"
#include "io/exr_file.h"

static char text[48];

static void find(void)
{
    int major = 0, minor = 0, patch = 0;
    const char *extra = NULL;

    exr_get_library_version(&major, &minor, &patch, &extra);
    snprintf(text, sizeof text, "%d.%d.%d%s%s", major, minor, patch,
             extra && *extra ? "-" : "", extra ? extra : "");
}

const char *ibl_exr_version(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, find);
    return text;
}
