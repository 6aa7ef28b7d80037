/* SPDX-License-Identifier: MIT */
/* From the command line to view_options, by the tables of options.c. */
#include <errno.h>
#include <getopt.h>
#include <stdlib.h>
#include <string.h>

#include "view/keys.h"
#include "view/message.h"
#include "view/option_row.h"
#include "view/scene.h"

enum {
    MAX_OPTIONS = 64,
    FIRST = 256 /* of getopt's values of long options; letters are below */
};

/* The tables as getopt wants them. */
typedef struct forms {
    const view_option *row[MAX_OPTIONS];
    struct option longs[MAX_OPTIONS + 1];
    char shorts[2 * MAX_OPTIONS + 2];
    int count;
} forms;

static void make_forms(forms *f)
{
    char *letter = f->shorts;

    memset(f, 0, sizeof *f);
    *letter++ = ':'; /* a missing value is told from an unknown option */
    for (const view_section *s = view_sections; s->title; s++)
        for (int i = 0; i < s->count && f->count < MAX_OPTIONS; i++) {
            const view_option *opt = &s->options[i];
            f->row[f->count] = opt;
            f->longs[f->count] = (struct option){
                opt->name, opt->value ? required_argument : no_argument, NULL,
                FIRST + f->count};
            f->count++;
            if (!opt->letter)
                continue;
            *letter++ = opt->letter;
            if (opt->value)
                *letter++ = ':';
        }
}

/* The row of what getopt returned or complained of. */
static const view_option *row_of(const forms *f, int got)
{
    if (got >= FIRST)
        return got - FIRST < f->count ? f->row[got - FIRST] : NULL;
    for (int i = 0; i < f->count; i++)
        if (got && f->row[i]->letter == got)
            return f->row[i];
    return NULL;
}

static bool set_int(const view_option *opt, void *field, const char *value)
{
    char *end;

    errno = 0;
    const long n = strtol(value, &end, 10);
    if (end == value || *end || errno || (double)n < opt->low ||
        (double)n > opt->high)
        return false;
    *(int *)field = (int)n;
    return true;
}

static bool set_real(const view_option *opt, void *field, const char *value)
{
    char *end;
    const double x = strtod(value, &end);

    if (end == value || *end || !(x >= opt->low && x <= opt->high))
        return false;
    *(double *)field = x;
    return true;
}

/* Enumerations are as wide as an int, but may be unsigned. */
_Static_assert(sizeof(view_mode) == sizeof(int), "an enumeration is no int");

static bool set_choice(const view_option *opt, void *field, const char *value)
{
    for (int i = 0; opt->choice(i); i++)
        if (!strcmp(opt->choice(i), value)) {
            memcpy(field, &i, sizeof i);
            return true;
        }
    return false;
}

static bool set(view_options *o, const view_option *opt, const char *value)
{
    void *field = (char *)o + opt->offset;
    char allowed[200];
    bool ok = true;

    switch (opt->kind) {
    case VIEW_OPTION_ON:
    case VIEW_OPTION_OFF:
        *(bool *)field = opt->kind == VIEW_OPTION_ON;
        break;
    case VIEW_OPTION_INT:
        ok = set_int(opt, field, value);
        break;
    case VIEW_OPTION_REAL:
        ok = set_real(opt, field, value);
        break;
    case VIEW_OPTION_CHOICE:
        ok = set_choice(opt, field, value);
        break;
    case VIEW_OPTION_TEXT:
        if (!*value)
            return view_fail("--%s: is empty: give it a file", opt->name);
        *(const char **)field = value;
        break;
    case VIEW_OPTION_OTHER:
        ok = opt->parse(o, value);
        break;
    case VIEW_OPTION_KEYS:
    case VIEW_OPTION_MATERIALS:
    case VIEW_OPTION_HELP:
    case VIEW_OPTION_VERSION:
        break;
    }
    if (ok)
        return true;
    view_option_allowed(opt, allowed, sizeof allowed);
    return view_fail("--%s %s: not a value of that option: it takes %s",
                     opt->name, value, allowed);
}

/* What getopt did not take, '?' or ':'. */
static bool complain(const forms *f, int got, const char *word)
{
    const view_option *opt = row_of(f, optopt);
    char allowed[200];

    if (got == ':' && opt) {
        view_option_allowed(opt, allowed, sizeof allowed);
        return view_fail("--%s: has no value: it takes %s%s%s", opt->name,
                         opt->value, *allowed ? ", " : "", allowed);
    }
    if (opt)
        return view_fail("%s: the option takes no value: leave out =...", word);
    if (optopt)
        return view_fail("-%c: unknown option: see iblview --help", optopt);
    return view_fail("%s: unknown or ambiguous option: see iblview --help",
                     word);
}

static void print_materials(void)
{
    for (const view_material *m = view_materials; m->name; m++)
        printf("%-12s metal F0 %.3f %.3f %.3f, else F0 %.3f and albedo %.3f "
               "%.3f %.3f; %s\n",
               m->name, m->metal[0], m->metal[1], m->metal[2], m->dielectric_f0,
               m->albedo[0], m->albedo[1], m->albedo[2], m->source);
}

static void print_keys(void)
{
    char text[VIEW_KEYS_BYTES];

    view_keys_text(text, sizeof text);
    fputs(text, stdout);
}

/* Prints what an option asks for that ends the program. */
static bool prints(const view_option *opt)
{
    if (opt->kind == VIEW_OPTION_HELP)
        view_options_help(stdout);
    else if (opt->kind == VIEW_OPTION_VERSION)
        printf("iblview %s\n", IBL_VERSION);
    else if (opt->kind == VIEW_OPTION_KEYS)
        print_keys();
    else if (opt->kind == VIEW_OPTION_MATERIALS)
        print_materials();
    else
        return false;
    return true;
}

static bool take_words(view_options *o, char **words, int count)
{
    if (count > 1)
        return view_fail("%s: more than one thing to show: %s is already given",
                         words[1], words[0]);
    if (count == 1 && !*words[0])
        return view_fail("the name of what to show is empty: give a file or a "
                         "directory");
    if (count == 1)
        o->request.path = words[0];
    return true;
}

bool view_options_parse(int argc, char **argv, view_options *o, int *status)
{
    forms f;
    int got;

    *o = view_options_default();
    make_forms(&f);
    opterr = 0;
    *status = 2;
    while ((got = getopt_long(argc, argv, f.shorts, f.longs, NULL)) != -1) {
        const view_option *opt =
            got == '?' || got == ':' ? NULL : row_of(&f, got);
        if (!opt)
            return complain(&f, got, argv[optind - 1]);
        if (prints(opt)) {
            *status = 0;
            return false;
        }
        if (!set(o, opt, optarg))
            return false;
    }
    return take_words(o, argv + optind, argc - optind) &&
           view_options_finish(o);
}
