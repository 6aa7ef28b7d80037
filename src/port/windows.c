/* SPDX-License-Identifier: MIT */
/*
 * Windows, from 10 on. Paths are UTF-8, as packaging/windows.manifest asks, or
 * of the code page of another program that uses the library.
 */
#include "port/port.h"

#include <errno.h>
#include <io.h>
#include <string.h>

#define WIN32_LEAN_AND_MEAN
#include <windows.h>

enum {
    NAP_MS = 5,
    TRIES = 200 /* naps until a file that others read must be replaceable */
};

/* msvcrt expands * and ? in arguments, as shells do elsewhere. */
int _dowildcard = -1;

/* -1, and errno is as the last call's error says. */
static int fail(void)
{
    static const int of[][2] = {{ERROR_FILE_NOT_FOUND, ENOENT},
                                {ERROR_PATH_NOT_FOUND, ENOENT},
                                {ERROR_INVALID_NAME, ENOENT},
                                {ERROR_BAD_NETPATH, ENOENT},
                                {ERROR_ALREADY_EXISTS, EEXIST},
                                {ERROR_FILE_EXISTS, EEXIST},
                                {ERROR_SHARING_VIOLATION, EACCES},
                                {ERROR_ACCESS_DENIED, EACCES},
                                {ERROR_DISK_FULL, ENOSPC},
                                {ERROR_WRITE_PROTECT, EROFS},
                                {ERROR_FILENAME_EXCED_RANGE, ENAMETOOLONG}};
    const int error = (int)GetLastError();

    errno = EIO;
    for (size_t i = 0; i < sizeof of / sizeof *of; i++)
        if (of[i][0] == error)
            errno = of[i][1];
    return -1;
}

/* ---- files --------------------------------------------------------------- */

/* What is open may be renamed, replaced and removed, as in POSIX. Folders are
 * opened, too. */
static HANDLE open_path(const char *path, DWORD access, DWORD how, DWORD flags)
{
    return CreateFileA(path, access,
                       FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
                       NULL, how, FILE_FLAG_BACKUP_SEMANTICS | flags, NULL);
}

static int number_of(HANDLE file)
{
    return file == INVALID_HANDLE_VALUE
               ? fail()
               : _open_osfhandle((intptr_t)file, O_BINARY);
}

int ibl_open(const char *path, int flags, ...)
{
    const bool made = flags & O_CREAT;
    const HANDLE file = open_path(path, made ? GENERIC_WRITE : GENERIC_READ,
                                  made ? CREATE_NEW : OPEN_EXISTING, 0);

    return number_of(file);
}

ssize_t pread(int file, void *to, size_t size, off_t offset)
{
    OVERLAPPED at = {.Offset = (DWORD)offset,
                     .OffsetHigh = (DWORD)((uint64_t)offset >> 32)};
    DWORD got = 0;

    if (ReadFile((HANDLE)_get_osfhandle(file), to,
                 size < MAXLONG ? (DWORD)size : MAXLONG, &got, &at) ||
        GetLastError() == ERROR_HANDLE_EOF)
        return got;
    return fail();
}

/* Programs that look at each new file, as for viruses, hold it for a moment. */
int ibl_rename(const char *from, const char *to)
{
    for (int i = 0; !MoveFileExA(from, to, MOVEFILE_REPLACE_EXISTING); i++) {
        if (fail() && (i == TRIES || errno != EACCES))
            return -1;
        Sleep(NAP_MS);
    }
    return 0;
}

/* Of ticks of 100 ns since 1601. */
static struct timespec time_of(FILETIME t)
{
    const int64_t ticks =
        (int64_t)((uint64_t)t.dwHighDateTime << 32 | t.dwLowDateTime) -
        116444736000000000;
    return (struct timespec){ticks / 10000000, (long)(ticks % 10000000) * 100};
}

static int look(HANDLE h, struct stat *st)
{
    BY_HANDLE_FILE_INFORMATION f;
    FILE_ATTRIBUTE_TAG_INFO tag = {0};

    if (!GetFileInformationByHandle(h, &f))
        return fail();
    GetFileInformationByHandleEx(h, FileAttributeTagInfo, &tag, sizeof tag);
    *st = (struct stat){
        .st_mode = tag.ReparseTag == IO_REPARSE_TAG_SYMLINK ||
                           tag.ReparseTag == IO_REPARSE_TAG_MOUNT_POINT
                       ? S_IFLNK
                   : f.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY ? S_IFDIR
                                                                   : S_IFREG,
        .st_dev = f.dwVolumeSerialNumber,
        .st_ino = (uint64_t)f.nFileIndexHigh << 32 | f.nFileIndexLow,
        .st_size = (int64_t)f.nFileSizeHigh << 32 | f.nFileSizeLow,
        .st_mtim = time_of(f.ftLastWriteTime),
        /* A copy has the time of what it is of. */
        .st_ctim =
            time_of(CompareFileTime(&f.ftCreationTime, &f.ftLastWriteTime) > 0
                        ? f.ftCreationTime
                        : f.ftLastWriteTime)};
    return 0;
}

/* What users ask of open files; standard input may tell no more. */
int ibl_fstat(int file, struct stat *st)
{
    struct _stat64 s;
    const int result = _fstat64(file, &s);

    *st = (struct stat){.st_mode = s.st_mode, .st_size = s.st_size};
    return result;
}

static int look_at(const char *path, struct stat *st, DWORD flags)
{
    const HANDLE h = open_path(path, 0, OPEN_EXISTING, flags);
    const int result = h == INVALID_HANDLE_VALUE ? fail() : look(h, st);

    CloseHandle(h);
    return result;
}

int ibl_stat(const char *path, struct stat *st)
{
    return look_at(path, st, 0);
}

int lstat(const char *path, struct stat *st)
{
    return look_at(path, st, FILE_FLAG_OPEN_REPARSE_POINT);
}

/* Folders have no locks: a file that goes when it is closed is one. While it
 * goes, access is denied, as also in folders that cannot be written. */
bool ibl_port_lock_folder(const char *path, int *lock)
{
    char name[IBL_PORT_PATH];

    snprintf(name, sizeof name, "%s/.iblbake-lock", path);
    for (int i = 0;; i++) {
        const HANDLE file = CreateFileA(
            name, GENERIC_WRITE, 0, NULL, OPEN_ALWAYS,
            FILE_ATTRIBUTE_HIDDEN | FILE_FLAG_DELETE_ON_CLOSE, NULL);
        *lock = number_of(file);
        if (*lock >= 0)
            return true;
        if (GetLastError() != ERROR_ACCESS_DENIED || i == TRIES)
            return GetLastError() != ERROR_SHARING_VIOLATION;
        Sleep(NAP_MS);
    }
}

const bool ibl_port_shares_files = true;

/* ---- memory, CPUs -------------------------------------------------------- */

uint64_t ibl_port_memory(void)
{
    MEMORYSTATUSEX status = {.dwLength = sizeof status};
    return GlobalMemoryStatusEx(&status) ? status.ullTotalPhys : 0;
}

int ibl_port_cpus(void)
{
    return (int)GetActiveProcessorCount(ALL_PROCESSOR_GROUPS);
}

/* ---- the program --------------------------------------------------------- */

/* Ctrl-C comes on a thread of its own, which waits for changes of others. */
void ibl_port_hold_signals(bool hold)
{
    (void)hold;
}

static void (*leaving)(void);
static UINT code_page; /* of the console, before */

static void restore_console(void)
{
    SetConsoleOutputCP(code_page);
}

/* Also the end of the console, of the user's session or of the system. Ends the
 * program as the system's own handler does. */
static BOOL WINAPI interrupted(DWORD event)
{
    (void)event;
    leaving();
    restore_console();
    ExitProcess((UINT)STATUS_CONTROL_C_EXIT);
}

void ibl_port_begin(int argc, char **argv, void (*leave)(void))
{
    for (int fd = 0; fd < 3; fd++)
        _setmode(fd, O_BINARY);
    _fmode = O_BINARY;
    for (int i = 1; i < argc; i++)
        ibl_port_use_slashes(argv[i]);
    code_page = GetConsoleOutputCP();
    if (code_page && SetConsoleOutputCP(CP_UTF8))
        atexit(restore_console);
    leaving = leave;
    SetConsoleCtrlHandler(interrupted, TRUE);
}

void (*const ibl_port_progress)(double done) = NULL;

void ibl_port_place(char text[IBL_PORT_PATH])
{
    DWORD size = IBL_PORT_PATH;

    if (!GetComputerNameA(text, &size))
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

void *memmem(const void *bytes, size_t size, const void *part, size_t length)
{
    for (const char *at = bytes; size >= length; at++, size--)
        if (!memcmp(at, part, length))
            return (void *)at;
    return NULL;
}
