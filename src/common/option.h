/* SPDX-License-Identifier: MIT */
/* Commands of a program and their options, as tables that the parser and --help
 * are made from. */
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
    IBL_OPTION_OTHER,  /* parse decides, with a value or (NULL) without */
    IBL_OPTION_HELP,   /* prints the command's help and ends; no value */
    IBL_OPTION_PRINT   /* print does, and the program ends; no value */
} ibl_option_kind;

typedef struct ibl_option {
    const char *name; /* without the dashes */
    char letter;      /* short form, or 0 */
    ibl_option_kind kind;
    const char *value; /* what the value is called; NULL for a flag */
    size_t offset;     /* of the field in the command's settings */
    double low, high;
    const char *const *choices; /* ended by NULL */
    /* Takes a value into the field or returns false. */
    bool (*parse)(void *field, const char *value);
    void (*print)(FILE *to);
    const char *allowed;  /* allowed values in words; NULL: from the rest */
    const char *standard; /* the default in words; NULL: from the field,
                             "": none to speak of */
    const char *help;
} ibl_option;

/* Rows of a table, for a field of IBL_SETTINGS, which is the settings' type. */
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

/* Options under one heading of --help, which neighbours with the same title
 * share. */
typedef struct ibl_section {
    const char *title;
    const ibl_option *options;
    int count;
} ibl_section;

#define IBL_SECTION(title, table)                                              \
    &(const ibl_section)                                                       \
    {                                                                          \
        (title), (table), (int)(sizeof(table) / sizeof *(table))               \
    }

/* A command of the program. */
typedef struct ibl_command {
    const char *name;     /* the first argument; NULL: what the program does
                             without one */
    const char *usage;    /* its arguments */
    const char *brief;    /* what it does, for the list of commands */
    const char *intro;    /* what --help begins with, as lines */
    const char *statuses; /* its exit statuses */
    const ibl_section *const *sections; /* ended by NULL */
    size_t settings_size;
    void (*defaults)(void *settings);
    /* Takes an argument that is no option. These two return false after one
     * line through ibl_misuse. */
    bool (*take)(void *settings, const char *word);
    /* Checks what can only be judged with every option known. */
    bool (*validate)(void *settings);
    /* Does it; returns the exit status. */
    int (*run)(const void *settings);
} ibl_command;

/* The program that this is linked into, which defines it. */
typedef struct ibl_program {
    const char *name;
    const ibl_command *const *commands; /* ended by NULL; the first has no
                                           name */
} ibl_program;
extern const ibl_program ibl_this_program;

/* Parses and does what the command line says; returns the exit status. A
 * command's name must be the first argument; else it is the first command. */
int ibl_command_main(int argc, char **argv);

/* Settings of a command (settings_size bytes) from words, ended by NULL, to
 * which their strings point. False: the program ends with *status, after --help
 * or its like or after a line on stderr. status NULL: the words are not those
 * of the command line; --help and its like are refused. */
bool ibl_command_line(const ibl_command *cmd, char **words, void *settings,
                      int *status);

/* The whole --help, from the tables; at most 80 columns. */
void ibl_command_help(const ibl_command *cmd, FILE *to);

/* Prints "PROGRAM: ..." on stderr; false. */
bool ibl_misuse(const char *fmt, ...) __attribute__((format(printf, 1, 2)));

/*
 * The number that text begins with, in low..high: decimal digits, '-' before
 * them and, of a real one, a point and an exponent. No blank, '+', 0x or word.
 * *end is what follows. False: there is none, and nothing is stored.
 */
bool ibl_number_int(const char *text, int low, int high, int *n,
                    const char **end);
bool ibl_number_real(const char *text, double low, double high, double *x,
                     const char **end);

/* The values that an option takes, in words ("" for a flag or text). */
void ibl_option_allowed(const ibl_option *opt, char *text, size_t size);

#endif
