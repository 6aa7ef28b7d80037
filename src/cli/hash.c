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

static void put_hash(XXH128_hash_t h, char hash[IBL_HASH_SIZE])
{
    snprintf(hash, IBL_HASH_SIZE, "%016llx%016llx",
             (unsigned long long)h.high64, (unsigned long long)h.low64);
}

void ibl_hash_bytes(const void *bytes, size_t size, char hash[IBL_HASH_SIZE])
{
    put_hash(XXH3_128bits(bytes, size), hash);
}

bool ibl_hash_file(const char *path, char hash[IBL_HASH_SIZE])
{
    XXH3_state_t *state = XXH3_createState();
    unsigned char buffer[1 << 15]; /* fits in the L1 cache */
    struct stat st;
    ssize_t got = -1;
    /* O_NONBLOCK: do not wait for the writer of a FIFO. */
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);

    if (state && fd >= 0 && !fstat(fd, &st)) {
        errno = S_ISDIR(st.st_mode) ? EISDIR : EINVAL;
        XXH3_128bits_reset(state);
        while (S_ISREG(st.st_mode) &&
               ((got = read(fd, buffer, sizeof buffer)) > 0 ||
                (got < 0 && errno == EINTR)))
            XXH3_128bits_update(state, buffer, got > 0 ? (size_t)got : 0);
    }
    if (!got)
        put_hash(XXH3_128bits_digest(state), hash);
    const int why = state ? errno : ENOMEM;
    if (fd >= 0)
        close(fd);
    XXH3_freeState(state);
    errno = why;
    return !got;
}

void ibl_print_settings(FILE *to, ibl_isa isa, const ibl_command *command,
                        const ibl_given *given)
{
    fprintf(to, "iblbake %s %s %s\n", IBL_VERSION, ibl_version_revision(),
            ibl_isa_arithmetic(isa));
    for (const ibl_section *const *s = command->sections; *s; s++)
        for (int i = 0; i < (*s)->count; i++) {
            const ibl_option *o = &(*s)->options[i];
            const char *value = ibl_given_value(given, o->name);
            if (value && !o->aside)
                fprintf(to, "--%s=%s\n", o->name, value);
        }
}
