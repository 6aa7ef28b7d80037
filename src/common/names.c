/* SPDX-License-Identifier: MIT */
#include "common/names.h"

#include <assert.h>

#include <ibl/io.h>

const char *const ibl_format_names[] = {
    "ktx2",       "ktx", "dds", "dds-legacy", "env", "gltf",
    "playcanvas", "exr", "hdr", "png",        NULL};
const char *const ibl_array_container_names[] = {"ktx2", "ktx", "dds", NULL};
const char *const ibl_pixel_names[] = {"rgba16f",    "rgba32f", "rgb9e5",
                                       "r11g11b10f", "bc6h",    "uastc-hdr",
                                       "astc4x4hdr", NULL};
const char *const ibl_quality_names[] = {"fast", "normal", "best", NULL};
static_assert(sizeof ibl_pixel_names / sizeof *ibl_pixel_names ==
                  IBL_PIXEL_RG16F + 1,
              "names of the formats of cubes, which come first");
const char *const ibl_overflow_names[] = {"spread", "clip", NULL};
const char *const ibl_mapping_names[] = {"linear", "filament", "babylon", NULL};
const char *const ibl_mirror_names[] = {"none", "x", "z", "xz", NULL};
const char *const ibl_up_names[] = {"y", "z", NULL};
const char *const ibl_method_names[] = {"spectral", "sampled", NULL};
const char *const ibl_projection_names[] = {"cube", "equirect", "octahedral",
                                            NULL};
const char *const ibl_layout_names[] = {"cube", "equirect", "octahedral",
                                        "cross", NULL};
const char *const ibl_lobe_names[] = {IBL_LOBE_NAMES, NULL};
const char *const ibl_lut_names[] = {IBL_LUT_NAMES, NULL};
const char *const ibl_geometry_names[] = {"smith", "schlick-ibl", NULL};
const char *const ibl_primaries_names[] = {"keep", "rec709", "acescg",
                                           "rec2020", NULL};
const char *const ibl_transfer_names[] = {"file", "linear", "srgb", NULL};
const char *const ibl_lut_stems[] = {"brdf_lut", "brdf_lut_schlick-ibl", NULL};
const char *const ibl_table_stems[] = {"brdf_lut", "brdf_lut_multiscatter",
                                       "brdf_lut_charlie", NULL};

const char *const ibl_input_names[] = {
    "auto",   "equirect", "cube",   "faces",      "hcross",
    "vcross", "hstrip",   "vstrip", "octahedral", NULL};
