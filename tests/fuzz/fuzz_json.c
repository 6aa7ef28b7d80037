/* SPDX-License-Identifier: MIT */
/* Files of JSON: sets of probes, grids, indices and sidecars, each as the
 * programs read it. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli/common_options.h"
#include "cli/probes.h"
#include "fuzz.h"
#include "view/baked_set.h"
#include "view/gl.h"
#include "view/probe_set.h"
#include <ibl/set.h>

/* A set whose index is read. */
static const char set_json[] =
    "{\"version\": 1, \"probes\": [{\"name\": \"a\", \"position\": [0, 0, 0], "
    "\"capture\": {\"equirect\": \"a.hdr\"}, \"influence\": {\"box\": "
    "{\"centre\": [0, 0, 0], \"half\": [1, 1, 1]}}}]}";

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

/* libFuzzer needs the signals (--wrap). */
void __wrap_ibl_signals_catch(void);
void __wrap_ibl_signals_catch(void)
{
}

/* In place of OpenGL (--wrap). */
bool __wrap_view_gl_has_cube_arrays(void);
bool __wrap_view_gl_has_cube_arrays(void)
{
    return true;
}

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
    fuzz_save("set", set_json, strlen(set_json));
}

/* Any index and file has the hash that an index says, if that is 0 (--wrap). */
void __wrap_ibl_hash_bytes(const void *bytes, size_t size,
                           char hash[IBL_HASH_SIZE]);
void __wrap_ibl_hash_bytes(const void *bytes, size_t size,
                           char hash[IBL_HASH_SIZE])
{
    (void)bytes;
    (void)size;
    strcpy(hash, "0");
}

bool __wrap_ibl_hash_file(const char *path, char hash[IBL_HASH_SIZE]);
bool __wrap_ibl_hash_file(const char *path, char hash[IBL_HASH_SIZE])
{
    strcpy(hash, "0");
    return !access(path, F_OK);
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
    ibl_probes_opts opts = {.grid = 1};

    (void)console;
    opts.input = fuzz_save("json", in->bytes, in->size);
    fuzz_said(ibl_probes_grid(&opts));
}

/* The old index of a set that is to be baked. What is damaged is ignored. */
static void read_old_index(const fuzz_input *in, ibl_console *console)
{
    ibl_probes_opts opts = {.output = fuzz_path("")};
    ibl_probes_bake p = {.opts = &opts, .console = console, .held = -1};

    FUZZ_NEED(ibl_probe_set_read(fuzz_path("set"), console, &p.set));
    p.file[IBL_PROBES_INDEX].path =
        (char *)fuzz_save("index.json", in->bytes, in->size);
    fuzz_said(!ibl_probes_plan(&p));
    for (int i = 0; i < IBL_PROBES_FILES; i++)
        free(p.file[i].old);
    ibl_probe_set_free(&p.set);
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
        FUZZ_NEED(set.light_count >= 0 && set.light_count <= IBL_MAX_LIGHTS &&
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
        FUZZ_NEED(view_probe_set_locals(set)->count > 0);
    view_probe_set_free(set);
}

static void merge_shard(const fuzz_input *in, ibl_console *console)
{
    char *words[] = {(char *)fuzz_path(""), "-o", (char *)fuzz_path("merged"),
                     NULL};
    void *settings = malloc(ibl_merge_command.settings_size);
    int status;

    (void)console;
    fuzz_save("index.json", in->bytes, in->size);
    FUZZ_NEED(settings);
    FUZZ_NEED(ibl_command_line(&ibl_merge_command, words, settings, &status));
    fuzz_said(ibl_merge_command.run(settings));
    free(settings);
}

void fuzz_one(fuzz_input in)
{
    static void (*const readers[])(const fuzz_input *, ibl_console *) = {
        read_set,     read_grid,  read_old_index, open_set,
        view_sidecar, view_index, merge_shard};
    const int kind = fuzz_choice(&in, 7);
    ibl_console console;

    ibl_console_init(&console, false, false);
    readers[kind](&in, &console);
}
