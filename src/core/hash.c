/* SPDX-License-Identifier: MIT */
#define _DEFAULT_SOURCE
#include "core/hash.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

/* The functions themselves, so that the library needs no other one. */
#define XXH_INLINE_ALL
#include <xxhash.h>

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

int ibl_hash_file(const char *path, char text[IBL_FILE_HASH])
{
    unsigned char buffer[1 << 15]; /* fits in the L1 cache */
    struct stat st;
    ssize_t got = -1;
    ibl_hash h;
    /* O_NONBLOCK: do not wait for the writer of a FIFO. */
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);

    ibl_hash_begin(&h);
    if (fd >= 0 && !fstat(fd, &st)) {
        errno = S_ISDIR(st.st_mode) ? EISDIR : EINVAL;
        while (S_ISREG(st.st_mode) &&
               ((got = read(fd, buffer, sizeof buffer)) > 0 ||
                (got < 0 && errno == EINTR)))
            ibl_hash_add(&h, buffer, got > 0 ? (size_t)got : 0);
    }
    const int why = errno;
    ibl_hash_end(&h, text);
    if (fd >= 0)
        close(fd);
    return got ? why : 0;
}
