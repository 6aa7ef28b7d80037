/* SPDX-License-Identifier: MIT */
/* getloadavg is no part of POSIX. */
#define _DEFAULT_SOURCE

#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "cli/bench.h"
#include "cli/version.h"

/* The value of the first "model name" of /proc/cpuinfo; other systems and
 * CPUs: the machine's kind. */
static void find_cpu(char *cpu, size_t size, const char *machine)
{
    FILE *f = fopen("/proc/cpuinfo", "r");
    char line[512];

    snprintf(cpu, size, "%s", machine);
    while (f && fgets(line, sizeof line, f))
        if (!strncmp(line, "model name", 10) && strchr(line, ':')) {
            const char *value = strchr(line, ':') + 1;
            value += strspn(value, " \t");
            snprintf(cpu, size, "%.*s", (int)strcspn(value, "\n"), value);
            break;
        }
    if (f)
        fclose(f);
}

void ibl_bench_machine_find(ibl_bench_machine *m)
{
    const time_t now = time(NULL);
    struct utsname name;
    struct tm utc;

    *m = (ibl_bench_machine){.cpus = ibl_cpu_count()};
    if (uname(&name) >= 0) {
        snprintf(m->system, sizeof m->system, "%.40s %.60s %.20s", name.sysname,
                 name.release, name.machine);
        find_cpu(m->cpu, sizeof m->cpu, name.machine);
    }
    snprintf(m->compiler, sizeof m->compiler, "%s", ibl_version_compiler());
    snprintf(m->revision, sizeof m->revision, "%s", ibl_version_revision());
    if (gmtime_r(&now, &utc))
        strftime(m->date, sizeof m->date, "%Y-%m-%d %H:%M UTC", &utc);
    m->online_cpus = (int)sysconf(_SC_NPROCESSORS_ONLN);
    m->memory_bytes =
        (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    if (getloadavg(&m->load, 1) != 1)
        m->load = -1;
}
