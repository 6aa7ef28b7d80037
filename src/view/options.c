/* SPDX-License-Identifier: MIT */
/* Every option: name, value, default and effect. The parser and --help use
 * these tables. */
#include "view/options.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "common/names.h"
#include "common/option.h"
#include "common/path.h"
#include "view/message.h"
#include "view/picture.h"
#include "view/set_parts.h"
#include "view/sphere_grid.h"
#include "view/truth.h"

/* ---- values of their own kind ------------------------------------------ */

static bool parse_pair(int to[2], int high, const char *value)
{
    const char *end;

    return ibl_number_int(value, 1, high, &to[0], &end) && *end == 'x' &&
           ibl_number_int(end + 1, 1, high, &to[1], &end) && !*end;
}

static bool parse_picture(void *field, const char *value)
{
    const size_t length = strlen(value);

    *(const char **)field = value;
    return view_picture_is_linear(value) ||
           (length > 4 && !strcasecmp(value + length - 4, ".png"));
}

static bool parse_size(void *field, const char *value)
{
    return parse_pair(field, 16384, value);
}

static bool parse_grid(void *field, const char *value)
{
    return parse_pair(field, VIEW_MAX_GRID, value);
}

static bool parse_range(void *field, const char *value)
{
    return ibl_number_list(value, ':', 0, 1, field, 2) == 2;
}

static bool parse_texel(void *field, const char *value)
{
    return ibl_number_list(value, ',', 0, 16383, field, 2) == 2;
}

static bool parse_pan(void *field, const char *value)
{
    return ibl_number_list(value, ',', -0.5, 0.5, field, 2) == 2;
}

static bool parse_light(void *options, const char *value)
{
    view_settings *s = &((view_options *)options)->settings;
    double x[6];

    if (s->light_count == VIEW_MAX_LIGHTS ||
        ibl_number_list(value, ',', -1e6, 1e6, x, 6) != 6 || x[3] < 0 ||
        x[4] < 0 || x[5] < 0)
        return false;
    view_light *light = &s->light[s->light_count++];
    memcpy(light->position, x, sizeof light->position);
    memcpy(light->intensity, x + 3, sizeof light->intensity);
    return true;
}

static bool parse_probe_size(void *field, const char *value)
{
    const char *end;
    int size;

    if (!ibl_number_int(value, 16, 1024, &size, &end) || *end ||
        (size & (size - 1)))
        return false;
    *(int *)field = size;
    return true;
}

static bool parse_material(void *field, const char *value)
{
    for (int i = 0; i < VIEW_MATERIALS; i++)
        if (!strcmp(view_materials[i].name, value)) {
            *(int *)field = i;
            return true;
        }
    return false;
}

static bool set_reference(void *field, const char *value)
{
    (void)value;
    *(view_reflection *)field = VIEW_REFERENCE;
    return true;
}

/* ---- what is printed ---------------------------------------------------- */

static void print_materials(FILE *to)
{
    for (const view_material *m = view_materials; m->name; m++)
        fprintf(to,
                "%-12s metal F0 %.3f %.3f %.3f, else F0 %.3f and albedo %.3f "
                "%.3f %.3f; %s\n",
                m->name, m->metal[0], m->metal[1], m->metal[2],
                m->dielectric_f0, m->diffuse * m->metal[0],
                m->diffuse * m->metal[1], m->diffuse * m->metal[2], m->source);
}

static void print_version(FILE *to)
{
    fprintf(to, "iblview %s\n", IBL_VERSION);
}

/* ---- which options go together ------------------------------------------ */

/* Reports options that exclude each other. */
static bool check_pairs(const view_options *o)
{
    static const char one[] = "choose one";
    const bool sheet = o->contact_sheet, picture = o->offscreen || sheet,
               texel = o->texel[0] >= 0;
    const struct {
        bool wrong;
        const char *options, *why;
    } rules[] = {
        {sheet && o->offscreen, "--offscreen and --contact-sheet", one},
        {sheet && texel, "--texel and --contact-sheet", one},
        {sheet && o->settings.panel, "--panel and --contact-sheet", one},
        {o->offscreen && view_picture_is_linear(o->offscreen) &&
             o->settings.panel,
         "--panel", "linear pictures have none: write a .png"},
        {o->probe_set && o->settings.probes, "--probe-set and --probes", one},
        {o->quiet && o->verbose, "--quiet and --verbose", one},
        {o->quiet && o->stats, "--quiet and --stats", one},
        {o->stats && !picture && texel, "--stats",
         "no picture is drawn: add --offscreen or --contact-sheet"},
        {(o->frames || o->samples) && !picture,
         o->frames ? "--frames" : "--samples",
         "only with --offscreen or --contact-sheet"},
        {o->frames && o->samples, "--frames and --samples", one},
        {picture && o->settings.mode == VIEW_SCENE &&
             o->settings.reflection == VIEW_REFERENCE &&
             ibl_is_given(&o->given, "reflection"),
         "--reflection reference", "is of --mode spheres and model"},
        {o->settings.compare && !o->against_set &&
             o->settings.reflection == o->settings.against,
         "--compare", "a reflection with itself: choose another --against"},
    };

    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
        if (rules[i].wrong)
            return view_fail("%s: %s", rules[i].options, rules[i].why);
    return true;
}

/* Facts of what is shown, for the rules: bits of modes, and these. A window can
 * come to show everything. */
enum {
    SPHERES = 1 << VIEW_SPHERES,
    MODEL = 1 << VIEW_MODEL,
    SCENE = 1 << VIEW_SCENE,
    LEVELS = 1 << VIEW_LEVELS,
    FLAT = LEVELS | 1 << VIEW_IRRADIANCE_MAP | 1 << VIEW_TABLE,
    LIT = SPHERES | MODEL,
    TONED = 1 << VIEW_MODES, /* not in linear floats */
    COMPARES = 2 << VIEW_MODES,
    NO_SHEET = 4 << VIEW_MODES,
    REFERENCE = 8 << VIEW_MODES, /* samples of it are drawn */
    TIMED = 16 << VIEW_MODES
};

static const ibl_rule rules[] = {
    {"model", MODEL, "is shown with --mode model: leave --mode out"},
    {"grid metallic", SPHERES, "is of --mode spheres"},
    {"material roughness reference samples light compare against-set no-sky "
     "blur sky map multiscatter no-multiscatter",
     LIT, "is of --mode spheres and model"},
    {"diffuse reflection distance", LIT | SCENE,
     "is of --mode spheres, model and scene"},
    {"material", NO_SHEET | MODEL, "the sheet has all of them"},
    {"level", NO_SHEET | SPHERES, "the sheet has all of them"},
    {"tone", NO_SHEET | LIT | SCENE | LEVELS, "the sheet has all of them"},
    {"reflection reference", NO_SHEET | SPHERES | SCENE,
     "the sheet has all of them"},
    {"frames", NO_SHEET | REFERENCE | TIMED, "changes nothing in a sheet"},
    {"samples", REFERENCE, "is of the reference: add --reference"},
    {"level", LEVELS, "is of --mode levels"},
    {"layout", LEVELS | 1 << VIEW_IRRADIANCE_MAP,
     "is of --mode levels and irradiance"},
    {"zoom", FLAT, "is of --mode levels, irradiance and table"},
    {"pan", FLAT | MODEL, "is of --mode levels, irradiance, table and model"},
    {"seconds no-parallax no-blend no-walls probes probe-set probe-size "
     "probe-capture probe-limit volumes no-capture-shadows "
     "mirror-priority",
     SCENE, "is of --mode scene"},
    {"turn yaw pitch fov antialias", LIT | SCENE,
     "is of --mode spheres, model and scene"},
    {"irradiance", LIT | SCENE | 1 << VIEW_IRRADIANCE_MAP,
     "is not shown in this mode: leave it out"},
    {"lut", LIT | SCENE | 1 << VIEW_TABLE,
     "is not shown in this mode: leave it out"},
    {"frames", REFERENCE | SCENE | TIMED,
     "draws one picture again and again: add --reference or --verbose"},
    {"against split gain", COMPARES, "compares: add --compare"},
    {"ev tone false-colour", TONED, "linear floats have none: write a .png"},
    {.options = NULL}};

static unsigned facts_of(const view_options *o)
{
    const char *file = o->offscreen ? o->offscreen : o->contact_sheet;

    if (!file)
        return ~0u;
    return 1u << o->settings.mode |
           (o->stats || o->verbose ? (unsigned)TIMED : 0) |
           (view_picture_is_linear(file) ? 0 : (unsigned)TONED) |
           (o->settings.compare ? (unsigned)COMPARES : 0) |
           (o->contact_sheet ? 0 : (unsigned)NO_SHEET) |
           ((o->contact_sheet && o->settings.mode == VIEW_MODEL) ||
                    view_wants_reference(&o->settings)
                ? (unsigned)REFERENCE
                : 0);
}

static bool validate(void *options)
{
    static const int window[2] = {1280, 720}, tile[2] = {320, 240};
    view_options *o = options;
    const bool sheet = o->contact_sheet;

    if (!o->size[0])
        memcpy(o->size, sheet ? tile : window, sizeof o->size);
    if (sheet && !o->grid[0])
        o->grid[0] = 2, o->grid[1] = 4;
    if (o->against_set && !o->settings.compare)
        o->settings.compare = VIEW_SPLIT;
    if (o->against_set && o->settings.against == VIEW_REFERENCE)
        o->settings.against = o->settings.reflection;
    o->request.layer = o->settings.layer;
    if (o->grid[0]) {
        o->settings.rows = o->grid[0];
        o->settings.columns = o->grid[1];
    }
    if (o->labels && (sheet || o->offscreen))
        o->settings.border = 0.08; /* room for them around the grid */
    if (o->model && !ibl_is_given(&o->given, "mode"))
        o->settings.mode = VIEW_MODEL;
    if (!check_pairs(o) || !ibl_check_rules(&o->given, rules, facts_of(o)))
        return false;
    if (!o->request.path)
        return view_fail("nothing to show: iblview [options] PATH, see "
                         "iblview --help");
    const char *file = sheet ? o->contact_sheet : o->offscreen;
    if (file && ibl_path_same(o->request.path, file) > 0)
        return view_fail("%s: is both input and output: choose another file",
                         file);
    if (o->texel[0] >= o->size[0] || o->texel[1] >= o->size[1])
        return view_fail("--texel %g,%g: outside the picture of %dx%d",
                         o->texel[0], o->texel[1], o->size[0], o->size[1]);
    return true;
}

/* ---- the tables --------------------------------------------------------- */

#define IBL_SETTINGS view_options
#define SET(field) IBL_AT(settings.field)
#define FLAG(field) .kind = IBL_OPTION_ON, IBL_AT(field)
#define OFF(field) .kind = IBL_OPTION_OFF, SET(field)
#define PICTURE(field)                                                         \
    IBL_OTHER(field, "OUT.png", parse_picture),                                \
        .allowed = "a name that ends in .png, or in .exr for linear floats",   \
        .standard = ""
static bool parse_face_order(void *order, const char *value)
{
    return ibl_face_order_parse(value, order);
}

#define REAL(field, what, lo, hi) IBL_REAL(settings.field, what, lo, hi)
#define OTHER(field, what, function) IBL_OTHER(settings.field, what, function)

/* clang-format off */
static const ibl_option files[] = {
    {"irradiance", 0, IBL_TEXT(request.irradiance, "FILE"), .standard = "",
     .help = "the irradiance map, if it is not beside PATH"},
    {"lut", 0, IBL_TEXT(request.lut, "FILE"), .standard = "",
     .help = "the BRDF table"},
    {"input-layout", 0, IBL_CHOICE(request.layout, ibl_input_names),
     .help = "how PATH holds an environment to bake: as of iblbake; with "
             "cube, a texture is one"},
    {"face-order", 0, IBL_OTHER(request.face_order, "LIST", parse_face_order),
     .allowed = IBL_FACE_ORDER_ALLOWED, .standard = "the layout's",
     .help = "which faces those of an environment are, as of iblbake"},
    {"input-transfer", 0, IBL_CHOICE(request.transfer, ibl_transfer_names),
     .help = "the curve of an environment's integers, as of iblbake"},
    {"map", 0, IBL_TEXT(request.map, "FILE"), .standard = "",
     .help = "the map that PATH was baked from, if it is not where it was: the "
             "backdrop and the reference"},
    {"sky", 0, IBL_TEXT(request.sky, "FILE"), .standard = "",
     .help = "the cube behind the spheres, in place of the map, the skybox or "
             "level 0"},
};

static const ibl_option pictures[] = {
    {"offscreen", 0, PICTURE(offscreen),
     .help = "write a picture and open no window: needs no display"},
    {"contact-sheet", 0, PICTURE(contact_sheet),
     .help = "write a sheet of pictures the same way: of materials by turns, "
             "of levels by exposure, as suits the mode"},
    {"no-labels", 0, .kind = IBL_OPTION_OFF, IBL_AT(labels),
     .help = "leave labels, axes and legends out of pictures"},
    {"size", 0, IBL_OTHER(size, "WxH", parse_size),
     .allowed = "1x1 to 16384x16384",
     .standard = "1280x720, 320x240 in a sheet",
     .help = "size of the window, the picture or each picture of a sheet"},
    {"frames", 0, IBL_INT(frames, 1, 100000), .standard = "1",
     .help = "number of frames to draw before a picture is written; each adds "
              "16 samples to the reference"},
    {"samples", 0, IBL_INT(samples, 1, VIEW_TRUTH_SAMPLES),
     .standard = "256, without --frames",
     .help = "samples of the reference at each pixel of a picture"},
    {"texel", 0, IBL_OTHER(texel, "X,Y", parse_texel),
     .allowed = "0,0 to 16383,16383", .standard = "none",
     .help = "print texel, direction and value under that pixel of the "
              "picture"},
};

static const ibl_option shows[] = {
    {"mode", 0, IBL_CHOICE(settings.mode, view_mode_names),
     .help = "spheres, the maps themselves, a scene with a probe, or the model "
             "of --model, without which it is a ball of the material"},
    {"model", 0, IBL_TEXT(model, "FILE"),
     .allowed = "a scene of glTF 2.0: .gltf, .glb",
     .standard = "none",
     .help = "show a model by the set; implies --mode model"},
    {"layout", 0, IBL_CHOICE(settings.layout, view_layout_names),
     .help = "flat layout of a cube"},
    {"level", 0, IBL_INT(settings.level, 0, IBL_MAX_LEVELS - 1),
     .help = "level of the specular cube"},
    {"array-layer", 0, IBL_INT(settings.layer, 0, VIEW_MAX_LAYER),
     .help = "layer of an array, as iblbake probes writes it"},
    {"zoom", 0, REAL(zoom, "Z", 0.25, 10000),
     .help = "zoom of maps; 1: the whole map fits"},
    {"pan", 0, OTHER(pan, "X,Y", parse_pan), .allowed = "-0.5,-0.5 to 0.5,0.5",
     .standard = "0,0",
     .help = "the point of a map or model in the middle of the picture, from "
              "its centre, as fractions of its size to the right and down"},
};

static const ibl_option spheres[] = {
    {"material", 0, OTHER(material, "NAME", parse_material),
     .allowed = "a name that --materials lists", .standard = "gold",
     .help = "material: its metal in the upper rows, its plastic in the lower"},
    {"grid", 0, IBL_OTHER(grid, "RxC", parse_grid), .allowed = "1x1 to 16x16",
     .standard = "7x7, 2x4 in a sheet", .help = "rows and columns"},
    {"metallic", 0, OTHER(metallic, "A:B", parse_range),
     .allowed = "two numbers from 0 to 1", .standard = "0:1",
     .help = "metallic of the lowest and the highest row"},
    {"roughness", 0, OTHER(roughness, "A:B", parse_range),
     .allowed = "two numbers from 0 to 1", .standard = "0:1",
     .help = "roughness of the first and the last column"},
    {"diffuse", 0, IBL_CHOICE(settings.diffuse, view_diffuse_names),
     .help = "irradiance map, or the sidecar's spherical harmonics"},
    {"multiscatter", 0, FLAG(settings.multiscatter),
     .help = "add the energy that single scattering loses (default)"},
    {"no-multiscatter", 0, OFF(multiscatter),
     .help = "do not add it"},
    {"light", 0, .kind = IBL_OPTION_OTHER, .value = "X,Y,Z,R,G,B",
     .parse = parse_light,
     .allowed = "six numbers, colours 0 or more; up to 4 times",
     .standard = "none",
     .help = "a point light: position and intensity; spheres have radius 0.45 "
              "and stand 1 apart around 0,0,0"},
};

static const ibl_option scene[] = {
    {"seconds", 0, REAL(seconds, "T", 0, 1e6),
     .help = "time of the animation in a picture, or at its start in a window"},
    {"no-parallax", 0, OFF(parallax),
     .help = "look up reflections as if everything were infinitely far away"},
    {"no-blend", 0, OFF(blend),
     .help = "do not blend probes: a point uses only the first probe whose box "
              "it is in, by priority and size"},
    {"no-walls", 0, OFF(walls),
     .help = "weight probes by their boxes only, also where a wall hides them"},
    {"probes", 0, IBL_INT(settings.probes, 0, VIEW_MAX_LOCALS),
     .help = "local probes, captured once; they see only what does not move"},
    {"probe-set", 0, IBL_TEXT(probe_set, "INDEX"), .standard = "",
     .help = "local probes that iblbake probes baked: its index.json"},
    {"probe-size", 0, OTHER(probe_size, "N", parse_probe_size),
     .allowed = "a power of two from 16 to 1024", .standard = "256",
     .help = "edge of the faces of each probe's cube"},
    {"probe-capture", 0,
     IBL_CHOICE(settings.probe_capture, view_probe_capture_names),
     .help = "draw six faces, or two paraboloids"},
    {"probe-limit", 0, FLAG(settings.probe_limit),
     .help = "a capture ends where its probe's influence ends; farther off, "
              "other probes and the environment fill in"},
    {"mirror-priority", 0,
     IBL_INT(settings.mirror_priority, -VIEW_MAX_PRIORITY, VIEW_MAX_PRIORITY),
     .standard = "-1 with --probe-set, else 1",
     .help = "priority of the mirror's probe among local probes"},
    {"volumes", 0, FLAG(settings.volumes),
     .help = "draw the influence volumes of probes as wires, and the walls of "
              "their parallax correction"},
    {"probe-interval", 0, REAL(probe_interval, "S", 0, 3600),
     .help = "seconds between captures in a window, if something moved; 0: "
              "every frame"},
    {"probe-faces", 0, IBL_INT(settings.probe_faces, 0, 1000),
     .help = "faces of a capture that one frame in a window draws or filters; "
              "0: all"},
    {"no-capture-shadows", 0, OFF(capture_shadows),
     .help = "draw captures without the shadows of lights"},
};

static const ibl_option camera[] = {
    {"turn", 0, REAL(turn, "DEG", -3600, 3600),
     .help = "turn the environment about +Y, counter-clockwise from above"},
    {"yaw", 0, REAL(yaw, "DEG", -3600, 3600),
     .help = "turn of the camera around the spheres"},
    {"pitch", 0, REAL(pitch, "DEG", -89, 89),
     .help = "height angle of the camera; positive: from above"},
    {"distance", 0, REAL(distance, "D", 0, 1000),
     .help = "distance of the camera from the middle of the grid, or from the "
             "model, which is scaled into a sphere of radius 1; 0: far enough "
             "to see all of it"},
    {"fov", 0, REAL(fov, "DEG", 1, 120), .help = "vertical field of view"},
    {"no-sky", 0, OFF(sky),
     .help = "black behind the spheres"},
    {"blur", 0, REAL(blur, "R", 0, 1),
     .help = "show the environment behind the spheres as a surface of that "
             "roughness would reflect it"},
    {"antialias", 0, IBL_INT(settings.antialias, 1, VIEW_MAX_ANTIALIAS),
     .help = "draw N x N places of each pixel, and their mean; 1: only its "
             "centre"},
};

static const ibl_option display[] = {
    {"ev", 0, REAL(ev, "EV", -30, 30), .help = "exposure in stops"},
    {"tone", 0,
     IBL_CHOICE(settings.tone, view_tone_names), .help = "tone curve"},
    {"panel", 0, FLAG(settings.panel),
     .help = "draw the panel of controls over the picture"},
    {"false-colour", 0, FLAG(settings.false_colour),
     .help = "luminance in false colours instead"},
};

static const ibl_option reflection[] = {
    {"reflection", 0, IBL_CHOICE(settings.reflection, view_reflection_names),
     .help = "look up lobes by the split sum, by formulas, or by the table, in "
             "one to four taps; or the integral itself"},
    {"reference", 0, OTHER(reflection, NULL, set_reference),
     .help = "the same as --reflection reference"},
    {"compare", 0, IBL_CHOICE(settings.compare, view_compare_names),
     .help = "show two reflections side by side, or their difference; pictures "
             "print the error of each sphere"},
    {"against", 0, IBL_CHOICE(settings.against, view_reflection_names),
     .help = "the other reflection"},
    {"against-set", 0, IBL_TEXT(against_set, "PATH"), .standard = "",
     .help = "draw the other side by this set or map, by --reflection unless "
             "--against says otherwise"},
    {"split", 0, REAL(split, "X", 0, 1),
     .help = "where the other begins, as a fraction of the width of each "
             "sphere's place, or of the picture"},
    {"gain", 0, REAL(gain, "G", 1e-3, 1e6), .help = "factor of the difference"},
};

static const ibl_option running[] = {
    {"quiet", 'q', FLAG(quiet), .help = "print only errors"},
    {"verbose", 'v', FLAG(verbose),
     .help = "print the loaded files, the renderer and the frame rate"},
    {"stats", 0, FLAG(stats),
     .help = "print times for programs to read: a line for each update of the "
              "scene's probe"},
    {"keys", 0, .kind = IBL_OPTION_PRINT, .print = view_print_keys,
     .help = "print the keys of the window"},
    {"materials", 0, .kind = IBL_OPTION_PRINT, .print = print_materials,
     .help = "print the materials and the sources of their numbers"},
    {"help", 'h', .kind = IBL_OPTION_HELP, .help = "print this text"},
    {"version", 0, .kind = IBL_OPTION_PRINT, .print = print_version,
     .help = "print the version"},
};
/* clang-format on */

static const ibl_gone gone[] = {
    {"probe-filter", "OpenGL filters captures: leave it out"},
    {"save-probes", "iblbake probes takes captures of engines"},
    {.words = NULL}};

static const ibl_section *const sections[] = {
    IBL_SECTION("Files", files),         IBL_SECTION("Pictures", pictures),
    IBL_SECTION("What is shown", shows), IBL_SECTION("Spheres", spheres),
    IBL_SECTION("Scene", scene),         IBL_SECTION("Camera", camera),
    IBL_SECTION("Display", display),     IBL_SECTION("Reflection", reflection),
    IBL_SECTION("Running", running),     NULL};

static void set_defaults(void *options)
{
    *(view_options *)options = (view_options){
        .labels = true, .texel = {-1, -1}, .settings = view_settings_default()};
    ((view_options *)options)->settings.antialias = VIEW_DEFAULT_ANTIALIAS;
}

static bool take(void *options, const char *word)
{
    view_request *r = &((view_options *)options)->request;

    if (r->path)
        return view_fail("%s: more than one thing to show: %s is already given",
                         word, r->path);
    if (!*word)
        return view_fail("the name of what to show is empty: give a file or a "
                         "directory");
    r->path = word;
    return true;
}

static const ibl_command show = {
    .usage = "[options] PATH",
    .intro = "Shows what materials look like under a baked environment, or the "
             "maps\n"
             "themselves. PATH is a directory that iblbake has written, a "
             "specular cube\n"
             "(KTX2, KTX, DDS), or an environment (.hdr, .exr), which is baked "
             "first.\n"
             "In the window ? lists the keys.\n",
    .statuses = "0 done, 1 failed, 2 wrong usage",
    .sections = sections,
    .gone = gone,
    .settings_size = sizeof(view_options),
    .given = offsetof(view_options, given),
    .defaults = set_defaults,
    .take = take,
    .validate = validate,
};
static const ibl_command *const commands[] = {&show, NULL};
const ibl_program ibl_this_program = {"iblview", commands};

bool view_options_parse(char **words, view_options *o, int *status)
{
    return ibl_command_line(&show, words, o, status);
}

/* ---- what is shown ------------------------------------------------------ */

bool view_options_may(const view_options *o)
{
    const view_request *r = &o->request;
    const char *option = r->irradiance ? "--irradiance"
                         : r->lut      ? "--lut"
                         : r->sky      ? "--sky"
                         : r->map      ? "--map"
                         : r->layer    ? "--array-layer"
                                       : NULL;
    const bool map = view_is_map(r->path, r->layout);

    if (view_is_model(r->path))
        return view_fail("%s: is a model: name the set or the map that lights "
                         "it, and this with --model",
                         r->path);
    if (strcmp(r->path, "-") != 0 && !map &&
        view_file_stamp_of(r->path, NULL).size < 0)
        return view_fail("%s: cannot be opened: %s", r->path, strerror(errno));
    if (!map && (r->transfer || r->face_order[0] + r->face_order[1]))
        return view_fail("%s: is a baked set: %s is for an environment, which "
                         "a texture is with --input-layout cube",
                         r->path,
                         r->transfer ? "--input-transfer" : "--face-order");
    return !option || !map ||
           view_fail("%s: %s is baked here, with all that belongs to it: the "
                     "option is for baked files",
                     option, r->path);
}

bool view_options_suit(const view_options *o, const baked_set *set)
{
    const int levels = set->texture[VIEW_SPECULAR].levels;

    if (o->settings.level >= levels)
        return view_fail("--level %d: %s has levels 0 to %d", o->settings.level,
                         set->name, levels - 1);
    if (o->settings.diffuse == VIEW_DIFFUSE_SH && set->sh_degree < 0)
        return view_fail("--diffuse sh: %s has no spherical harmonics, which "
                         "are in a sidecar of iblbake: use the map",
                         set->name);
    const view_reflection asked =
        view_needs_lobes(o->settings.reflection) || !view_compares(&o->settings)
            ? o->settings.reflection
            : o->settings.against;
    if (!set->texture[VIEW_LOBES].data && view_needs_lobes(asked))
        return view_fail(
            "--reflection %s: %s has no table of lobes, which "
            "iblbake --lobe-table writes: choose split, bent or fit",
            view_reflection_names[asked], set->name);
    return true;
}
