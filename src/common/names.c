/* SPDX-License-Identifier: MIT */
#include "common/names.h"

#include <stdio.h>
#include <string.h>

#include <ibl/io.h>

_Static_assert(IBL_CONTAINER_KTX2 == 0 && IBL_CONTAINER_KTX == 1 &&
                   IBL_CONTAINER_DDS == 2,
               "containers as named");
const char *const ibl_container_names[] = {"ktx2", "ktx", "dds", NULL};

_Static_assert(IBL_PIXEL_RGBA16F == 0 && IBL_PIXEL_RGBA32F == 1 &&
                   IBL_PIXEL_RGB9E5 == 2 && IBL_PIXEL_R11G11B10F == 3,
               "pixels as named");
const char *const ibl_pixel_names[] = {"rgba16f", "rgba32f", "rgb9e5",
                                       "r11g11b10f", NULL};

_Static_assert(IBL_OVERFLOW_SPREAD == 0 && IBL_OVERFLOW_CLIP == 1,
               "overflows as named");
const char *const ibl_overflow_names[] = {"spread", "clip", NULL};

_Static_assert(IBL_ROUGHNESS_LINEAR == 0 && IBL_ROUGHNESS_FILAMENT == 1,
               "mappings as named");
const char *const ibl_mapping_names[] = {"linear", "filament", NULL};

_Static_assert(IBL_METHOD_AUTO == 0 && IBL_METHOD_SPECTRAL == 1 &&
                   IBL_METHOD_SAMPLED == 2,
               "methods as named");
const char *const ibl_method_names[] = {"auto", "spectral", "sampled", NULL};

_Static_assert(IBL_LOBE_GGX == 0 && IBL_LOBE_CHARLIE == 1 &&
                   IBL_LOBE_PHONG == 2,
               "lobes as named");
const char *const ibl_lobe_names[] = {"ggx", "charlie", "phong", NULL};

_Static_assert(IBL_GEOMETRY_SMITH == 0 && IBL_GEOMETRY_SCHLICK_IBL == 1,
               "geometry terms as named");
const char *const ibl_geometry_names[] = {"smith", "schlick-ibl", NULL};
const char *const ibl_lut_stems[] = {"brdf_lut", "brdf_lut_schlick-ibl", NULL};

void ibl_names_text(const char *const *names, char *text, size_t size)
{
    *text = '\0';
    for (int i = 0; names[i]; i++) {
        const size_t used = strlen(text);
        const char *between = i == 0 ? "" : names[i + 1] ? ", " : " or ";
        snprintf(text + used, size - used, "%s%s", between, names[i]);
    }
}

int ibl_names_find(const char *const *names, const char *word)
{
    for (int i = 0; names[i]; i++)
        if (!strcmp(names[i], word))
            return i;
    return -1;
}
