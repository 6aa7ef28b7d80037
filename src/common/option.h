/* SPDX-License-Identifier: MIT */
/* Commands of a program and their options: tables for the parser and --help. */
#ifndef COMMON_OPTION_H
#define COMMON_OPTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

typedef enum ibl_option_kind {
    IBL_OPTION_FLAG,   /* int, set to 1; no value */
    IBL_OPTION_ON,     /* bool, set; no value */
    IBL_OPTION_OFF,    /* bool, cleared; no value */
    IBL_OPTION_INT,    /* int in low..high */
    IBL_OPTION_REAL,   /* double in low..high */
    IBL_OPTION_CHOICE, /* int or enumeration: index of the value in choices */
    IBL_OPTION_TEXT,   /* const char *, not empty */
    IBL_OPTION_PNG,    /* const char *, a name that ends in .png */
    IBL_OPTION_DIR,    /* const char *, a directory, so not "-" */
    IBL_OPTION_OTHER,  /* parse stores it; a NULL value if it has none */
    IBL_OPTION_HELP,   /* prints the command's help and ends; no value */
    IBL_OPTION_PRINT   /* calls print and ends; no value */
} ibl_option_kind;

typedef struct ibl_option {
    const char *name; /* without the dashes */
    char letter;      /* short form, or 0 */
    ibl_option_kind kind;
    const char *value; /* the value's name in --help; NULL: no value */
    size_t offset;     /* of the field in the command's settings */
    double low, high;
    const char *const *choices; /* ended by NULL */
    /* Stores a value in the field; false: the value is not allowed. */
    bool (*parse)(void *field, const char *value);
    void (*print)(FILE *to);
    const char *allowed;  /* values in words; NULL: from the members above */
    const char *standard; /* the default in words; NULL: from the field;
                             "": not shown */
    const char *help;
    bool aside; /* does not decide what is made: not in sidecars */
} ibl_option;

enum {
    IBL_MOST_GIVEN = 128
};

/* The options of a command line, each once, with its last value. */
typedef struct ibl_given {
    int count;
    struct {
        const ibl_option *option;
        const char *value; /* NULL: it takes none */
    } list[IBL_MOST_GIVEN];
} ibl_given;

/* Options that mean something only where some facts of the command line hold,
 * bits that each program defines, and what to say of them elsewhere. */
typedef struct ibl_rule {
    const char *options; /* names with blanks between them */
    unsigned where;      /* one of these facts is enough */
    const char *why;     /* and what to do */
} ibl_rule;

/* Members of a table's row, for a field of IBL_SETTINGS, the settings' type. */
#define IBL_AT(field) .offset = offsetof(IBL_SETTINGS, field)
#define IBL_FLAG(field) .kind = IBL_OPTION_FLAG, IBL_AT(field)
#define IBL_TEXT(field, what)                                                  \
    .kind = IBL_OPTION_TEXT, .value = (what), IBL_AT(field)
#define IBL_PNG(field, what)                                                   \
    .kind = IBL_OPTION_PNG, .value = (what), IBL_AT(field)
#define IBL_DIR(field) .kind = IBL_OPTION_DIR, .value = "DIR", IBL_AT(field)
#define IBL_INT(field, lo, hi)                                                 \
    .kind = IBL_OPTION_INT, .value = "N", IBL_AT(field), .low = (lo),          \
    .high = (hi)
#define IBL_REAL(field, what, lo, hi)                                          \
    .kind = IBL_OPTION_REAL, .value = (what), IBL_AT(field), .low = (lo),      \
    .high = (hi)
#define IBL_CHOICE(field, names)                                               \
    .kind = IBL_OPTION_CHOICE, .value = "NAME", IBL_AT(field),                 \
    .choices = (names)
#define IBL_OTHER(field, what, function)                                       \
    .kind = IBL_OPTION_OTHER, .value = (what), IBL_AT(field),                  \
    .parse = (function)

/* Options under a heading of --help; neighbours of one title share it. A row of
 * the table begins with an ibl_option. */
typedef struct ibl_section {
    const char *title;
    const void *options;
    int count;
    size_t row; /* bytes */
} ibl_section;

#define IBL_SECTION(title, table)                                              \
    &(const ibl_section)                                                       \
    {                                                                          \
        (title), (table), (int)(sizeof(table) / sizeof *(table)),              \
            sizeof *(table)                                                    \
    }

/* A command of the program. */
/* Options that went, or values as "name=value", with blanks between them, and
 * what to do. */
typedef struct ibl_gone {
    const char *words, *instead;
} ibl_gone;

typedef struct ibl_command {
    const char *name;     /* the first argument; NULL: the default command */
    const char *usage;    /* its arguments */
    const char *brief;    /* what it does, for the list of commands */
    const char *intro;    /* the first lines of --help, after the usage */
    const char *statuses; /* its exit statuses */
    const ibl_section *const *sections; /* ended by NULL */
    const ibl_gone *gone;               /* ended by words NULL; or NULL */
    size_t settings_size;
    size_t given; /* offset of an ibl_given in the settings; 0: none */
    void (*defaults)(void *settings); /* NULL: the settings stay */
    size_t words; /* offset of a char ** for the words; 0: none */
    /* Takes an argument that is no option; NULL: they are passed over. False
     * after one ibl_misuse. */
    bool (*take)(void *settings, const char *word);
    /* Checks the options together; may be NULL. False after one ibl_misuse. */
    bool (*validate)(void *settings);
    /* Runs the command; returns the exit status. */
    int (*run)(const void *settings);
    void (*release)(void *settings); /* may be NULL */
} ibl_command;

/* Each program defines ibl_this_program. */
typedef struct ibl_program {
    const char *name;
    const ibl_command *const *commands; /* ended by NULL; the first has no
                                           name */
} ibl_program;
extern const ibl_program ibl_this_program;

/* Whether a word, or NULL, is the name of a command. */
bool ibl_is_command(const char *word);

/* Runs the command that the first argument names, else the first command.
 * Returns the exit status. */
int ibl_command_main(int argc, char **argv);

/* Parses words, ended by NULL, into settings (settings_size bytes), whose
 * strings then point to the words. False after --help, --version or a line on
 * stderr: the program must end with *status. With status NULL (words that are
 * not the command line) --help and --version are refused. */
bool ibl_command_line(const ibl_command *cmd, char **words, void *settings,
                      int *status);

const ibl_option *ibl_section_at(const ibl_section *s, int i);
/* Option number n of all the command's sections; NULL: there are fewer. */
const ibl_option *ibl_option_at(const ibl_command *cmd, int n);
/* The option with this name or, if name is NULL, this letter; NULL: none. */
const ibl_option *ibl_option_find(const ibl_command *cmd, const char *name,
                                  size_t length, char letter);

/* Prints what may stand for the last of the words of a command line, a line
 * each, with a tab and what it is; nothing where that is a file. */
void ibl_complete(char **words);

/* Prints --help from the tables; at most 80 columns. */
void ibl_command_help(const ibl_command *cmd, FILE *to);

/* The value of an option that was given, "" if it takes none; else NULL. */
const char *ibl_given_value(const ibl_given *given, const char *name);
/* Whether an option was given. */
bool ibl_is_given(const ibl_given *given, const char *name);
/* The first of these options, names with blanks between them, that was given;
 * NULL: none. */
const char *ibl_given_of(const ibl_given *given, const char *options);
/* ibl_misuse of "--NAME VALUE: TEXT", of that option. */
bool ibl_refuse(const ibl_given *given, const char *options, const char *fmt,
                ...) __attribute__((format(printf, 3, 4)));
/* Refuses the first option that was given where its rules, which end with
 * options NULL, have no place for it: false after "--NAME VALUE: WHY". */
bool ibl_check_rules(const ibl_given *given, const ibl_rule *rules,
                     unsigned facts);

/* Prints "PROGRAM: ..." on stderr; returns false. */
bool ibl_misuse(const char *fmt, ...) __attribute__((format(printf, 1, 2)));
/* What precedes the text of every later ibl_misuse; "" at first. */
void ibl_misuse_prefix(const char *prefix);

/*
 * Parse the number at the start of text: decimal digits after an optional '-',
 * for a real one also a point and an exponent; no blank, '+', 0x or word. *end
 * points to the rest. False, nothing stored: no number, or not in low..high.
 */
bool ibl_number_int(const char *text, int low, int high, int *n,
                    const char **end);
bool ibl_number_real(const char *text, double low, double high, double *x,
                     const char **end);

/* Reads numbers in low..high with a character between them, at most `most`.
 * Returns their count; 0: the text is not that. */
int ibl_number_list(const char *text, char between, double low, double high,
                    double *list, int most);

/* The values that an option takes, in words ("" for a flag or text). */
void ibl_option_allowed(const ibl_option *opt, char *text, size_t size);

#endif
