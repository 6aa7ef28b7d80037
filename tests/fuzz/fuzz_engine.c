/* SPDX-License-Identifier: MIT */
/* Files of engines: .env, .gltf with its images beside it, atlas. */
#include <stdio.h>

#include "engine/engine.h"
#include "fuzz.h"

/* The images that seeds of .gltf name: six of a level of 4 texels, six of 2,
 * six of 1. */
void fuzz_begin(void)
{
    static unsigned char rgba[4 * 4 * 4] = {9, 200, 40, 255, 3};

    for (int i = 0; i < 3 * IBL_FACES; i++) {
        ibl_blob png = {0};
        char *name = ibl_engine_face_name("s", i);
        FUZZ_NEED(name && ibl_png_encode(rgba, 4, 4 >> i / IBL_FACES,
                                         4 >> i / IBL_FACES, NULL, &png));
        fuzz_save(name, png.bytes, png.size);
        ibl_blob_free(&png);
        free(name);
    }
}

void fuzz_one(fuzz_input in)
{
    ibl_texture tex = {0};

    const ibl_status status =
        ibl_engine_read(fuzz_ctx, fuzz_save("s.gltf", in.bytes, in.size),
                        (int)(in.size % 3) - 1, &tex);
    fuzz_said(status);
    if (!status)
        FUZZ_NEED(tex.data && tex.levels >= 1 && tex.width >= 1);
    ibl_texture_free(&tex);
}
