/* SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE
#include "core/hash.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

/* The functions themselves, so that the library needs no other one. */
#define XXH_INLINE_ALL
#include <xxhash.h>

enum {
    BUFFER_BYTES = 256 * 1024 /* fits in the L2 cache */
};

_Static_assert(sizeof(XXH3_state_t) <= sizeof(ibl_hash), "no room for XXH3");

void ibl_hash_begin(ibl_hash *h)
{
    XXH3_128bits_reset((XXH3_state_t *)h->state);
}

void ibl_hash_add(ibl_hash *h, const void *bytes, size_t size)
{
    XXH3_128bits_update((XXH3_state_t *)h->state, bytes, size);
}

void ibl_hash_end(const ibl_hash *h, char text[IBL_FILE_HASH])
{
    const XXH128_hash_t x = XXH3_128bits_digest((const XXH3_state_t *)h->state);

    snprintf(text, IBL_FILE_HASH, "%016llx%016llx",
             (unsigned long long)x.high64, (unsigned long long)x.low64);
}

void ibl_hash_bytes(const void *bytes, size_t size, char text[IBL_FILE_HASH])
{
    ibl_hash h;

    ibl_hash_begin(&h);
    ibl_hash_add(&h, bytes, size);
    ibl_hash_end(&h, text);
}

/* Hashes a file to its end. Returns 0 or an errno. */
static int hash_all(int fd, char text[IBL_FILE_HASH])
{
    char *buffer = malloc(BUFFER_BYTES);
    int why = buffer ? 0 : ENOMEM;
    ssize_t got = 1;
    ibl_hash h;

    ibl_hash_begin(&h);
    while (!why && got) {
        got = read(fd, buffer, BUFFER_BYTES);
        if (got > 0)
            ibl_hash_add(&h, buffer, (size_t)got);
        else if (got < 0 && errno != EINTR)
            why = errno;
    }
    ibl_hash_end(&h, text);
    free(buffer);
    return why;
}

int ibl_hash_file(const char *path, char text[IBL_FILE_HASH])
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
        why = hash_all(fd, text);
    if (fd >= 0)
        close(fd);
    return why;
}
