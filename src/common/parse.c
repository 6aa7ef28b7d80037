/* SPDX-License-Identifier: MIT */
/* Parses the command line into a command's settings. */
#include <ctype.h>
#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "common/names.h"
#include "common/option.h"
#include "common/process.h"
#include "common/signals.h"

static const char *misuse_prefix = "";

void ibl_misuse_prefix(const char *prefix)
{
    misuse_prefix = prefix;
}

bool ibl_misuse(const char *fmt, ...)
{
    char text[IBL_LINE_BYTES];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    ibl_print_line(misuse_prefix, text);
    return false;
}

/* Edit distance: the number of insertions, deletions and replacements. If b is
 * too long for the row: b_length. */
static size_t distance(const char *a, const char *b, size_t b_length)
{
    size_t row[32];

    if (b_length >= sizeof row / sizeof row[0])
        return b_length;
    for (size_t j = 0; j <= b_length; j++)
        row[j] = j;
    for (size_t i = 0; a[i]; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < b_length; j++) {
            size_t best = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            if (row[j] + 1 < best)
                best = row[j] + 1;
            if (diagonal + 1 < best)
                best = diagonal + 1;
            row[j + 1] = best;
        }
    }
    return row[b_length];
}

const ibl_option *ibl_section_at(const ibl_section *s, int i)
{
    return (const void *)((const char *)s->options + (size_t)i * s->row);
}

const ibl_option *ibl_option_at(const ibl_command *cmd, int n)
{
    for (const ibl_section *const *s = cmd->sections; *s; s++) {
        if (n < (*s)->count)
            return ibl_section_at(*s, n);
        n -= (*s)->count;
    }
    return NULL;
}

const ibl_option *ibl_option_find(const ibl_command *cmd, const char *name,
                                  size_t length, char letter)
{
    const ibl_option *opt;
    int n = 0;

    while ((opt = ibl_option_at(cmd, n++)))
        if (name ? strlen(opt->name) == length &&
                       !memcmp(opt->name, name, length)
                 : opt->letter == letter)
            break;
    return opt;
}

/* Whether a list has a word, with blanks between them. */
static bool has_word(const char *list, const char *word, size_t length)
{
    while (*list) {
        const size_t here = strcspn(list, " ");
        if (here == length && !memcmp(list, word, length))
            return true;
        list += here + (list[here] == ' ');
    }
    return false;
}

/* What to do in place of what went; NULL: it did not. */
static const char *instead_of(const ibl_command *cmd, const char *word,
                              size_t length)
{
    for (const ibl_gone *g = cmd->gone; g && g->words; g++)
        if (has_word(g->words, word, length))
            return g->instead;
    return NULL;
}

/* Refuses a word behind one or two dashes; says what to do if the option went,
 * or which one is like it. */
static bool unknown(const ibl_command *cmd, const char *dashes,
                    const char *word, size_t length)
{
    const char *instead = dashes[1] ? instead_of(cmd, word, length) : NULL;
    const ibl_option *opt, *nearest = NULL;
    size_t least = length / 3 + 2;

    if (instead)
        return ibl_misuse("--%.*s: is no more: %s", (int)length, word, instead);
    for (int n = 0; dashes[1] && (opt = ibl_option_at(cmd, n)); n++) {
        const size_t d = distance(opt->name, word, length);
        if (d < least) {
            least = d;
            nearest = opt;
        }
    }
    if (nearest)
        return ibl_misuse("--%.*s: unknown option: did you mean --%s?",
                          (int)length, word, nearest->name);
    return ibl_misuse("%s%.*s: unknown option: see %s%s%s --help", dashes,
                      (int)length, word, ibl_this_program.name,
                      cmd->name ? " " : "", cmd->name ? cmd->name : "");
}

bool ibl_number_int(const char *text, int low, int high, int *n,
                    const char **end)
{
    char *after;

    if (!isdigit((unsigned char)text[*text == '-']))
        return false;
    errno = 0;
    const long value = strtol(text, &after, 10);
    if (errno || value < low || value > high)
        return false;
    *n = (int)value;
    *end = after;
    return true;
}

bool ibl_number_real(const char *text, double low, double high, double *x,
                     const char **end)
{
    const char *digits = text + (*text == '-');
    char *after;

    if (!isdigit((unsigned char)digits[*digits == '.']) ||
        (digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X')))
        return false;
    const double value = strtod(text, &after);
    if (!(value >= low && value <= high))
        return false;
    *x = value;
    *end = after;
    return true;
}

int ibl_number_list(const char *text, char between, double low, double high,
                    double *list, int most)
{
    const char *end;

    for (int i = 0; i < most; i++, text = end + 1) {
        if (!ibl_number_real(text, low, high, &list[i], &end))
            return 0;
        if (*end != between)
            return *end ? 0 : i + 1;
    }
    return 0;
}

/* set stores choices as ints; enumerations may be unsigned. */
_Static_assert(sizeof(ibl_option_kind) == sizeof(int),
               "enumerations are not as wide as an int");

static bool set_text(const ibl_option *opt, void *field, const char *value)
{
    const size_t length = strlen(value);

    if (!length)
        return ibl_misuse("--%s: is empty: it takes %s", opt->name, opt->value);
    if (opt->kind == IBL_OPTION_PNG &&
        (length < 5 || strcasecmp(value + length - 4, ".png") != 0))
        return ibl_misuse("--%s %s: pictures are PNG files: give a name that "
                          "ends in .png",
                          opt->name, value);
    if (opt->kind == IBL_OPTION_DIR && !strcmp(value, "-"))
        return ibl_misuse("--%s -: standard output cannot hold a directory: "
                          "give one, ./- if that is its name",
                          opt->name);
    *(const char **)field = value;
    return true;
}

/* The state of parse. */
typedef struct line {
    const ibl_command *cmd;
    void *settings;
    char **argv;
    int next;               /* argument after the current one */
    const ibl_option *stop; /* the HELP or PRINT option found, or NULL */
} line;

static void note(line *l, const ibl_option *opt, const char *value)
{
    ibl_given *given = (ibl_given *)((char *)l->settings + l->cmd->given);
    int i = 0;

    if (!l->cmd->given)
        return;
    while (i < given->count && given->list[i].option != opt)
        i++;
    if (i == IBL_MOST_GIVEN)
        return;
    given->count += i == given->count;
    given->list[i].option = opt;
    given->list[i].value = value;
}

/* Stores the value of an option; value is NULL for a flag. */
static bool set(line *l, const ibl_option *opt, const char *value)
{
    void *field = (char *)l->settings + opt->offset;
    const char *end = "";
    char allowed[160];
    bool ok = false;
    int choice;

    note(l, opt, value);
    switch (opt->kind) {
    case IBL_OPTION_HELP:
    case IBL_OPTION_PRINT:
        l->stop = opt;
        return true;
    case IBL_OPTION_FLAG:
        *(int *)field = 1;
        return true;
    case IBL_OPTION_ON:
    case IBL_OPTION_OFF:
        *(bool *)field = opt->kind == IBL_OPTION_ON;
        return true;
    case IBL_OPTION_INT:
        ok = ibl_number_int(value, (int)opt->low, (int)opt->high, field, &end);
        break;
    case IBL_OPTION_REAL:
        ok = ibl_number_real(value, opt->low, opt->high, field, &end);
        break;
    case IBL_OPTION_CHOICE:
        choice = ibl_names_find(opt->choices, value);
        ok = choice >= 0;
        if (ok)
            memcpy(field, &choice, sizeof choice);
        break;
    case IBL_OPTION_TEXT:
    case IBL_OPTION_PNG:
    case IBL_OPTION_DIR:
        return set_text(opt, field, value);
    case IBL_OPTION_OTHER:
        ok = opt->parse(field, value);
        break;
    }
    if (ok && !*end)
        return true;
    snprintf(allowed, sizeof allowed, "%s=%s", opt->name, value);
    const char *instead = instead_of(l->cmd, allowed, strlen(allowed));
    if (instead)
        return ibl_misuse("--%s %s: is no more: %s", opt->name, value, instead);
    ibl_option_allowed(opt, allowed, sizeof allowed);
    const char *quote = value[strcspn(value, " \t\n")] || !*value ? "'" : "";
    return ibl_misuse("--%s %s%s%s: not a value of that option: it takes %s",
                      opt->name, quote, value, quote, allowed);
}

static bool no_value(const ibl_option *opt)
{
    char allowed[160];

    ibl_option_allowed(opt, allowed, sizeof allowed);
    return ibl_misuse("--%s: has no value: it takes %s%s%s", opt->name,
                      opt->value, *allowed ? ", " : "", allowed);
}

/* "--name", "--name=value" or "--name value". */
static bool take_long(line *l, const char *word)
{
    const size_t length = strcspn(word, "=");
    const ibl_option *opt = ibl_option_find(l->cmd, word, length, '\0');
    const char *value = word[length] ? word + length + 1 : NULL;

    if (!opt)
        return unknown(l->cmd, "--", word, length);
    if (!opt->value && value)
        return ibl_misuse("--%s=%s: the option takes no value: leave out =%s",
                          opt->name, value, value);
    if (opt->value && !value) {
        if (!l->argv[l->next])
            return no_value(opt);
        value = l->argv[l->next++];
    }
    return set(l, opt, value);
}

/* "-qv", "-j4", "-j 4". */
static bool take_short(line *l, const char *word)
{
    for (; *word; word++) {
        const ibl_option *opt = ibl_option_find(l->cmd, NULL, 0, *word);
        if (!opt)
            return unknown(l->cmd, "-", word, 1);
        if (opt->value) {
            const char *value = word[1] ? word + 1 : l->argv[l->next];
            if (!value)
                return no_value(opt);
            l->next += !word[1];
            return set(l, opt, value);
        }
        set(l, opt, NULL);
    }
    return true;
}

/* Fills the settings; stops at HELP and PRINT. */
static bool parse(line *l)
{
    bool ended = false;

    if (l->cmd->defaults) {
        memset(l->settings, 0, l->cmd->settings_size);
        l->cmd->defaults(l->settings);
    }
    if (l->cmd->words)
        *(char ***)((char *)l->settings + l->cmd->words) = l->argv;
    while (l->argv[l->next]) {
        const char *word = l->argv[l->next++];
        bool ok;
        if (ended || word[0] != '-' || !word[1])
            ok = !l->cmd->take || l->cmd->take(l->settings, word);
        else if (!strcmp(word, "--"))
            ok = ended = true;
        else if (word[1] == '-')
            ok = take_long(l, word + 2);
        else
            ok = take_short(l, word + 1);
        if (!ok)
            return false;
        if (l->stop)
            return true;
    }
    return !l->cmd->validate || l->cmd->validate(l->settings);
}

const char *ibl_given_value(const ibl_given *given, const char *name)
{
    for (int i = 0; i < given->count; i++)
        if (!strcmp(given->list[i].option->name, name))
            return given->list[i].value ? given->list[i].value : "";
    return NULL;
}

bool ibl_is_given(const ibl_given *given, const char *name)
{
    return ibl_given_value(given, name);
}

const char *ibl_given_of(const ibl_given *given, const char *options)
{
    for (int i = 0; i < given->count; i++) {
        const char *name = given->list[i].option->name;
        if (has_word(options, name, strlen(name)))
            return name;
    }
    return NULL;
}

bool ibl_refuse(const ibl_given *given, const char *options, const char *fmt,
                ...)
{
    const char *name = ibl_given_of(given, options);
    const char *value = name ? ibl_given_value(given, name) : "";
    char text[IBL_LINE_BYTES];
    va_list ap;

    va_start(ap, fmt);
    vsnprintf(text, sizeof text, fmt, ap);
    va_end(ap);
    return ibl_misuse("--%.*s%s%s: %s",
                      (int)strcspn(name ? name : options, " "),
                      name ? name : options, *value ? " " : "", value, text);
}

bool ibl_check_rules(const ibl_given *given, const ibl_rule *rules,
                     unsigned facts)
{
    for (const ibl_rule *r = rules; r->options; r++)
        if (!(r->where & facts) && ibl_given_of(given, r->options))
            return ibl_refuse(given, r->options, "%s", r->why);
    return true;
}

bool ibl_command_line(const ibl_command *cmd, char **words, void *settings,
                      int *status)
{
    line l = {.cmd = cmd, .settings = settings, .argv = words};
    const bool parsed = parse(&l);

    if (status)
        *status = parsed ? 0 : 2;
    if (!parsed || !l.stop)
        return parsed;
    if (!status)
        return ibl_misuse("--%s: only on the command line: leave it out",
                          l.stop->name);
    if (l.stop->kind == IBL_OPTION_HELP)
        ibl_command_help(cmd, stdout);
    else
        l.stop->print(stdout);
    return false;
}

static const ibl_command *find_command(const char *word)
{
    const ibl_command *const *all = ibl_this_program.commands;

    for (int i = 1; word && all[i]; i++)
        if (!strcmp(all[i]->name, word))
            return all[i];
    return all[0];
}

bool ibl_is_command(const char *word)
{
    return find_command(word) != *ibl_this_program.commands;
}

/* A first word like a command's, of a program that has some. */
static bool is_of_none(const char *word)
{
    return ibl_this_program.commands[1] && word && islower(*word) &&
           !word[strspn(word, "abcdefghijklmnopqrstuvwxyz-")] &&
           !ibl_is_command(word) && access(word, F_OK) && errno == ENOENT;
}

int ibl_command_main(int argc, char **argv)
{
    char **words = argc > 0 ? argv + 1 : argv;
    const ibl_command *cmd = find_command(words[0]);

    if (words[0] && !strcmp(words[0], "--complete")) {
        ibl_complete(words + 1);
        return 0;
    }
    if (is_of_none(words[0])) {
        char names[256] = "";
        for (int i = 1; ibl_this_program.commands[i]; i++)
            snprintf(names + strlen(names), sizeof names - strlen(names),
                     "%s%s", i > 1 ? ", " : "",
                     ibl_this_program.commands[i]->name);
        ibl_misuse("%s: no such command or file: commands are %s: see %s "
                   "--help",
                   words[0], names, ibl_this_program.name);
        return 2;
    }
    void *settings = ibl_need(calloc(1, cmd->settings_size));
    int status;

    if (ibl_command_line(cmd, cmd->name ? words + 1 : words, settings, &status))
        status = cmd->run(settings);
    if (cmd->release)
        cmd->release(settings);
    free(settings);
    return status;
}
