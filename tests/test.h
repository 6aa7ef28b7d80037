/* SPDX-License-Identifier: MIT */
/*
 * A test program: functions that are tests, which run in the order of the file.
 *
 *     TEST(constant_map)
 *     {
 *         ... CHECK(x == y); ...
 *     }
 *
 * Arguments pick tests by name; none runs all. The last line printed is
 * "N passed, N failed, N skipped"; the exit status is 1 if any failed, or a
 * name is none. A test that ends the program, by a signal, a sanitizer or
 * exit(), is named with the last check that it came to.
 */
#ifndef TEST_H
#define TEST_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

#include "ibl/ibl.h"

/* Whether a sanitizer, or an emulator (check-arm64.sh then defines it), makes
 * everything many times slower: tests of many cases
 * then take some of them. TEST_RACES: whether it is ThreadSanitizer, the
 * slowest, which looks for races alone: of cases that differ by numbers and not
 * by what threads do, it takes the fewest. */
#ifdef TEST_SANITIZED
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TEST_SANITIZED 1
#elif defined(__has_feature)
#define TEST_SANITIZED                                                         \
    (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define TEST_SANITIZED 0
#endif
#ifdef __SANITIZE_THREAD__
#define TEST_RACES 1
#else
#define TEST_RACES 0
#endif

typedef struct test {
    const char *name;
    void (*run)(void);
    const char *place;
    bool slow; /* not run where IBL_TEST_QUICK is set, unless by name */
    int line;
    struct test *next;
} test;

/* The head of a test, and of one that is slow; both, with a name of its own. */
#define TEST(f) TEST_OF(f, #f, false)
#define TEST_SLOW(f) TEST_OF(f, #f, true)
#define TEST_OF(f, name, slow)                                                 \
    static void f(void);                                                       \
    __attribute__((constructor)) static void add_##f(void)                     \
    {                                                                          \
        static test t = {name, f, TEST_PLACE, slow, __LINE__, NULL};           \
        test_add(&t);                                                          \
    }                                                                          \
    static void f(void)
void test_add(test *t);

/* Where the running test is, by its checks. */
extern _Atomic(const char *) test_at;
#define TEST_PLACE __FILE__ ":" TEST_TEXT(__LINE__)
#define TEST_TEXT(line) TEST_TEXT_OF(line)
#define TEST_TEXT_OF(line) #line
#define TEST_HERE                                                              \
    atomic_store_explicit(&test_at, TEST_PLACE, memory_order_relaxed)

/* Runs before the tests, where a program has it. */
void test_setup(void);

/* A failed check ends nothing: the test goes on and counts as failed once. */
#define CHECK(expr) (TEST_HERE, test_check((expr), __FILE__, __LINE__, #expr))
/* CHECK, with a printf-style text of what was seen. */
#define CHECK_MSG(expr, ...)                                                   \
    (TEST_HERE, (expr) ? (void)0 : test_fail(__FILE__, __LINE__, __VA_ARGS__))
/* |a - b| <= tol, printing both; NaN fails. */
#define CHECK_NEAR(a, b, tol)                                                  \
    (TEST_HERE, test_near((a), (b), (tol), __FILE__, __LINE__, #a " = " #b))
/* Ends the running test if expr is false: for what later lines need. */
#define NEED(expr) (CHECK(expr) ? (void)0 : test_leave())

bool test_check(bool ok, const char *file, int line, const char *expr);
void test_fail(const char *file, int line, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));
bool test_near(double a, double b, double tol, const char *file, int line,
               const char *text);
/* Ends the running test as skipped, without one the program. */
void test_skip(const char *fmt, ...)
    __attribute__((format(printf, 1, 2), noreturn));
/* With IBL_TEST_VERBOSE=1 prints how near a result came to its bound. */
void test_measured(const char *what, double seen, double limit);
/* Ends the running test at once. */
void test_leave(void) __attribute__((noreturn));
/* Calls release(thing) after the running test, however that ends, or, deferred
 * before the first one, after the last; what came last goes first. */
void test_defer(void (*release)(void *thing), void *thing);
/* The same with a copy of the thing, which may be gone by then. */
void test_defer_copy(void (*release)(void *thing), const void *thing,
                     size_t size);
/* Zeroed memory until the running test ends; exits if there is none. */
void *test_alloc(size_t count, size_t size);
/* Formatted text until then. */
const char *test_text(const char *fmt, ...)
    __attribute__((format(printf, 1, 2)));
/* What they are given, freed after the running test. */
ibl_image test_image(ibl_image image);
ibl_cube test_cube(ibl_cube cube);
/* What main is, where a program has none of its own. */
int test_main(int argc, char **argv);

/* A seeded generator (splitmix64), the same on every machine. */
typedef struct test_random {
    uint64_t state;
} test_random;
uint64_t test_random_u64(test_random *r);
double test_random_unit(test_random *r); /* [0, 1) */
double test_random_between(test_random *r, double a, double b);
int test_random_below(test_random *r, int n); /* 0..n - 1 */

static inline double test_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* For what is measured: milliseconds of a clock, and the median of some
 * numbers, which are sorted then. */
double test_ms(clockid_t clock);
double test_median(double *values, int count);

/* A log callback (ibl_log_fn) that prints errors and warnings to stderr. */
void test_log(void *cookie, ibl_log_level level, const char *text);
/* A log callback that keeps the last line of each level in a test_messages. */
typedef struct test_messages {
    char text[3][1024];
} test_messages;
void test_keep(void *cookie, ibl_log_level level, const char *text);

/* Whether an error that was kept has these words. */
bool test_said(const test_messages *kept, const char *words);

/* Contexts are freed after the running test; none is a failure that exits. */
ibl_ctx *test_ctx_of(const ibl_ctx_options *opts);
/* One with test_log. */
ibl_ctx *test_ctx(int threads, ibl_isa isa);
/* The same with test_keep. */
ibl_ctx *test_keeping_ctx(int threads, test_messages *kept);
/* The next instruction set that this CPU has; after the last, IBL_ISA_COUNT. */
ibl_isa test_next_isa(ibl_isa isa);

/* Path of a file in data/, or of ../shared/data (NULL where it is absent);
 * tests run from the top folder. Static storage, overwritten by each call. */
const char *test_data(const char *name);
const char *test_shared_data(const char *name);
/* The test program's own folder, made on first use and removed at exit. */
const char *test_dir(void);

#endif
