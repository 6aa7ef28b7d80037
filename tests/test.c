/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE /* vasprintf */
#include "test.h"

#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const char *running;
static bool failed, skipped;
static char dir[256];

bool test_check(bool ok, const char *file, int line, const char *expr)
{
    if (!ok)
        test_fail(file, line, "%s", expr);
    return ok;
}

void test_fail(const char *file, int line, const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    printf("%s:%d: %s: ", file, line, running);
    vprintf(fmt, ap);
    putchar('\n');
    va_end(ap);
    failed = true;
}

bool test_near(double a, double b, double tol, const char *file, int line,
               const char *text)
{
    const bool ok = fabs(a - b) <= tol;
    if (!ok)
        test_fail(file, line, "%s: %.9g and %.9g differ by %.3g > %.3g", text,
                  a, b, fabs(a - b), tol);
    return ok;
}

/* ---- the end of a test ------------------------------------------------ */

typedef struct deferred {
    struct deferred *before;
    void (*release)(void *thing);
    void *thing;
} deferred;

static jmp_buf leave;
static deferred *last_deferred;

void test_leave(void)
{
    longjmp(leave, 1);
}

void test_skip(const char *fmt, ...)
{
    va_list ap;
    va_start(ap, fmt);
    printf("skipped%s%s: ", running ? " " : "", running ? running : "");
    vprintf(fmt, ap);
    putchar('\n');
    va_end(ap);
    if (!running) {
        printf("0 passed, 0 failed, 1 skipped\n");
        exit(0);
    }
    skipped = true;
    test_leave();
}

void test_defer(void (*release)(void *thing), void *thing)
{
    deferred *d = malloc(sizeof *d);

    if (!d)
        exit(1);
    *d = (deferred){last_deferred, release, thing};
    last_deferred = d;
}

void *test_alloc(size_t count, size_t size)
{
    void *memory = calloc(count, size);

    if (!memory)
        exit(1);
    test_defer(free, memory);
    return memory;
}

const char *test_text(const char *fmt, ...)
{
    char *text;
    va_list ap;

    va_start(ap, fmt);
    if (vasprintf(&text, fmt, ap) < 0)
        exit(1);
    va_end(ap);
    test_defer(free, text);
    return text;
}

void test_defer_copy(void (*release)(void *thing), const void *thing,
                     size_t size)
{
    void *copy = test_alloc(1, size);

    memcpy(copy, thing, size);
    test_defer(release, copy);
}

static void free_image(void *image)
{
    ibl_image_free(image);
}

ibl_image test_image(ibl_image image)
{
    test_defer_copy(free_image, &image, sizeof image);
    return image;
}

static void free_cube(void *cube)
{
    ibl_cube_free(cube);
}

ibl_cube test_cube(ibl_cube cube)
{
    test_defer_copy(free_cube, &cube, sizeof cube);
    return cube;
}

/* Down to what was deferred before. */
static void release_until(const deferred *before)
{
    while (last_deferred != before) {
        deferred *d = last_deferred;
        last_deferred = d->before;
        d->release(d->thing);
        free(d);
    }
}

static void run(const test *t)
{
    const deferred *before = last_deferred;

    if (!setjmp(leave))
        t->run();
    release_until(before);
}

/* ---- a test that ends the program ------------------------------------ */

_Atomic(const char *) test_at;
static pid_t process;

static void say(const char *text)
{
    if (write(STDOUT_FILENO, text, strlen(text)) < 0)
        return;
}

/* Says once where the running test was; may be called by signal handlers. */
static void tell_end(const char *how)
{
    const char *name = running;

    running = NULL;
    if (!name || getpid() != process)
        return;
    say(atomic_load_explicit(&test_at, memory_order_relaxed));
    say(": ");
    say(name);
    say(": ended here or after it by ");
    say(how);
    say("\n");
}

static void tell_exit(void)
{
    tell_end("exit()");
}

static void tell_sanitizer(void)
{
    tell_end("a sanitizer");
}

static const struct {
    int number;
    const char *name;
} deadly[] = {{SIGABRT, "SIGABRT"}, {SIGSEGV, "SIGSEGV"}, {SIGBUS, "SIGBUS"},
              {SIGFPE, "SIGFPE"},   {SIGILL, "SIGILL"},   {SIGTRAP, "SIGTRAP"}};
enum {
    DEADLY = sizeof deadly / sizeof *deadly
};

static void tell_signal(int number)
{
    for (int i = 0; i < DEADLY; i++)
        if (deadly[i].number == number)
            tell_end(deadly[i].name);
    raise(number);
}

/* Sanitizers have it, and call the function before they end the program. */
void __sanitizer_set_death_callback(void (*call)(void)) __attribute__((weak));

static void tell_of_ends(void)
{
    static char stack[1 << 16]; /* where the test's own is used up */
    const stack_t own = {.ss_sp = stack, .ss_size = sizeof stack};
    const struct sigaction tell = {.sa_handler = tell_signal,
                                   .sa_flags = (int)SA_RESETHAND | SA_ONSTACK};
    struct sigaction before;

    process = getpid();
    atexit(tell_exit);
    if (__sanitizer_set_death_callback)
        __sanitizer_set_death_callback(tell_sanitizer);
    else
        sigaltstack(&own, NULL);
    /* But those that a sanitizer has. */
    for (int i = 0; i < DEADLY; i++)
        if (!sigaction(deadly[i].number, NULL, &before) &&
            before.sa_handler == SIG_DFL)
            sigaction(deadly[i].number, &tell, NULL);
}

/* ---- all of them ------------------------------------------------------ */

static bool picked(int argc, char **argv, const test *t)
{
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], t->name))
            return true;
    }
    return argc < 2 && !(t->slow && getenv("IBL_TEST_QUICK"));
}

/* The time of all threads, which a busy machine does not lengthen. */
static double cpu_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static test *tests;

void test_add(test *t)
{
    test **at = &tests;

    while (*at && (*at)->line < t->line)
        at = &(*at)->next;
    t->next = *at;
    *at = t;
}

/* Whether each name is a test's. */
static bool known(int argc, char **argv)
{
    bool all = true;

    for (int i = 1; i < argc; i++) {
        const test *t = tests;
        while (t && strcmp(argv[i], t->name) != 0)
            t = t->next;
        if (!t)
            printf("%s: no test has that name\n", argv[i]);
        all &= t != NULL;
    }
    return all;
}

__attribute__((weak)) void test_setup(void)
{
}

int test_main(int argc, char **argv)
{
    const bool times = getenv("IBL_TEST_TIMES") != NULL;
    int n_passed = 0, n_failed = 0, n_skipped = 0;
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (!known(argc, argv))
        return 1;
    tell_of_ends();
    test_setup();
    for (const test *t = tests; t; t = t->next) {
        if (!picked(argc, argv, t))
            continue;
        running = t->name;
        test_at = t->place;
        failed = skipped = false;
        const double begin = cpu_seconds();
        run(t);
        if (times)
            printf("%8.2f s %s\n", cpu_seconds() - begin, running);
        if (failed) {
            printf("FAILED %s\n", running);
            n_failed++;
        } else if (skipped) {
            n_skipped++;
        } else {
            n_passed++;
        }
    }
    running = NULL;
    release_until(NULL);
    printf("%d passed, %d failed, %d skipped\n", n_passed, n_failed, n_skipped);
    return n_failed > 0 || n_passed + n_skipped == 0;
}

__attribute__((weak)) int main(int argc, char **argv)
{
    return test_main(argc, argv);
}

uint64_t test_random_u64(test_random *r)
{
    uint64_t z = r->state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
}

double test_random_unit(test_random *r)
{
    return (double)(test_random_u64(r) >> 11) * 0x1p-53;
}

double test_random_between(test_random *r, double a, double b)
{
    return a + (b - a) * test_random_unit(r);
}

int test_random_below(test_random *r, int n)
{
    return (int)(test_random_u64(r) % (uint64_t)n);
}

void test_log(void *cookie, ibl_log_level level, const char *text)
{
    (void)cookie;
    if (level != IBL_LOG_INFO)
        fprintf(stderr, "%s: %s\n",
                level == IBL_LOG_ERROR ? "error" : "warning", text);
}

void test_keep(void *cookie, ibl_log_level level, const char *text)
{
    test_messages *kept = cookie;
    snprintf(kept->text[level], sizeof kept->text[level], "%s", text);
}

double test_ms(clockid_t clock)
{
    struct timespec t;

    clock_gettime(clock, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void test_measured(const char *what, double seen, double limit)
{
    const char *verbose = getenv("IBL_TEST_VERBOSE");
    if (verbose && *verbose && *verbose != '0')
        printf("%s: %.3g of %.3g\n", what, seen, limit);
}

double test_median(double *values, int count)
{
    const int half = count / 2;

    qsort(values, (size_t)count, sizeof *values, by_value);
    return count % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

bool test_said(const test_messages *kept, const char *words)
{
    return strstr(kept->text[IBL_LOG_ERROR], words) != NULL;
}

static void free_ctx(void *ctx)
{
    ibl_ctx_free(ctx);
}

ibl_ctx *test_ctx_of(const ibl_ctx_options *opts)
{
    ibl_ctx *ctx;

    if (ibl_ctx_create(opts, &ctx)) {
        printf("no context\n");
        exit(1);
    }
    test_defer(free_ctx, ctx);
    return ctx;
}

ibl_ctx *test_ctx(int threads, ibl_isa isa)
{
    ibl_ctx_options opts = ibl_ctx_options_default();

    opts.threads = threads;
    opts.isa = isa;
    opts.log = test_log;
    return test_ctx_of(&opts);
}

ibl_isa test_next_isa(ibl_isa isa)
{
    do
        isa++;
    while (isa < IBL_ISA_COUNT && !ibl_isa_supported(isa));
    return isa;
}

ibl_ctx *test_keeping_ctx(int threads, test_messages *kept)
{
    ibl_ctx_options opts = ibl_ctx_options_default();

    opts.threads = threads;
    opts.log = test_keep;
    opts.log_cookie = kept;
    return test_ctx_of(&opts);
}

const char *test_data(const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "data/%s", name);
    return path;
}

const char *test_shared_data(const char *name)
{
    static char path[256];
    snprintf(path, sizeof path, "../shared/data/%s", name);
    return access(path, R_OK) ? NULL : path;
}

static void remove_dir(void)
{
    char command[300];
    snprintf(command, sizeof command, "rm -rf '%s'", dir);
    if (system(command))
        fprintf(stderr, "could not remove %s\n", dir);
}

const char *test_dir(void)
{
    if (!dir[0]) {
        const char *base = getenv("TMPDIR");
        snprintf(dir, sizeof dir, "%s/iblbake-test-XXXXXX",
                 base ? base : "/tmp");
        if (!mkdtemp(dir)) {
            perror(dir);
            exit(1);
        }
        atexit(remove_dir);
    }
    return dir;
}
