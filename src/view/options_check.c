/* SPDX-License-Identifier: MIT */
/* Which options go together, and with what is shown; and defaults that depend
 * on others. */
#include "view/options_check.h"

#include <errno.h>
#include <string.h>

#include "view/message.h"
#include "view/set_parts.h"

static bool misuse(const char *what, const char *why)
{
    return view_fail("%s: %s", what, why);
}

/* Maps are the same with every material, turn and comparison. */
static bool for_spheres(int axis)
{
    return axis == VIEW_AXIS_MATERIAL || axis == VIEW_AXIS_TURN ||
           axis == VIEW_AXIS_COMPARE;
}

static bool shows_maps(const view_options *o)
{
    return (o->settings.mode != VIEW_SPHERES &&
            o->settings.mode != VIEW_SCENE) ||
           o->rows == VIEW_AXIS_LEVEL || o->columns == VIEW_AXIS_LEVEL;
}

static bool has_one_level(const view_options *o)
{
    return o->settings.mode == VIEW_IRRADIANCE_MAP ||
           o->settings.mode == VIEW_TABLE;
}

/* Whether something changes along an axis. */
static bool check_axis(const view_options *o, const char *option, int axis)
{
    if (o->settings.mode == VIEW_SCENE &&
        (axis == VIEW_AXIS_MATERIAL || axis == VIEW_AXIS_COMPARE ||
         axis == VIEW_AXIS_LEVEL))
        return view_fail("%s %s: not of --mode scene: choose turn, ev or tone",
                         option, view_axis_names[axis]);
    if (shows_maps(o) && for_spheres(axis))
        return view_fail(
            "%s %s: maps are the same with each: choose ev or tone", option,
            view_axis_names[axis]);
    if (axis == VIEW_AXIS_LEVEL && has_one_level(o))
        return view_fail("%s level: --mode %s has none: leave one of them out",
                         option, view_mode_names[o->settings.mode]);
    return true;
}

static bool check_sheet(const view_options *o)
{
    if (o->contact_sheet && o->rows == o->columns)
        return view_fail("--sheet-rows and --sheet-columns: both %s: choose "
                         "another for one of them",
                         view_axis_names[o->rows]);
    if (o->contact_sheet && o->offscreen)
        return misuse("--offscreen and --contact-sheet", "choose one");
    if (o->contact_sheet && o->texel[0] >= 0)
        return misuse("--texel and --contact-sheet", "choose one");
    if (!o->contact_sheet && o->rows >= 0)
        return misuse("--sheet-rows", "only with --contact-sheet");
    if (!o->contact_sheet && o->columns >= 0)
        return misuse("--sheet-columns", "only with --contact-sheet");
    return !o->contact_sheet || (check_axis(o, "--sheet-rows", o->rows) &&
                                 check_axis(o, "--sheet-columns", o->columns));
}

static bool check_probes(const view_options *o)
{
    const char *save = o->save_probes;

    if (o->probe_set && o->settings.probes)
        return misuse("--probe-set and --probes", "choose one");
    if (save && o->probe_set)
        return misuse("--save-probes and --probe-set", "choose one");
    if (save && o->contact_sheet)
        return misuse("--save-probes and --contact-sheet", "choose one");
    if (save && o->settings.mode != VIEW_SCENE)
        return misuse("--save-probes", "only with --mode scene");
    if (save && !o->settings.probes)
        return misuse("--save-probes",
                      "there are no local probes: say how many by --probes");
    return true;
}

static bool check(const view_options *o)
{
    static const char pictures_alone[] =
        "only with --offscreen or --contact-sheet";
    const bool picture = o->offscreen || o->contact_sheet;

    if (!o->request.path)
        return view_fail("nothing to show: iblview [options] PATH, see "
                         "iblview --help");
    if (o->quiet && o->verbose)
        return misuse("--quiet and --verbose", "choose one");
    if (o->quiet && o->stats)
        return misuse("--quiet and --stats", "choose one");
    if (o->stats && !picture && (o->save_probes || o->texel[0] >= 0))
        return misuse("--stats", "no picture is drawn: add --offscreen or "
                                 "--contact-sheet");
    if (o->frames && !picture)
        return misuse("--frames", pictures_alone);
    if (o->samples && !picture)
        return misuse("--samples", pictures_alone);
    if (o->frames && o->samples)
        return misuse("--frames and --samples", "choose one");
    if (o->texel[0] >= o->size[0] || o->texel[1] >= o->size[1])
        return view_fail("--texel %g,%g: outside the picture of %dx%d",
                         o->texel[0], o->texel[1], o->size[0], o->size[1]);
    return true;
}

/* An axis that was not chosen, with the other one. */
static void choose_axis(int *axis, int other, view_axis first, view_axis second)
{
    if (*axis < 0)
        *axis = other == (int)first ? (int)second : (int)first;
}

static void choose_axes(view_options *o)
{
    const bool scene_shown = o->settings.mode == VIEW_SCENE;
    const view_axis first = scene_shown         ? VIEW_AXIS_TURN
                            : !shows_maps(o)    ? VIEW_AXIS_MATERIAL
                            : !has_one_level(o) ? VIEW_AXIS_LEVEL
                                                : VIEW_AXIS_TONE;
    const view_axis second =
        scene_shown || shows_maps(o) ? VIEW_AXIS_EV : VIEW_AXIS_TURN;

    choose_axis(&o->rows, o->columns, first, second);
    choose_axis(&o->columns, o->rows, second, first);
}

bool view_options_finish(view_options *o)
{
    const bool sheet = o->contact_sheet;

    if (!o->size[0]) {
        o->size[0] = sheet ? VIEW_TILE_WIDTH : VIEW_WIDTH;
        o->size[1] = sheet ? VIEW_TILE_HEIGHT : VIEW_HEIGHT;
    }
    if (!o->grid[0]) {
        o->grid[0] = sheet ? 2 : o->settings.rows;
        o->grid[1] = sheet ? 4 : o->settings.columns;
    }
    o->settings.rows = o->grid[0];
    o->settings.columns = o->grid[1];
    if (sheet)
        choose_axes(o);
    return check_sheet(o) && check_probes(o) && check(o);
}

/* ---- what is shown ------------------------------------------------------ */

bool view_options_may(const view_options *o)
{
    const view_request *r = &o->request;
    const char *option = r->irradiance ? "--irradiance"
                         : r->lut      ? "--lut"
                         : r->sky      ? "--sky"
                                       : NULL;
    const char *words;

    if (strcmp(r->path, "-") != 0 &&
        view_file_look(r->path, &words) == VIEW_FILE_MISSING)
        return view_fail("%s: cannot be opened: %s", r->path, strerror(errno));
    return !option || !view_is_map(r->path) ||
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
    return true;
}
