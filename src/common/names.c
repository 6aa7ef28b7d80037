/* SPDX-License-Identifier: MIT */
#include "common/names.h"

#include <assert.h>

#include <ibl/io.h>

const char *const ibl_format_names[] = {[IBL_CONTAINER_KTX2] = "ktx2",
                                        [IBL_CONTAINER_KTX] = "ktx",
                                        [IBL_CONTAINER_DDS] = "dds",
                                        [IBL_CONTAINER_DDS_LEGACY] =
                                            "dds-legacy",
                                        "env",
                                        "gltf",
                                        "playcanvas",
                                        "exr",
                                        "hdr",
                                        "png",
                                        NULL};
const char *const ibl_array_container_names[] = {[IBL_CONTAINER_KTX2] = "ktx2",
                                                 [IBL_CONTAINER_KTX] = "ktx",
                                                 [IBL_CONTAINER_DDS] = "dds",
                                                 NULL};
const char *const ibl_pixel_names[] = {[IBL_PIXEL_RGBA16F] = "rgba16f",
                                       [IBL_PIXEL_RGBA32F] = "rgba32f",
                                       [IBL_PIXEL_RGB9E5] = "rgb9e5",
                                       [IBL_PIXEL_R11G11B10F] = "r11g11b10f",
                                       [IBL_PIXEL_BC6H] = "bc6h",
                                       [IBL_PIXEL_UASTC_HDR] = "uastc-hdr",
                                       [IBL_PIXEL_ASTC4X4HDR] = "astc4x4hdr",
                                       NULL};
const char *const ibl_quality_names[] = {[IBL_QUALITY_FAST] = "fast",
                                         [IBL_QUALITY_NORMAL] = "normal",
                                         [IBL_QUALITY_BEST] = "best",
                                         NULL};
static_assert(sizeof ibl_pixel_names / sizeof *ibl_pixel_names ==
                  IBL_PIXEL_RG16F + 1,
              "names of the formats of cubes, which come first");
const char *const ibl_overflow_names[] = {
    [IBL_OVERFLOW_SPREAD] = "spread", [IBL_OVERFLOW_CLIP] = "clip", NULL};
const char *const ibl_mapping_names[] = {[IBL_ROUGHNESS_LINEAR] = "linear",
                                         [IBL_ROUGHNESS_FILAMENT] = "filament",
                                         [IBL_ROUGHNESS_BABYLON] = "babylon",
                                         NULL};
const char *const ibl_mirror_names[] = {[IBL_MIRROR_NONE] = "none",
                                        [IBL_MIRROR_X] = "x",
                                        [IBL_MIRROR_Z] = "z",
                                        [IBL_MIRROR_XZ] = "xz",
                                        NULL};
const char *const ibl_up_names[] = {[IBL_UP_Y] = "y", [IBL_UP_Z] = "z", NULL};
const char *const ibl_method_names[] = {[IBL_METHOD_AUTO] = "auto",
                                        [IBL_METHOD_SPECTRAL] = "spectral",
                                        [IBL_METHOD_SAMPLED] = "sampled",
                                        NULL};
const char *const ibl_projection_names[] = {"cube", "equirect", "octahedral",
                                            NULL};
const char *const ibl_layout_names[] = {"cube", "equirect", "octahedral",
                                        "cross", NULL};
const char *const ibl_lobe_names[] = {IBL_LOBE_NAMES, NULL};
const char *const ibl_lut_names[] = {IBL_LUT_NAMES, NULL};
const char *const ibl_geometry_names[] = {[IBL_GEOMETRY_SMITH] = "smith",
                                          [IBL_GEOMETRY_SCHLICK_IBL] =
                                              "schlick-ibl",
                                          NULL};
const char *const ibl_primaries_names[] = {[IBL_PRIMARIES_KEEP] = "keep",
                                           [IBL_PRIMARIES_REC709] = "rec709",
                                           [IBL_PRIMARIES_ACESCG] = "acescg",
                                           [IBL_PRIMARIES_REC2020] = "rec2020",
                                           NULL};
const char *const ibl_transfer_names[] = {[IBL_TRANSFER_FILE] = "file",
                                          [IBL_TRANSFER_LINEAR] = "linear",
                                          [IBL_TRANSFER_SRGB] = "srgb",
                                          NULL};
const char *const ibl_lut_stems[] = {[IBL_GEOMETRY_SMITH] = "brdf_lut",
                                     [IBL_GEOMETRY_SCHLICK_IBL] =
                                         "brdf_lut_schlick-ibl",
                                     NULL};
const char *const ibl_table_stems[] = {"brdf_lut", "brdf_lut_multiscatter",
                                       "brdf_lut_charlie", NULL};

const char *const ibl_input_names[] = {[IBL_INPUT_AUTO] = "auto",
                                       [IBL_INPUT_EQUIRECT] = "equirect",
                                       [IBL_INPUT_CUBE] = "cube",
                                       [IBL_INPUT_FACES] = "faces",
                                       [IBL_INPUT_HCROSS] = "hcross",
                                       [IBL_INPUT_VCROSS] = "vcross",
                                       [IBL_INPUT_HSTRIP] = "hstrip",
                                       [IBL_INPUT_VSTRIP] = "vstrip",
                                       [IBL_INPUT_OCTAHEDRAL] = "octahedral",
                                       NULL};
