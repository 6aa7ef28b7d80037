/* SPDX-License-Identifier: MIT */
/*
 * Windows, from 10 on. Paths are UTF-8, as packaging/windows.manifest asks of
 * the system; in another program that uses the library they are of its code
 * page.
 */
#include "port/windows.h"
#undef _WIN32_WINNT
#define _WIN32_WINNT 0x0A00
#include "port/port.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <locale.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#include <winioctl.h>

enum {
    NAP_MS = 5,
    TRIES = 200, /* naps until a file that others read must be replaceable */
    FOLDERS = 1024
};

/* msvcrt expands * and ? in arguments, as shells do elsewhere. */
int _dowildcard = -1;

/* False, and errno is as the last call's error says. */
static bool fail(void)
{
    static const int of[][2] = {{ERROR_FILE_NOT_FOUND, ENOENT},
                                {ERROR_PATH_NOT_FOUND, ENOENT},
                                {ERROR_INVALID_NAME, ENOENT},
                                {ERROR_BAD_NETPATH, ENOENT},
                                {ERROR_ALREADY_EXISTS, EEXIST},
                                {ERROR_FILE_EXISTS, EEXIST},
                                {ERROR_DISK_FULL, ENOSPC},
                                {ERROR_HANDLE_DISK_FULL, ENOSPC},
                                {ERROR_ACCESS_DENIED, EACCES},
                                {ERROR_SHARING_VIOLATION, EACCES},
                                {ERROR_DIRECTORY, ENOTDIR},
                                {ERROR_WRITE_PROTECT, EROFS},
                                {ERROR_FILENAME_EXCED_RANGE, ENAMETOOLONG}};
    const int error = (int)GetLastError();

    errno = EIO;
    for (size_t i = 0; i < sizeof of / sizeof *of; i++)
        if (of[i][0] == error)
            errno = of[i][1];
    return false;
}

/* ---- files --------------------------------------------------------------- */

/* What is open may be renamed, replaced and removed, as in POSIX. Folders are
 * opened, too. */
static HANDLE open_path(const char *path, DWORD access, DWORD how)
{
    return CreateFileA(
        path, access, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
        NULL, how, FILE_ATTRIBUTE_NORMAL | FILE_FLAG_BACKUP_SEMANTICS, NULL);
}

static int number_of(HANDLE file, int flags)
{
    const int fd = file == INVALID_HANDLE_VALUE
                       ? -1
                       : _open_osfhandle((intptr_t)file, flags);
    if (fd < 0 && file != INVALID_HANDLE_VALUE)
        CloseHandle(file);
    return fd;
}

int ibl_port_open(const char *path)
{
    const HANDLE file = open_path(path, GENERIC_READ, OPEN_EXISTING);

    if (file == INVALID_HANDLE_VALUE)
        fail();
    return number_of(file, _O_RDONLY | _O_BINARY);
}

int ibl_port_create(const char *path)
{
    const HANDLE file = open_path(path, GENERIC_WRITE, CREATE_NEW);

    if (file == INVALID_HANDLE_VALUE)
        fail();
    return number_of(file, _O_WRONLY | _O_BINARY);
}

bool ibl_port_readable(int file, int milliseconds)
{
    const HANDLE pipe = (HANDLE)_get_osfhandle(file);
    DWORD there = 0;

    if (GetFileType(pipe) != FILE_TYPE_PIPE)
        return true;
    while (PeekNamedPipe(pipe, NULL, 0, NULL, &there, NULL) && !there) {
        if (milliseconds <= 0)
            return false;
        Sleep(NAP_MS);
        milliseconds -= NAP_MS;
    }
    return true; /* or its end */
}

ptrdiff_t ibl_port_read_at(int file, void *to, size_t size, uint64_t offset)
{
    OVERLAPPED at = {.Offset = (DWORD)offset,
                     .OffsetHigh = (DWORD)(offset >> 32)};
    DWORD got = 0;

    if (ReadFile((HANDLE)_get_osfhandle(file), to,
                 size < MAXLONG ? (DWORD)size : MAXLONG, &got, &at) ||
        GetLastError() == ERROR_HANDLE_EOF)
        return got;
    fail();
    return -1;
}

bool ibl_port_flush(int file)
{
    return FlushFileBuffers((HANDLE)_get_osfhandle(file)) || fail();
}

/* Programs that look at each new file, as for viruses, hold it for a moment. */
bool ibl_port_replace(const char *from, const char *to)
{
    for (int i = 0; !MoveFileExA(from, to, MOVEFILE_REPLACE_EXISTING); i++) {
        const DWORD error = GetLastError();
        if (i == TRIES ||
            (error != ERROR_ACCESS_DENIED && error != ERROR_SHARING_VIOLATION))
            return fail();
        Sleep(NAP_MS);
    }
    return true;
}

bool ibl_port_make_folder(const char *path)
{
    return CreateDirectoryA(path, NULL) || fail();
}

size_t ibl_port_root(const char *path)
{
    size_t n = 2;

    if (*path && path[1] == ':')
        return path[2] == '/' ? 3 : 2;
    if (strncmp(path, "//", 2) != 0)
        return *path == '/';
    for (int names = 0; names < 2; names++) {
        n += strcspn(path + n, "/");
        n += path[n] == '/';
    }
    return n;
}

/* Of ticks of 100 ns since 1601. */
static int64_t nanoseconds(LARGE_INTEGER ticks)
{
    return (ticks.QuadPart - 116444736000000000) * 100;
}

bool ibl_port_identify(const char *path, ibl_port_file *file)
{
    const HANDLE h = open_path(path, 0, OPEN_EXISTING);
    BY_HANDLE_FILE_INFORMATION info;
    FILE_BASIC_INFO times;

    *file = (ibl_port_file){0};
    if (h == INVALID_HANDLE_VALUE)
        return fail();
    const bool ok = (GetFileInformationByHandle(h, &info) &&
                     GetFileInformationByHandleEx(h, FileBasicInfo, &times,
                                                  sizeof times)) ||
                    fail();
    if (ok)
        *file = (ibl_port_file){
            .device = info.dwVolumeSerialNumber,
            .number = (uint64_t)info.nFileIndexHigh << 32 | info.nFileIndexLow,
            .size = (uint64_t)info.nFileSizeHigh << 32 | info.nFileSizeLow,
            .written = nanoseconds(times.LastWriteTime),
            .changed =
                nanoseconds(times.ChangeTime.QuadPart ? times.ChangeTime
                                                      : times.LastWriteTime)};
    CloseHandle(h);
    return ok;
}

bool ibl_port_is_link(const char *path)
{
    WIN32_FIND_DATAA found;
    const DWORD attributes = GetFileAttributesA(path);

    if (attributes == INVALID_FILE_ATTRIBUTES ||
        !(attributes & FILE_ATTRIBUTE_REPARSE_POINT))
        return false;
    const HANDLE h = FindFirstFileA(path, &found);
    if (h == INVALID_HANDLE_VALUE)
        return false;
    FindClose(h);
    return found.dwReserved0 == IO_REPARSE_TAG_SYMLINK ||
           found.dwReserved0 == IO_REPARSE_TAG_MOUNT_POINT;
}

static char *use_slashes(char *path)
{
    for (char *c = path; (c = strchr(c, '\\')); c++)
        *c = '/';
    return path;
}

bool ibl_port_resolve(const char *path, char real[IBL_PORT_PATH])
{
    const HANDLE h = open_path(path, 0, OPEN_EXISTING);
    const DWORD length =
        h == INVALID_HANDLE_VALUE
            ? 0
            : GetFinalPathNameByHandleA(h, real, IBL_PORT_PATH, 0);
    const bool ok = (length && length < IBL_PORT_PATH) || fail();

    if (h != INVALID_HANDLE_VALUE)
        CloseHandle(h);
    if (!ok)
        return false;
    /* It begins with \\?\, or with \\?\UNC\ of another machine's. */
    use_slashes(real);
    if (!strncmp(real, "//?/UNC/", 8))
        memmove(real + 2, real + 8, strlen(real + 8) + 1);
    else if (!strncmp(real, "//?/", 4))
        memmove(real, real + 4, strlen(real + 4) + 1);
    return true;
}

/* ---- folders ------------------------------------------------------------- */

/* Folders have no locks: a mutex of the folder's name among files is one. It
 * goes with the last process that has it open. */
static struct folder {
    bool open;
    ibl_port_file which;
    HANDLE lock; /* NULL: it is not locked */
} folders[FOLDERS];
static pthread_mutex_t table = PTHREAD_MUTEX_INITIALIZER;

int ibl_port_open_folder(const char *path)
{
    ibl_port_file which;
    int n = 0;

    if (!ibl_port_identify(path, &which))
        return -1;
    pthread_mutex_lock(&table);
    while (n < FOLDERS && folders[n].open)
        n++;
    if (n < FOLDERS)
        folders[n] = (struct folder){.open = true, .which = which};
    pthread_mutex_unlock(&table);
    errno = EMFILE;
    return n < FOLDERS ? n : -1;
}

bool ibl_port_identify_folder(int folder, ibl_port_file *file)
{
    *file = folders[folder].which;
    return true;
}

bool ibl_port_lock_folder(int folder, bool wait)
{
    const ibl_port_file *f = &folders[folder].which;
    char name[64];

    snprintf(name, sizeof name, "Global\\iblbake-%08llx-%016llx",
             (unsigned long long)f->device, (unsigned long long)f->number);
    const HANDLE lock = CreateMutexA(NULL, FALSE, name);
    if (!lock) /* another user's */
        return true;
    const DWORD got = WaitForSingleObject(lock, wait ? INFINITE : 0);
    if (got == WAIT_OBJECT_0 || got == WAIT_ABANDONED)
        folders[folder].lock = lock;
    else
        CloseHandle(lock);
    return got != WAIT_TIMEOUT;
}

/* File systems of Windows keep a journal of names. */
bool ibl_port_flush_folder(int folder)
{
    (void)folder;
    return true;
}

void ibl_port_close_folder(int folder)
{
    struct folder *f = &folders[folder];

    if (f->lock) {
        ReleaseMutex(f->lock);
        CloseHandle(f->lock);
    }
    pthread_mutex_lock(&table);
    *f = (struct folder){0};
    pthread_mutex_unlock(&table);
}

/* ---- memory, threads ----------------------------------------------------- */

void *ibl_port_alloc(size_t alignment, size_t bytes)
{
    return _aligned_malloc(bytes, alignment);
}

void ibl_port_free(void *p)
{
    _aligned_free(p);
}

uint64_t ibl_port_memory(void)
{
    MEMORYSTATUSEX status = {.dwLength = sizeof status};
    return GlobalMemoryStatusEx(&status) ? status.ullTotalPhys : 0;
}

int ibl_port_cpus(void)
{
    DWORD_PTR own, all;

    /* 0: more than 64, in groups. */
    if (GetProcessAffinityMask(GetCurrentProcess(), &own, &all) && own)
        return __builtin_popcountll(own);
    return (int)GetActiveProcessorCount(ALL_PROCESSOR_GROUPS);
}

int ibl_port_cpu_quota(const char *root)
{
    (void)root;
    return 0;
}

/* Containers are jobs. */
uint64_t ibl_port_memory_quota(const char *root)
{
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION job;
    uint64_t limit = 0;

    if (*root ||
        !QueryInformationJobObject(NULL, JobObjectExtendedLimitInformation,
                                   &job, sizeof job, NULL))
        return 0;
    if (job.BasicLimitInformation.LimitFlags & JOB_OBJECT_LIMIT_JOB_MEMORY)
        limit = job.JobMemoryLimit;
    if (job.BasicLimitInformation.LimitFlags &
            JOB_OBJECT_LIMIT_PROCESS_MEMORY &&
        (!limit || job.ProcessMemoryLimit < limit))
        limit = job.ProcessMemoryLimit;
    return limit;
}

bool ibl_port_start(pthread_t *thread, void *(*run)(void *), void *arg)
{
    return !pthread_create(thread, NULL, run, arg);
}

/* ---- signals, the program ------------------------------------------------ */

static void (*leaving)(void);
static _Thread_local bool held;

/* Ctrl-C comes on a thread of its own, which waits for changes of others. */
void ibl_port_hold_signals(void)
{
    held = true;
}

void ibl_port_release_signals(void)
{
    held = false;
}

/* Also the end of the console, of the user's session or of the system. Ends the
 * program as the system's own handler does. */
static BOOL WINAPI interrupted(DWORD event)
{
    (void)event;
    leaving();
    ExitProcess((UINT)STATUS_CONTROL_C_EXIT);
}

static void aborted(int number)
{
    (void)number;
    if (!held)
        leaving();
}

void ibl_port_catch_signals(void (*leave)(void))
{
    leaving = leave;
    SetConsoleCtrlHandler(interrupted, TRUE);
    signal(SIGABRT, aborted);
}

static UINT code_page; /* of the console, before */

static void restore_console(void)
{
    SetConsoleOutputCP(code_page);
}

void ibl_port_begin(int argc, char **argv)
{
    for (int fd = 0; fd < 3; fd++)
        if (_setmode(fd, _O_BINARY) < 0 &&
            _open("NUL", fd ? _O_RDONLY : _O_WRONLY) < 0)
            break; /* no other file can be opened either */
    _fmode = _O_BINARY;
    for (int i = 1; i < argc; i++)
        use_slashes(argv[i]);
    code_page = GetConsoleOutputCP();
    if (code_page && SetConsoleOutputCP(CP_UTF8))
        atexit(restore_console);
}

bool ibl_port_program(char *path, size_t size)
{
    const DWORD length = GetModuleFileNameA(NULL, path, (DWORD)size);

    return length && length < size && use_slashes(path);
}

void ibl_port_progress(double done)
{
    (void)done;
}

const char *ibl_port_name(void)
{
    return "iblbake";
}

void ibl_port_place(char text[IBL_PORT_PATH])
{
    DWORD size = IBL_PORT_PATH;

    if (!GetComputerNameExA(ComputerNameDnsHostname, text, &size))
        *text = '\0';
}

bool ibl_port_is_gone(long process)
{
    const HANDLE h = OpenProcess(SYNCHRONIZE, FALSE, (DWORD)process);

    if (!h)
        return GetLastError() == ERROR_INVALID_PARAMETER;
    const bool ended = WaitForSingleObject(h, 0) == WAIT_OBJECT_0;
    CloseHandle(h);
    return ended;
}

/* A program that uses the library may have another locale. */
double ibl_port_number(const char *text, char **end)
{
    const char point = *localeconv()->decimal_point;
    char copy[512];

    if (point == '.')
        return strtod(text, end);
    snprintf(copy, sizeof copy, "%s", text);
    for (char *c = copy; *c; c++)
        *c = *c == '.' ? point : *c == point ? '\0' : *c;
    const double value = strtod(copy, end);
    *end = (char *)text + (*end - copy);
    return value;
}

/* ---- functions that the C library lacks ---------------------------------- */

char *strcasestr(const char *text, const char *part)
{
    const size_t length = strlen(part);

    while (_strnicmp(text, part, length) != 0)
        if (!*text++)
            return NULL;
    return (char *)text;
}

void *memmem(const void *bytes, size_t size, const void *part, size_t length)
{
    for (const char *at = bytes; size >= length; at++, size--)
        if (!memcmp(at, part, length))
            return (void *)at;
    return NULL;
}
