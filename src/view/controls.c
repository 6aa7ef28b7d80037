/* SPDX-License-Identifier: MIT */
#include "view/controls.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "common/names.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/sphere_grid.h"
#include "view/truth.h"

/* ---- values of their own kind ------------------------------------------ */

static bool parse_edges(int to[2], const char *value, int most)
{
    const char *end;

    return ibl_number_int(value, 1, most, &to[0], &end) && *end == 'x' &&
           ibl_number_int(end + 1, 1, most, &to[1], &end) && !*end;
}

static bool parse_grid(void *field, const char *value)
{
    return parse_edges(field, value, VIEW_MAX_GRID);
}

static bool parse_size(void *field, const char *value)
{
    return parse_edges(field, value, 16384);
}

static bool parse_picture(void *field, const char *value)
{
    const size_t length = strlen(value);

    *(const char **)field = value;
    return view_picture_is_linear(value) ||
           (length > 4 && !strcasecmp(value + length - 4, ".png"));
}

static bool parse_range(void *field, const char *value)
{
    return ibl_number_list(value, ':', 0, 1, field, 2) == 2;
}

static bool parse_pan(void *field, const char *value)
{
    return ibl_number_list(value, ',', -0.5, 0.5, field, 2) == 2;
}

static bool parse_colour(void *field, const char *value)
{
    return ibl_number_list(value, ',', 0, 1e6, field, 3) == 3;
}

static void print_version(FILE *to)
{
    fprintf(to, "iblview %s\n", IBL_VERSION);
}

/* ---- the table ---------------------------------------------------------- */

/* Where a row changes something: in one of these modes, */
enum {
    SPHERES = 1 << VIEW_SPHERES,
    MODEL = 1 << VIEW_MODEL,
    SCENE = 1 << VIEW_SCENE,
    LEVELS = 1 << VIEW_LEVELS,
    IRRADIANCE = 1 << VIEW_IRRADIANCE_MAP,
    TABLE = 1 << VIEW_TABLE,
    ALL = (1 << VIEW_MODES) - 1,
    LIT = SPHERES | MODEL,
    FLAT = ALL & ~(LIT | SCENE),
    /* and only if all of these facts hold, as view_control_why says. */
    NEED_TONE = 1 << VIEW_MODES,
    NEED_CURVE = NEED_TONE << 1,
    NEED_MATERIAL = NEED_TONE << 2,
    NEED_ORBIT = NEED_TONE << 3,
    NEED_PROBES = NEED_TONE << 4,
    NEED_OWN = NEED_TONE << 5,
    NEED_PLAIN = NEED_TONE << 6,
    NEED_REFERENCE = NEED_TONE << 7,
    NEED_WINDOW = NEED_TONE << 8,
    NEED_PICTURE = NEED_TONE << 9,
    NEED_ONE = NEED_TONE << 10,
    NEED_NO_SHEET = NEED_TONE << 11
};

#define NAMES(...) ((const char *const[]){__VA_ARGS__, NULL})
#define IBL_SETTINGS view_options
#define ON(field) .kind = IBL_OPTION_ON, IBL_AT(field)
#define OFF(field) .kind = IBL_OPTION_OFF, IBL_AT(field)
#define PRINT(function) .kind = IBL_OPTION_PRINT, .print = (function)
#define PICTURE(field)                                                         \
    IBL_OTHER(field, "OUT.png", parse_picture),                                \
        .allowed = "a name that ends in .png, or in .exr for linear floats",   \
        .standard = ""

/* clang-format off */
static const view_control files[] = {
    {{"model", 0, IBL_TEXT(model, "FILE"),
      .allowed = "a scene of glTF 2.0: .gltf, .glb",
      .standard = "none",
      .help = "show a model by the set; implies --mode model, but in --mode "
              "scene it stands in the room"},
     .where = MODEL | SCENE},
    {{"probe-set", 0, IBL_TEXT(probe_set, "INDEX"), .standard = "",
      .help = "local probes that iblbake probes baked: its index.json"},
     .where = SCENE},
    {{"irradiance", 0, IBL_TEXT(request.irradiance, "FILE"), .standard = "",
      .help = "the irradiance map, if it is not beside PATH"},
     .where = LIT | SCENE | IRRADIANCE},
    {{"lut", 0, IBL_TEXT(request.lut, "FILE"), .standard = "",
      .help = "the BRDF table"},
     .where = LIT | SCENE | TABLE},
    {{"map", 0, IBL_TEXT(request.map, "FILE"), .standard = "",
      .help = "the map that PATH was baked from, if it is not where it was: "
              "the backdrop and the reference"},
     .where = ALL},
    {{"sky", 0, IBL_TEXT(request.sky, "FILE"), .standard = "",
      .help = "the cube behind the spheres, in place of the map, the skybox "
              "or level 0"},
     .where = LIT | SCENE},
};

static const view_control pictures[] = {
    {{"offscreen", 0, PICTURE(offscreen),
      .help = "write a picture and open no window: needs no display"},
     .where = ALL},
    {{"contact-sheet", 0, PICTURE(contact_sheet),
      .help = "write a sheet of pictures the same way: of spheres materials by "
              "turns, of levels all by exposure"},
     .where = SPHERES | LEVELS},
    {{"turntable", 0, IBL_INT(turntable, 2, 9999), .standard = "none",
      .help = "write so many pictures of a turn of the camera, OUT-001.png "
              "and so on"},
     .where = LIT | SCENE | NEED_ONE},
    {{"no-labels", 0, OFF(labels),
      .help = "leave labels, axes and legends out of pictures"},
     .where = ALL | NEED_TONE},
    {{"panel", 0, ON(panel),
      .help = "draw the panel of controls beside the picture"},
     .where = ALL | NEED_TONE | NEED_ONE},
    {{"size", 0, IBL_OTHER(size, "WxH", parse_size),
      .allowed = "1x1 to 16384x16384",
      .standard = "1280x720, 320x240 in a sheet",
      .help = "size of the window, the picture or each picture of a sheet"},
     .where = ALL},
    {{"samples", 0, IBL_INT(samples, 1, VIEW_TRUTH_SAMPLES),
      .help = "samples of the reference at each pixel of a picture"},
     .where = LIT | NEED_PICTURE | NEED_REFERENCE},
    {{"mean-exposure", 0, ON(mean_exposure),
      .help = "expose the picture so that its mean luminance is middle grey"},
     .where = ALL | NEED_ONE},
};

static const view_control compare[] = {
    {{"compare", 0, IBL_CHOICE(settings.compare,
                 NAMES("no", "split", "difference")),
      .help = "show two states side by side, or their difference; pictures "
              "print the error of each sphere"},
     .label = "compare", .where = ALL, .key = 'f', .back = 'F'},
    {{"split", 0, IBL_REAL(settings.split, "X", 0, 1),
      .help = "where the other begins, as a fraction of the width of each "
              "sphere's place, or of the picture"},
     .label = "split", .where = ALL, .of = "compare", .is = VIEW_SPLIT,
     .key = 's', .back = 'S',
     .step = 0.05},
    {{"gain", 0, IBL_REAL(settings.gain, "G", 1e-3, 1e6),
      .help = "factor of the difference"},
     .label = "gain", .where = ALL | NEED_TONE, .of = "compare",
     .is = VIEW_DIFFERENCE, .key = 'g', .back = 'G', .slide = {0.1, 1000}},
    {{"against", 0, IBL_TEXT(against, "OPTIONS"), .standard = "reference",
      .help = "what the other side has otherwise, as \"--diffuse sh\" or only "
              "the name of a reflection"},
     .where = ALL},
    {{"against-set", 0, IBL_TEXT(against_set, "PATH"), .standard = "",
      .help = "draw the other side by this set or map"},
     .where = ALL},
};

static const view_control running[] = {
    {{"quiet", 'q', ON(quiet), .help = "print only errors"},
     .where = ALL},
    {{"stats", 0, ON(stats),
      .help = "print the times of frames, and what draws: each second or, of "
              "a picture, after it"},
     .where = ALL},
    {{"keys", 0, PRINT(view_print_keys),
      .help = "print the keys of the window"},
     .where = ALL},
    {{"help", 'h', .kind = IBL_OPTION_HELP, .help = "print this text"},
     .where = ALL},
    {{"version", 0, PRINT(print_version), .help = "print the version"},
     .where = ALL},
};

#undef IBL_SETTINGS
#define IBL_SETTINGS view_settings
#define NAMED(code) VIEW_KEY(GLFW_KEY_##code)

static const view_control shown[] = {
    {{"mode", 0, IBL_CHOICE(mode, view_mode_names),
      .help = "spheres, the maps themselves, a room with probes, the model of "
              "--model, or the environment at its own resolution"},
     .label = "mode", .where = ALL, .key = 'm', .back = 'M'},
    {{"layout", 0, IBL_CHOICE(layout, view_layout_names),
      .help = "flat layout of a cube"},
     .label = "layout", .where = LEVELS | IRRADIANCE, .key = 'l', .back = 'L'},
    {{"level", 0, IBL_INT(level, 0, IBL_MAX_LEVELS - 1),
      .help = "level of the specular cube"},
     .label = "level", .where = LEVELS | NEED_NO_SHEET, .key = ']',
     .back = '['},
    {{"array-layer", 0, IBL_INT(layer, 0, VIEW_MAX_LAYER),
      .help = "layer of an array, as iblbake probes writes it"},
     .label = "layer of an array", .where = ALL & ~(SCENE | TABLE),
     .key = 'a', .back = 'A'},
    {{"channel", 0, IBL_CHOICE(channel, view_channel_names),
      .help = "all channels of a map, one as grey, or the luminance"},
     .label = "channel", .where = FLAT, .key = 'h', .back = 'H'},
    {{"filter", 0, ON(filter), .help = "interpolate the texels of maps"},
     .label = "interpolate texels", .where = FLAT & ~TABLE, .key = 'j'},
    {{"zoom", 0, IBL_REAL(zoom, "Z", 0.25, 10000),
      .help = "zoom of maps; 1: the whole map fits"},
     .label = "zoom", .where = FLAT, .slide = {0.25, 64}},
    {{"pan", 0, IBL_OTHER(pan, "X,Y", parse_pan),
      .allowed = "-0.5,-0.5 to 0.5,0.5", .standard = "0,0", .low = -0.5,
      .high = 0.5,
      .help = "the point of a map or model in the middle of the picture, from "
              "its centre, as fractions of its size to the right and down"},
     .label = "pan", .where = FLAT | MODEL, .shape = VIEW_TWO_REALS},
};

static const view_control materials[] = {
    {{"material", 0, IBL_CHOICE(material, view_material_names),
      .help = "material of spheres: its metal in the upper rows, its plastic "
              "in the lower"},
     .label = "material",
     .where = LIT | NEED_MATERIAL | NEED_NO_SHEET,
     .key = 'n', .back = 'N'},
    {{"grid", 0, IBL_OTHER(rows, "RxC", parse_grid), .low = 1,
      .high = VIEW_MAX_GRID, .allowed = "1x1 to 16x16",
      .standard = "7x7, 2x4 in a sheet", .help = "rows and columns"},
     .label = "rows, columns", .where = SPHERES, .shape = VIEW_TWO_INTS},
    {{"metallic", 0, IBL_OTHER(metallic, "A:B", parse_range), .high = 1,
      .allowed = "two numbers from 0 to 1", .standard = "0:1",
      .help = "metallic of the lowest and the highest row"},
     .label = "metallic", .where = LIT | NEED_MATERIAL,
     .shape = VIEW_TWO_REALS},
    {{"roughness", 0, IBL_OTHER(roughness, "A:B", parse_range), .high = 1,
      .allowed = "two numbers from 0 to 1", .standard = "0:1",
      .help = "roughness of the first and the last column"},
     .label = "roughness", .where = LIT | NEED_MATERIAL,
     .shape = VIEW_TWO_REALS},
    {{"override", 0, IBL_CHOICE(override,
                 NAMES("no", "clay", "chrome", "material")),
      .help = "materials of a model: its own, clay, chrome, or --material "
              "with the upper end of --metallic and the middle of --roughness"},
     .label = "model's materials", .where = MODEL,
     .key = 'o', .back = 'O'},
    {{"ground", 0, ON(ground),
      .help = "a ground below the model, with the shadow of the main light"},
     .label = "ground", .where = MODEL, .key = 'u'},
};

static const view_control light[] = {
    {{"turn", 0, IBL_REAL(turn, "DEG", -3600, 3600),
      .help = "turn the environment about +Y, counter-clockwise from above"},
     .label = "turn", .where = LIT | SCENE, .key = '.', .back = ',', .step = 5,
     .slide = {-180, 180}},
    {{"lights", 0, IBL_INT(light_count, 0, VIEW_MAX_LIGHTS),
      .help = "point lights before the corners of the grid, as in tutorials"},
     .label = "point lights", .where = LIT, .key = 'i', .back = 'I'},
    {{"parts", 0, IBL_CHOICE(parts,
                 NAMES("all", "ambient", "direct", "diffuse", "specular")),
      .help = "what of the light is drawn: all, a constant ambient light in "
              "place of the maps, only point lights and the set's, only the "
              "diffuse or only the specular part of the maps"},
     .label = "parts of the light", .where = LIT, .key = 'k',
     .back = 'K'},
    {{"diffuse", 0, IBL_CHOICE(diffuse, view_diffuse_names),
      .help = "diffuse light: the irradiance map, spherical harmonics of the "
              "sidecar, the last specular level, or what the engine takes "
              "that the set is for"},
     .label = "diffuse", .where = LIT | SCENE | IRRADIANCE,
     .key = 'd', .back = 'D'},
    {{"no-multiscatter", 0, OFF(multiscatter),
      .help = "without the energy that single scattering loses"},
     .label = "multiple scattering", .where = LIT | NEED_PLAIN,
     .key = 'c'},
    {{"rough-fresnel", 0, ON(rough_fresnel),
      .help = "the Fresnel of roughness that tutorials take for the diffuse "
              "part"},
     .label = "Fresnel of roughness", .where = LIT},
};

static const view_control reflection[] = {
    {{"reflection", 0, IBL_CHOICE(reflection, view_reflection_names),
      .help = "look up lobes by the split sum, by formulas, or by the table, "
              "in one to four taps; or the integral itself"},
     .label = "reflection", .where = LIT | SCENE, .key = 'r',
     .back = 'R'},
    {{"seams", 0, ON(seams),
      .help = "look cubes up face by face, as OpenGL does without "
              "GL_TEXTURE_CUBE_MAP_SEAMLESS"},
     .label = "seams of cubes", .where = LIT | SCENE},
};

static const view_control probes[] = {
    {{"seconds", 0, IBL_REAL(seconds, "T", 0, 1e6),
      .help = "time of the motion in a picture, or at its start in a window"},
     .where = SCENE},
    {{"parallax", 0, IBL_CHOICE(parallax, NAMES("none", "box", "sphere")),
      .help = "correct reflections for the walls of the room: not, by each "
              "probe's box, or by a sphere in its place"},
     .label = "parallax", .where = SCENE, .key = 'x', .back = 'X'},
    {{"probes", 0, IBL_INT(probes, 0, VIEW_MAX_LOCALS),
      .help = "local probes, captured once; they see only what does not move"},
     .label = "local probes", .where = SCENE | NEED_OWN,
     .key = '}', .back = '{'},
    {{"probe-choice", 0, IBL_CHOICE(probe_choice,
                 NAMES("blend", "nearest", "nearest-k")),
      .help = "which local probes light a point: all whose boxes contain it, "
              "blended by weight and priority, the nearest, or a few of these"},
     .label = "probes at a point", .where = SCENE | NEED_PROBES,
     .key = 'z', .back = 'Z'},
    {{"nearest", 0, IBL_INT(nearest, 1, VIEW_MAX_NEAREST),
      .help = "how many of the nearest"},
     .label = "nearest probes",
     .where = SCENE | NEED_PROBES, .of = "probe-choice",
     .is = VIEW_PROBES_NEAREST_K},
    {{"weights", 0, ON(weights),
      .help = "show the weights of probes as colours, one for each probe"},
     .label = "weights as colours", .where = SCENE, .key = 'w'},
    {{"probe-limit", 0, ON(probe_limit),
      .help = "a capture ends where its probe's influence ends; farther off, "
              "other probes and the environment fill in"},
     .label = "captures end", .where = SCENE | NEED_PROBES},
    {{"probe-size", 0, IBL_CHOICE(probe_size,
                  NAMES("16", "32", "64", "128", "256", "512", "1024")),
      .help = "edge of the faces of each probe's cube"},
     .label = "size of faces", .where = SCENE},
    {{"probe-capture", 0,
      IBL_CHOICE(probe_capture, NAMES("faces", "paraboloids")),
      .help = "draw six faces, or two paraboloids"},
     .label = "captured as", .where = SCENE},
    {{"probe-interval", 0, IBL_REAL(probe_interval, "S", 0, 3600),
      .help = "seconds between captures in a window, if something moved; 0: "
              "every frame"},
     .label = "seconds between", .where = SCENE | NEED_WINDOW,
     .slide = {0, 2}},
};

static const view_control camera[] = {
    {{"yaw", 0, IBL_REAL(yaw, "DEG", -3600, 3600),
      .help = "turn of the camera around the spheres"},
     .label = "yaw", .where = LIT | SCENE | NEED_ORBIT,
     .slide = {-180, 180}},
    {{"pitch", 0, IBL_REAL(pitch, "DEG", -89, 89),
      .help = "height angle of the camera; positive: from above"},
     .label = "pitch", .where = LIT | SCENE | NEED_ORBIT},
    {{"distance", 0, IBL_REAL(distance, "D", 0, 1000),
      .help = "distance of the camera from the middle of the grid, or from the "
              "model, which is scaled into a sphere of radius 1; 0: far enough "
              "to see all of it"},
     .label = "distance", .where = LIT | SCENE | NEED_ORBIT,
     .slide = {0, 30}},
    {{"fov", 0, IBL_REAL(fov, "DEG", 1, 120), .help = "vertical field of view"},
     .label = "field of view", .where = LIT | SCENE | NEED_ORBIT},
    {{"file-camera", 0, IBL_INT(file_camera, 0, 1000),
      .help = "camera of the model's file, counted from 1; 0: none"},
     .label = "camera of the file", .where = MODEL},
    {{"antialias", 0, IBL_INT(antialias, 1, VIEW_MAX_ANTIALIAS),
      .help = "draw N x N places of each pixel, and their mean; 1: only its "
              "centre"},
     .label = "antialiasing", .where = LIT | SCENE},
};

static const view_control display[] = {
    {{"background", 0, IBL_CHOICE(background,
                 NAMES("map", "blur", "level", "colour", "transparent")),
      .help = "what is behind spheres and models: the map, the same blurred, a "
              "level, a colour, or nothing: PNG pictures then have alpha"},
     .label = "background", .where = LIT, .key = 'b', .back = 'B'},
    {{"blur", 0, IBL_REAL(blur, "R", 0, 1),
      .help = "roughness by which the background is blurred"},
     .label = "its roughness", .where = LIT, .of = "background",
     .is = VIEW_BACKGROUND_BLUR},
    {{"background-level", 0,
      IBL_INT(background_level, 0, IBL_MAX_LEVELS - 1),
      .help = "level of the specular cube that is the background"},
     .label = "its level", .where = LIT, .of = "background",
     .is = VIEW_BACKGROUND_LEVEL},
    {{"colour", 0, IBL_OTHER(background_colour, "R,G,B", parse_colour),
      .high = 1, .allowed = "three linear numbers, 0 or more",
      .standard = "0,0,0", .help = "colour of the background"},
     .label = "its colour", .where = LIT, .of = "background",
     .is = VIEW_BACKGROUND_COLOUR, .shape = VIEW_COLOUR3},
    {{"ev", 0, IBL_REAL(ev, "EV", -30, 30), .help = "exposure in stops"},
     .label = "exposure", .where = ALL | NEED_TONE, .key = 'e',
     .back = 'E', .step = 0.25, .slide = {-8, 8}},
    {{"tone", 0, IBL_CHOICE(tone,
                 NAMES("linear", "reinhard", "aces", "neutral", "agx")),
      .help = "tone curve"},
     .label = "tone", .where = ALL | NEED_TONE | NEED_CURVE,
     .key = 't', .back = 'T'},
    {{"false-colour", 0, ON(false_colour),
      .help = "luminance in false colours instead"},
     .label = "false colours", .where = ALL | NEED_TONE, .key = 'v'},
};
/* clang-format on */

const ibl_section *const view_control_sections[] = {
    IBL_SECTION("Files", files),         IBL_SECTION("Pictures", pictures),
    IBL_SECTION("What is shown", shown), IBL_SECTION("Materials", materials),
    IBL_SECTION("Light", light),         IBL_SECTION("Reflection", reflection),
    IBL_SECTION("Comparison", compare),  IBL_SECTION("Scene", probes),
    IBL_SECTION("Camera", camera),       IBL_SECTION("Display", display),
    IBL_SECTION("Running", running),     NULL};

static const ibl_command all = {.sections = view_control_sections};

const view_control *view_control_at(int i)
{
    return (const view_control *)ibl_option_at(&all, i);
}

const view_control *view_control_of(const view_control *c)
{
    return !c->of ? NULL
                  : (const view_control *)ibl_option_find(&all, c->of,
                                                          strlen(c->of), '\0');
}

/* ---- where rows change something ----------------------------------------- */

/* "is of --mode levels, table and map" */
static const char *say_modes(unsigned modes)
{
    static char text[160];

    snprintf(text, sizeof text, "is of --mode");
    for (int i = 0; modes >> i; i++) {
        const unsigned after = modes >> i >> 1;
        if (modes >> i & 1)
            view_add(text, sizeof text, " %s%s", view_mode_names[i],
                     !after                ? ""
                     : after & (after - 1) ? ","
                                           : " and");
    }
    return text;
}

const char *view_control_why(const view_control *c, const view_settings *s,
                             bool probe_set, const view_options *o)
{
    static char text[80];
    const char *file = view_options_file(o);
    const struct {
        unsigned need;
        bool holds;
        const char *why;
    } facts[] = {
        {NEED_TONE, !file || !view_picture_is_linear(file),
         "linear floats have none: write a .png"},
        {NEED_CURVE, !s->false_colour,
         "false colours have none: leave --false-colour out"},
        {NEED_MATERIAL, s->mode != VIEW_MODEL || s->override == VIEW_MATERIAL,
         "the model has its own: add --override material"},
        {NEED_ORBIT, s->mode != VIEW_MODEL || !s->file_camera,
         "the file's camera has its own: leave --file-camera out"},
        {NEED_PROBES, s->probes > 0 || probe_set,
         "is of local probes: add --probes or --probe-set"},
        {NEED_OWN, !probe_set, "are those of the set: leave --probe-set out"},
        {NEED_PLAIN, !s->rough_fresnel,
         "the Fresnel of roughness has none: leave --rough-fresnel out"},
        {NEED_REFERENCE, view_is_sampled(s, &o->other),
         "is of the reference: add --reflection reference"},
        {NEED_WINDOW, !file,
         "only in a window: a picture captures all at once"},
        {NEED_PICTURE, file, "only with --offscreen or --contact-sheet"},
        {NEED_ONE, o->offscreen, "only with --offscreen"},
        {NEED_NO_SHEET, !o->contact_sheet, "a sheet has all of them"}};

    if (!(c->where >> s->mode & 1))
        return say_modes(c->where & ALL);
    for (size_t i = 0; i < sizeof facts / sizeof *facts; i++)
        if (c->where & facts[i].need && !facts[i].holds)
            return facts[i].why;
    const view_control *of = view_control_of(c);
    if (!of || *(const int *)((const char *)s + of->option.offset) == c->is)
        return NULL;
    snprintf(text, sizeof text, "is of --%s %s", c->of,
             of->option.choices[c->is]);
    return text;
}

/* ---- values -------------------------------------------------------------- */

void *view_control_field(const view_control *c, view_settings *s)
{
    return (char *)s + c->option.offset;
}

int view_control_choices(const view_control *c)
{
    int n = 0;

    while (c->option.choices[n])
        n++;
    return n;
}

void view_control_step(const view_control *c, view_settings *s, int step)
{
    void *field = view_control_field(c, s);
    const ibl_option *o = &c->option;
    int *n = field;
    double *x = field;

    if (o->kind == IBL_OPTION_ON || o->kind == IBL_OPTION_OFF)
        *(bool *)field = !*(bool *)field;
    else if (o->kind == IBL_OPTION_CHOICE)
        *n = (*n + step + view_control_choices(c)) % view_control_choices(c);
    else if (o->kind == IBL_OPTION_INT)
        *n = (int)fmin(fmax(*n + step, o->low), o->high);
    else
        *x = fmin(
            fmax(c->step > 0 ? *x + step * c->step : *x * exp2(step), o->low),
            o->high);
}

void view_control_text(const view_control *c, const view_settings *s,
                       char text[80])
{
    view_settings of = *s;
    const void *field = view_control_field(c, &of);
    const int *n = field;
    const double *x = field;

    if (c->option.kind == IBL_OPTION_ON || c->option.kind == IBL_OPTION_OFF)
        snprintf(text, 80, "%s", *(const bool *)field ? "on" : "off");
    else if (c->option.kind == IBL_OPTION_CHOICE)
        snprintf(text, 80, "%s", c->option.choices[*n]);
    else if (c->option.kind == IBL_OPTION_INT)
        snprintf(text, 80, "%d", *n);
    else if (c->shape == VIEW_TWO_INTS)
        snprintf(text, 80, "%d, %d", n[0], n[1]);
    else if (c->shape == VIEW_AS_OPTION)
        snprintf(text, 80, "%.4g", *x);
    else
        snprintf(text, 80, "%.3g, %.3g", x[0], x[1]);
}

bool view_control_of_side(const view_control *c)
{
    return c->option.offset < VIEW_SIDE_BYTES;
}

void view_controls_share(const view_settings *from, view_settings *to)
{
    memcpy((char *)to + VIEW_SIDE_BYTES, (const char *)from + VIEW_SIDE_BYTES,
           sizeof *to - VIEW_SIDE_BYTES);
}

/* ---- keys ---------------------------------------------------------------- */

const view_action view_actions[] = {
    {"Comparison", "C", "compare with the present state: both sides are alike",
     'C', 0, VIEW_COPY_SIDE},
    {"Comparison", "Tab", "change the other side", NAMED(TAB), 0,
     VIEW_OTHER_SIDE},
    {"Camera", "Right Left", "camera round, or map sideways; mouse: drag",
     NAMED(RIGHT), NAMED(LEFT), VIEW_MOVE_ACROSS},
    {"Camera", "Up Down", "camera or map up, down", NAMED(UP), NAMED(DOWN),
     VIEW_MOVE_UP},
    {"Camera", "+ -", "nearer, farther; mouse: wheel", '+', '-', VIEW_APPROACH},
    {"Scene", "Space", "stop the time, let it go on", ' ', 0, VIEW_PAUSE},
    {"Display", "y", "exposure that makes the mean grey", 'y', 0, VIEW_EXPOSE},
    {"Window", "0", "all as it was in the beginning", '0', 0, VIEW_RESET},
    {"Window", "Home", "the same", NAMED(HOME), 0, VIEW_RESET},
    {"Window", "/", "files that can be opened", '/', 0, VIEW_LIST_FILES},
    {"Window", "PageDown PageUp", "next file of the folder, the one before",
     NAMED(PAGE_DOWN), NAMED(PAGE_UP), VIEW_STEP_FILE},
    {"Window", "F5", "read the files again", NAMED(F5), 0, VIEW_OPEN_AGAIN},
    {"Window", "p", "controls", 'p', 0, VIEW_SHOW_PANEL},
    {"Window", "P", "write iblview-NNN.png", 'P', 0, VIEW_WRITE_PICTURE},
    {"Window", "?", "this list", '?', 0, VIEW_SHOW_KEYS},
    {"Window", "F11", "whole screen", NAMED(F11), 0, VIEW_FILL_SCREEN},
    {"Window", "Escape", "close what is open", NAMED(ESCAPE), 0, VIEW_CLOSE},
    {"Window", "q", "quit", 'q', 0, VIEW_QUIT},
    {.title = NULL}};

bool view_key_line_at(int i, view_key_line *line)
{
    const ibl_section *section;
    int n = 0;

    do {
        section = view_control_sections[n++];
        line->title = section ? section->title : "Window";
        for (int k = 0; section && k < section->count; k++) {
            const view_control *c = (const void *)ibl_section_at(section, k);
            if (!c->key || i-- > 0)
                continue;
            snprintf(line->what, sizeof line->what, "%s", c->label);
            for (int m = 0; c->option.choices && c->option.choices[m] &&
                            c->option.choices != view_material_names;
                 m++)
                view_add(line->what, sizeof line->what, "%s %s", m ? "," : ":",
                         c->option.choices[m]);
            snprintf(line->keys, sizeof line->keys, c->back ? "%c %c" : "%c",
                     c->key, c->back);
            return true;
        }
        for (const view_action *a = view_actions; a->title; a++) {
            if (strcmp(a->title, line->title) || i-- > 0)
                continue;
            snprintf(line->what, sizeof line->what, "%s", a->what);
            snprintf(line->keys, sizeof line->keys, "%s", a->keys);
            return true;
        }
    } while (section);
    return false;
}

void view_print_keys(FILE *to)
{
    view_key_line line;
    const char *title = "";

    for (int i = 0; view_key_line_at(i, &line); i++) {
        if (strcmp(title, line.title) != 0)
            fprintf(to, "%s%s:\n", *title ? "\n" : "", line.title);
        title = line.title;
        fprintf(to, "  %-15s %s\n", line.keys, line.what);
    }
}
