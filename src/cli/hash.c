/* SPDX-License-Identifier: MIT */
#include "cli/hash.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "cli/common_options.h"

enum {
    BUFFER_BYTES = 256 * 1024 /* fits in the L2 cache */
};

static void put_hash(XXH128_hash_t h, char hash[IBL_HASH_SIZE])
{
    snprintf(hash, IBL_HASH_SIZE, "%016llx%016llx",
             (unsigned long long)h.high64, (unsigned long long)h.low64);
}

void ibl_hash_bytes(const void *bytes, size_t size, char hash[IBL_HASH_SIZE])
{
    put_hash(XXH3_128bits(bytes, size), hash);
}

/* Hashes a file to its end. Returns 0 or an errno. */
static int hash_all(int fd, char hash[IBL_HASH_SIZE])
{
    XXH3_state_t *state = XXH3_createState();
    char *buffer = malloc(BUFFER_BYTES);
    int why = state && buffer ? 0 : ENOMEM;
    ssize_t got = 1;

    if (!why)
        XXH3_128bits_reset(state);
    while (!why && got) {
        got = read(fd, buffer, BUFFER_BYTES);
        if (got > 0)
            XXH3_128bits_update(state, buffer, (size_t)got);
        else if (got < 0 && errno != EINTR)
            why = errno;
    }
    if (!why)
        put_hash(XXH3_128bits_digest(state), hash);
    XXH3_freeState(state);
    free(buffer);
    return why;
}

bool ibl_hash_file(const char *path, char hash[IBL_HASH_SIZE])
{
    /* O_NONBLOCK: do not wait for the writer of a FIFO. */
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat st;
    int why;

    if (fd < 0 || fstat(fd, &st))
        why = errno;
    else if (!S_ISREG(st.st_mode))
        why = S_ISDIR(st.st_mode) ? EISDIR : EINVAL;
    else
        why = hash_all(fd, hash);
    if (fd >= 0)
        close(fd);
    errno = why;
    return !why;
}

void ibl_print_settings(FILE *to, ibl_isa isa, const ibl_given *given)
{
    const ibl_option *last = NULL;

    fprintf(to, "iblbake %s %s %s\n", IBL_VERSION, ibl_version_revision(),
            ibl_isa_arithmetic(isa));
    for (int n = 0; n < given->count; n++) {
        int next = -1;
        for (int i = 0; i < given->count; i++) {
            const ibl_option *o = given->list[i].option;
            if ((!last || o > last) &&
                (next < 0 || o < given->list[next].option))
                next = i;
        }
        if (next < 0)
            return;
        last = given->list[next].option;
        const char *value = given->list[next].value;
        if (!last->aside)
            fprintf(to, "--%s=%s\n", last->name, value ? value : "");
    }
}
