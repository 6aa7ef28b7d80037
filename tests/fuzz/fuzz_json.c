/* SPDX-License-Identifier: MIT */
/* Files of JSON: sets of probes, grids, indices and sidecars, each as the
 * programs read it. */

#include "cli/common_options.h"
#include "cli/probes.h"
#include "fuzz.h"
#include "view/baked_set.h"
#include "view/gl.h"
#include "view/room.h"
#include <ibl/set.h>

static void save_texture(const char *name, ibl_pixel pixel, int levels,
                         int faces)
{
    ibl_texture tex = fuzz_texture(pixel, 4, levels, faces);
    void *bytes;
    size_t size;

    FUZZ_NEED(
        !ibl_texture_encode(fuzz_ctx, &tex, IBL_CONTAINER_KTX2, &bytes, &size));
    fuzz_save(name, bytes, size);
    ibl_bytes_free(bytes);
    ibl_texture_free(&tex);
}

/* In place of OpenGL (--wrap). */
GLuint __wrap_view_upload(const ibl_texture *tex, bool filtered,
                          const char *path);
GLuint __wrap_view_upload(const ibl_texture *tex, bool filtered,
                          const char *path)
{
    (void)filtered;
    FUZZ_NEED(tex->data && *path);
    return 1;
}

static void bind(GLenum target, GLuint texture)
{
    (void)target;
    (void)texture;
}

static void delete (GLsizei count, const GLuint *textures)
{
    (void)count;
    (void)textures;
}

/* A bake, for sidecars, and a set of probes of one layer. */
void fuzz_begin(void)
{
    gl.BindTexture = bind;
    gl.DeleteTextures = delete;
    save_texture("env_specular.ktx2", IBL_PIXEL_RGBA16F, 3, IBL_FACES);
    save_texture("env_irradiance.ktx2", IBL_PIXEL_RGBA16F, 1, IBL_FACES);
    save_texture("brdf_lut.ktx2", IBL_PIXEL_RG16F, 1, 1);
    save_texture("probes_specular.ktx2", IBL_PIXEL_RGBA16F, 2, IBL_FACES);
}

static void read_set(const fuzz_input *in, ibl_console *console)
{
    ibl_probe_set set;

    fuzz_said(!ibl_probe_set_read(fuzz_save("json", in->bytes, in->size),
                                  console, &set));
    ibl_probe_set_free(&set);
}

static void read_grid(const fuzz_input *in, ibl_console *console)
{
    ibl_probes_opts opts = {.grid = 1, .count = 1};

    opts.input[0] = fuzz_save("json", in->bytes, in->size);
    fuzz_said(!ibl_probes_grid(&opts, console, fuzz_ctx));
}

static void open_set(const fuzz_input *in, ibl_console *console)
{
    ibl_set_options opts = ibl_set_options_default();
    ibl_set set;

    (void)console;
    opts.name = "env";
    fuzz_save("env.json", in->bytes, in->size);
    fuzz_said(ibl_set_open(fuzz_ctx, fuzz_path(""), &opts, &set));
    ibl_set_free(&set);
}

static void view_sidecar(const fuzz_input *in, ibl_console *console)
{
    const view_request what = {.path = fuzz_path("env_specular.ktx2")};
    baked_set set;

    (void)console;
    fuzz_save("env.json", in->bytes, in->size);
    const bool ok = view_set_open(fuzz_ctx, &what, &set);
    fuzz_said(!ok);
    if (ok)
        FUZZ_NEED(set.baked.light_count >= 0 &&
                  set.baked.light_count <= IBL_MAX_LIGHTS &&
                  set.sh_degree >= -1);
    view_set_free(&set);
}

static void view_index(const fuzz_input *in, ibl_console *console)
{
    view_probe_set *set = view_probe_set_load(
        fuzz_ctx, fuzz_save("index.json", in->bytes, in->size));

    (void)console;
    fuzz_said(!set);
    if (set)
        FUZZ_NEED((&set->maps)->count > 0);
    view_probe_set_free(set);
}

void fuzz_one(fuzz_input in)
{
    static void (*const readers[])(const fuzz_input *, ibl_console *) = {
        read_set, read_grid, open_set, view_sidecar, view_index};
    const int kind = fuzz_choice(&in, 5);
    ibl_console console;

    ibl_console_init(&console, false, false);
    readers[kind](&in, &console);
}
