/* SPDX-License-Identifier: MIT */
/* The options besides those of controls.c, and which go together. */
#include "view/controls.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/names.h"
#include "common/path.h"
#include "common/signals.h"
#include "view/folder.h"
#include "view/gl.h"
#include "view/message.h"

/* ---- which options go together ------------------------------------------ */

/* Reports options that exclude each other, by their values. */
static bool check_pairs(const view_options *o)
{
    const view_settings *s = &o->settings;
    const char *file = view_options_file(o);
    const struct {
        bool wrong;
        const char *options, *why;
    } rules[] = {
        {o->contact_sheet && o->offscreen, "--offscreen and --contact-sheet",
         "choose one"},
        {o->quiet && o->stats, "--quiet and --stats", "choose one"},
        {file && view_picture_is_linear(file) &&
             s->background == VIEW_BACKGROUND_TRANSPARENT,
         "--background transparent",
         "linear pictures have no alpha: write a .png"},
        {s->mode == VIEW_SCENE && (s->reflection == VIEW_REFERENCE ||
                                   o->other.reflection == VIEW_REFERENCE),
         "--reflection reference", "is of --mode spheres and model"},
        {!o->model && s->mode == VIEW_MODEL, "--mode model",
         "is of a model: add --model"},
        {(o->against || o->against_set) && s->compare == VIEW_ALONE,
         "--compare no", "leave it out, or --against and --against-set"},
        {s->compare && !o->against_set && !memcmp(s, &o->other, sizeof *s),
         "--compare", "a state with itself: choose another --against"},
    };

    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
        if (rules[i].wrong)
            return view_fail("%s: %s", rules[i].options, rules[i].why);
    return true;
}

/* Refuses an option that changes nothing. */
static bool check_controls(const ibl_given *given, const view_settings *s,
                           const view_options *o)
{
    const view_control *c;

    for (int i = 0; (c = view_control_at(i)); i++) {
        const char *why = view_control_why(c, s, o->probe_set, o);
        if (why && ibl_is_given(given, c->option.name))
            return ibl_refuse(given, c->option.name, "%s", why);
    }
    return true;
}

/* An option that has a meaning only with another one implies that. */
static void imply(const ibl_given *given, view_options *o)
{
    view_settings *s = &o->settings;
    const view_control *c;

    if (o->model && !ibl_is_given(given, "mode"))
        s->mode = VIEW_MODEL;
    for (int i = 0; (c = view_control_at(i)); i++)
        if (c->of && ibl_is_given(given, c->option.name) &&
            !ibl_is_given(given, c->of))
            *(int *)view_control_field(view_control_of(c), s) = c->is;
    if ((o->against || o->against_set) && !s->compare &&
        !ibl_is_given(given, "compare"))
        s->compare = VIEW_SPLIT;
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
    const view_control *c;
    /* A word that is no option is the name of a reflection. */
    char *text = ibl_need(ibl_format(
             "%s%s", *o->against == '-' ? "" : "--reflection ", o->against)),
         *rest = text, *word;
    int count = 0;

    while (count < 63 && (word = strtok_r(NULL, " ", &rest)))
        words[count++] = word;
    words[count] = NULL;
    ibl_misuse_prefix("--against: ");
    bool ok = ibl_command_line(&side, words, &other, NULL);
    for (int i = 0; ok && (c = view_control_at(i)); i++)
        if (!view_control_of_side(c) &&
            ibl_is_given(&other.given, c->option.name))
            ok = ibl_refuse(&other.given, c->option.name,
                            "is the same for both sides");
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
    const char *file = view_options_file(o);

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
    return true;
}

/* ---- the command --------------------------------------------------------- */

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
    {"materials", "--help has their names"},
    {"reference", "--reflection reference"},
    {"frames", "--samples of the reference; --stats draws 16"},
    {"verbose", "--stats names what draws, iblbake info the files"},
    {"texel", "a window shows what is under the pointer"},
    {"reflection=bent", "fit has fewer errors"},
    {"input-layout", "iblbake --input-layout bakes it first"},
    {"face-order", "iblbake --face-order bakes it first"},
    {"input-transfer", "iblbake --input-transfer bakes it first"},
    {.words = NULL}};

static void set_defaults(void *options)
{
    view_options *o = options;

    *o = (view_options){
        .labels = true, .samples = 256, .settings = view_settings_default()};
    o->settings.antialias = 2;
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
    .sections = view_control_sections,
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
