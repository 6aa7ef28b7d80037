/* SPDX-License-Identifier: MIT */
/* The options besides those of controls.c, and which go together. */
#include "view/options.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "view/folder.h"
#include "view/gl.h"
#include "view/message.h"
#include "view/sphere_grid.h"
#include "view/truth.h"

/* ---- values of their own kind ------------------------------------------ */

static bool parse_picture(void *field, const char *value)
{
    const size_t length = strlen(value);

    *(const char **)field = value;
    return view_picture_is_linear(value) ||
           (length > 4 && !strcasecmp(value + length - 4, ".png"));
}

static bool parse_size(void *field, const char *value)
{
    int *to = field;
    const char *end;

    return ibl_number_int(value, 1, 16384, &to[0], &end) && *end == 'x' &&
           ibl_number_int(end + 1, 1, 16384, &to[1], &end) && !*end;
}

static bool parse_texel(void *field, const char *value)
{
    return ibl_number_list(value, ',', 0, 16383, field, 2) == 2;
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
    const view_settings *s = &o->settings;
    const view_mode mode = s->mode;
    const char *file = sheet ? o->contact_sheet : o->offscreen;
    const bool linear = file && view_picture_is_linear(file);
    const bool sampled = view_wants_reference(s) ||
                         (s->compare && view_wants_reference(&o->other));
    const struct {
        bool wrong;
        const char *options, *why;
    } rules[] = {
        {sheet && o->offscreen, "--offscreen and --contact-sheet", one},
        {sheet && texel, "--texel and --contact-sheet", one},
        {sheet && o->panel, "--panel and --contact-sheet", one},
        {sheet && o->turntable, "--turntable and --contact-sheet", one},
        {o->turntable && !o->offscreen, "--turntable",
         "names its pictures by --offscreen: add it"},
        {o->turntable && !view_is_lit(s), "--turntable",
         "is of --mode spheres, model and scene"},
        {linear && o->panel, "--panel",
         "linear pictures have none: write a .png"},
        {linear && s->background == VIEW_BACKGROUND_TRANSPARENT,
         "--background transparent",
         "linear pictures have no alpha: write a .png"},
        {o->panel && !picture, "--panel",
         "only with --offscreen: in a window P opens it"},
        {!o->labels && linear, "--no-labels", "linear pictures have none"},
        {o->probe_set && s->probes, "--probe-set and --probes", one},
        {o->quiet && o->verbose, "--quiet and --verbose", one},
        {o->quiet && o->stats, "--quiet and --stats", one},
        {o->stats && !picture && texel, "--stats",
         "no picture is drawn: add --offscreen or --contact-sheet"},
        {(o->frames || o->samples) && !picture,
         o->frames ? "--frames" : "--samples",
         "only with --offscreen or --contact-sheet"},
        {o->frames && o->samples, "--frames and --samples", one},
        {o->samples && !sampled && !(sheet && mode == VIEW_MODEL), "--samples",
         "is of the reference: add --reference"},
        {o->frames && !sampled && !o->stats && !o->verbose &&
             (sheet || mode != VIEW_SCENE),
         "--frames",
         "draws one picture again and again: add --reference or --verbose"},
        {mode == VIEW_SCENE && (s->reflection == VIEW_REFERENCE ||
                                o->other.reflection == VIEW_REFERENCE),
         "--reflection reference", "is of --mode spheres and model"},
        {!o->model && mode == VIEW_MODEL, "--mode model",
         "is of a model: add --model"},
        {o->model && mode != VIEW_MODEL && mode != VIEW_SCENE, "--model",
         "is of --mode model and scene"},
        {o->probe_set && mode != VIEW_SCENE, "--probe-set",
         "is of --mode scene"},
        {o->request.sky && !view_shows_materials(s) && mode != VIEW_SCENE,
         "--sky", "is of --mode spheres, model and scene"},
        {o->request.irradiance && !view_is_lit(s) &&
             mode != VIEW_IRRADIANCE_MAP,
         "--irradiance", "is not shown in this mode: leave it out"},
        {o->request.lut && !view_is_lit(s) && mode != VIEW_TABLE, "--lut",
         "is not shown in this mode: leave it out"},
        {(o->against || o->against_set) && s->compare == VIEW_ALONE,
         "--compare no", "leave it out, or --against and --against-set"},
        {s->compare && !o->against_set && !memcmp(s, &o->other, sizeof *s),
         "--compare", "a state with itself: choose another --against"},
        {sheet && o->mean_exposure, "--mean-exposure", "is of one picture"},
        {sheet && ibl_is_given(&o->given, "material") && mode == VIEW_SPHERES,
         "--material", "the sheet has all of them"},
        {sheet && ibl_is_given(&o->given, "level"), "--level",
         "the sheet has all of them"},
        {sheet && ibl_is_given(&o->given, "tone") &&
             (mode == VIEW_IRRADIANCE_MAP || mode == VIEW_TABLE ||
              mode == VIEW_SOURCE_MAP),
         "--tone", "the sheet has all of them"},
        {sheet && mode == VIEW_MODEL &&
             ibl_given_of(&o->given, "reflection reference"),
         "--reflection", "the sheet has all of them"},
    };

    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
        if (rules[i].wrong)
            return view_fail("%s: %s", rules[i].options, rules[i].why);
    return true;
}

/* Refuses a setting that changes nothing. */
static bool check_controls(const ibl_given *given, const view_settings *s,
                           const view_options *o)
{
    const char *file = o->contact_sheet ? o->contact_sheet : o->offscreen;
    const unsigned facts = view_facts(s, o->probe_set, file);

    for (int i = 0; view_control_at(i); i++) {
        const view_control *c = view_control_at(i);
        const char *why = view_control_why(c, facts);
        if (why && ibl_is_given(given, c->option.name))
            return ibl_refuse(given, c->option.name, "%s", why);
    }
    return true;
}

/* An option that has a meaning only with another one implies that. */
static void imply(const ibl_given *given, view_options *o)
{
    view_settings *s = &o->settings;

    if (o->model && !ibl_is_given(given, "mode"))
        s->mode = VIEW_MODEL;
    if (ibl_is_given(given, "background"))
        return;
    if (ibl_is_given(given, "blur"))
        s->background = VIEW_BACKGROUND_BLUR;
    if (ibl_is_given(given, "background-level"))
        s->background = VIEW_BACKGROUND_LEVEL;
    if (ibl_is_given(given, "colour"))
        s->background = VIEW_BACKGROUND_COLOUR;
}

/* The options of the other side, over those of the first. */
static bool parse_against(view_options *o)
{
    static const ibl_command side = {.usage = "",
                                     .sections = view_control_sections,
                                     .settings_size = sizeof(view_options),
                                     .given = offsetof(view_options, given)};
    static char *words[64];
    view_options other = {.settings = o->settings};
    char *text = ibl_need(strdup(o->against)), *rest = text, *word;
    int count = 0;
    bool ok = true;

    if (*text != '-' && ibl_names_find(view_reflection_names, text) < 0) {
        view_fail("--against %s: neither options of that side, such as "
                  "\"--diffuse sh\", nor a reflection",
                  text);
        free(text);
        return false;
    }
    if (*text != '-')
        words[count++] = "--reflection";
    while (count < 63 && (word = strtok_r(NULL, " ", &rest)))
        words[count++] = word;
    words[count] = NULL;
    ibl_misuse_prefix("--against: ");
    ok = ibl_command_line(&side, words, &other, NULL);
    for (int i = 0; ok && view_control_at(i); i++) {
        const view_control *c = view_control_at(i);
        if (!(c->where & VIEW_OF_SIDE) &&
            ibl_is_given(&other.given, c->option.name))
            ok = ibl_refuse(&other.given, c->option.name,
                            "is the same for both sides");
    }
    ok = ok && check_controls(&other.given, &other.settings, o);
    ibl_misuse_prefix("");
    o->other = other.settings;
    free(text);
    return ok;
}

static bool validate(void *options)
{
    static const int window[2] = {1280, 720}, tile[2] = {320, 240};
    view_options *o = options;
    view_settings *s = &o->settings;
    const bool sheet = o->contact_sheet;
    const char *file = sheet ? o->contact_sheet : o->offscreen;

    if (!o->size[0])
        memcpy(o->size, sheet ? tile : window, sizeof o->size);
    if (sheet && !ibl_is_given(&o->given, "grid"))
        s->rows = 2, s->columns = 4;
    if (o->request.path && view_is_model(o->request.path)) {
        if (o->model)
            return view_fail("%s: is a second model: name the set or the map "
                             "that lights it",
                             o->request.path);
        o->model = o->request.path;
        o->request.path = NULL;
    }
    if (o->model && !o->request.path && !(o->request.path = view_shipped_map()))
        return false;
    imply(&o->given, o);
    if ((o->against || o->against_set) && !ibl_is_given(&o->given, "compare"))
        s->compare = VIEW_SPLIT;
    o->other = *s;
    if (s->compare && !o->against && !o->against_set && view_shows_materials(s))
        o->other.reflection = VIEW_REFERENCE;
    o->request.layer = s->layer;
    if ((o->against && !parse_against(o)) || !check_pairs(o) ||
        !check_controls(&o->given, s, o))
        return false;
    if (!o->request.path)
        return view_fail("nothing to show: iblview [options] PATH, see "
                         "iblview --help");
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
#define FLAG(field) .kind = IBL_OPTION_ON, IBL_AT(field)
#define PICTURE(field)                                                         \
    IBL_OTHER(field, "OUT.png", parse_picture),                                \
        .allowed = "a name that ends in .png, or in .exr for linear floats",   \
        .standard = ""

/* clang-format off */
static const ibl_option files[] = {
    {"model", 0, IBL_TEXT(model, "FILE"),
     .allowed = "a scene of glTF 2.0: .gltf, .glb",
     .standard = "none",
     .help = "show a model by the set; implies --mode model, but in --mode "
             "scene it stands in the room"},
    {"probe-set", 0, IBL_TEXT(probe_set, "INDEX"), .standard = "",
     .help = "local probes that iblbake probes baked: its index.json"},
    {"irradiance", 0, IBL_TEXT(request.irradiance, "FILE"), .standard = "",
     .help = "the irradiance map, if it is not beside PATH"},
    {"lut", 0, IBL_TEXT(request.lut, "FILE"), .standard = "",
     .help = "the BRDF table"},
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
    {"turntable", 0, IBL_INT(turntable, 2, 9999), .standard = "none",
     .help = "write so many pictures of a turn of the camera, OUT-001.png "
             "and so on"},
    {"no-labels", 0, .kind = IBL_OPTION_OFF, IBL_AT(labels),
     .help = "leave labels, axes and legends out of pictures"},
    {"panel", 0, FLAG(panel),
     .help = "draw the panel of controls beside the picture"},
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
    {"mean-exposure", 0, FLAG(mean_exposure),
     .help = "expose the picture so that its mean luminance is middle grey"},
};

static const ibl_option others[] = {
    {"against", 0, IBL_TEXT(against, "OPTIONS"), .standard = "--reference",
     .help = "what the other side has otherwise, as \"--diffuse sh\" or only "
             "the name of a reflection"},
    {"against-set", 0, IBL_TEXT(against_set, "PATH"), .standard = "",
     .help = "draw the other side by this set or map"},
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
    {"light", "--lights N: those of the tutorials"},
    {"no-sky", "--background colour is black"},
    {"no-parallax", "--parallax none"},
    {"no-blend", "--probe-choice nearest"},
    {"no-walls", "weigh probes by influence volumes: leave it out"},
    {"volumes", "--weights shows where probes apply"},
    {"mirror-priority", "follows from --probe-set and --probe-limit"},
    {"probe-faces", "a capture is made whole: --probe-size makes it faster"},
    {"no-capture-shadows", "captures have shadows"},
    {"multiscatter", "is the default: leave it out"},
    {"reflection=bent", "fit has fewer errors"},
    {"input-layout", "iblbake --input-layout bakes it first"},
    {"face-order", "iblbake --face-order bakes it first"},
    {"input-transfer", "iblbake --input-transfer bakes it first"},
    {.words = NULL}};

/* Those of controls.c with the others beside them; view_options_parse fills it.
 */
static const ibl_section *sections[24];
static const ibl_section *const first[] = {IBL_SECTION("Files", files),
                                           IBL_SECTION("Pictures", pictures)};
static const ibl_section *const beside = IBL_SECTION("Comparison", others);
static const ibl_section *const last = IBL_SECTION("Running", running);

static void join_sections(void)
{
    int n = 0;

    sections[n++] = first[0];
    sections[n++] = first[1];
    for (int i = 0; view_control_sections[i]; i++) {
        sections[n++] = view_control_sections[i];
        if (!strcmp(beside->title, view_control_sections[i]->title))
            sections[n++] = beside;
    }
    sections[n] = last;
}

static void set_defaults(void *options)
{
    view_options *o = options;

    *o = (view_options){
        .labels = true, .texel = {-1, -1}, .settings = view_settings_default()};
    o->settings.antialias = VIEW_DEFAULT_ANTIALIAS;
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
    join_sections();
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
    const char *why;
    const bool map = view_kind_of(r->path, &why) == VIEW_KIND_MAP;

    if (strcmp(r->path, "-") != 0 && !map && access(r->path, F_OK))
        return view_fail("%s: cannot be opened: %s", r->path, strerror(errno));
    return !option || !map ||
           view_fail("%s: %s is baked here, with all that belongs to it: the "
                     "option is for baked files",
                     option, r->path);
}

bool view_options_suit(const view_options *o, const baked_set *set)
{
    const int levels = set->baked.file[IBL_CONTENT_SPECULAR].texture.levels;

    if (o->settings.level >= levels)
        return view_fail("--level %d: %s has levels 0 to %d", o->settings.level,
                         set->baked.name, levels - 1);
    for (int i = 0; i < 2; i++) {
        const view_settings *s = i ? &o->other : &o->settings;
        const view_reflection asked = s->reflection;
        const char *lacks =
            i && o->against_set ? NULL : view_set_lacks(set, s->diffuse);
        if (lacks)
            return view_fail("--diffuse %s: %s: there %s",
                             view_diffuse_names[s->diffuse], set->baked.name,
                             lacks);
        if (!set->baked.file[IBL_CONTENT_LOBE_TABLE].texture.data &&
            view_needs_lobes(asked))
            return view_fail("--reflection %s: %s has no table of lobes, which "
                             "iblbake --lobe-table writes: choose split or fit",
                             view_reflection_names[asked], set->baked.name);
    }
    return true;
}
