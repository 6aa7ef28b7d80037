/* SPDX-License-Identifier: MIT */
#include "cli/version.h"

#include <jansson.h>
#include <png.h>
#include <stdlib.h>
#include <unistd.h>
#include <xxhash.h>
#include <zlib.h>

#include <ibl/ibl.h>
#include <ibl/io.h>

#include "common/bridge_file.h"

#if defined(__clang__)
#define COMPILER "clang " __clang_version__
#elif defined(__GNUC__)
#define COMPILER "gcc " __VERSION__
#else
#define COMPILER "unknown"
#endif

const char *ibl_version_compiler(void)
{
    return COMPILER;
}

const char *ibl_version_revision(void)
{
    return IBL_REVISION;
}

void ibl_version_print(FILE *to)
{
    char *beside = ibl_bridge_beside();
    const char *bridge = beside ? beside : ibl_bridge_path();
    const char *revision = IBL_REVISION;

    fprintf(to, "iblbake %s%s%s%s\n", IBL_VERSION, *revision ? " (" : "",
            revision, *revision ? ")" : "");
    fprintf(to, "compiler      %s\n", COMPILER);
    fprintf(to,
            "libraries     OpenEXRCore %s, libpng %s, zlib %s, jansson %s, "
            "xxHash %u.%u.%u\n",
            ibl_exr_version(), png_get_libpng_ver(NULL), zlibVersion(),
            jansson_version_str(), XXH_versionNumber() / 10000,
            XXH_versionNumber() / 100 % 100, XXH_versionNumber() % 100);
    /* Not opened to look: that would take longer than all else here. */
    if (access(bridge, R_OK))
        fprintf(to, "image bridge  none (%s)\n", bridge);
    else
        fprintf(to, "image bridge  %s\n", bridge);
    fprintf(to, "instructions  %s\n", ibl_isa_name(ibl_isa_best()));
    fprintf(to, "threads       %d\n", ibl_cpu_count());
    free(beside);
}
