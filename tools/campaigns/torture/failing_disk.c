/* Preloaded below Python: the n-th call that changes a file below a folder fails.

   fail_at(folder, n, error, calls): from call n (0 is the first), `calls` calls fail (-1: all that
   follow). A write that fails first writes half of its bytes. calls_made(): number of calls so far. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

static char folder[4096] = "";
static long made = 0, first = -1, last = -1;
static int failure = 0;

void fail_at(const char *where, long n, int error, long calls) {
    snprintf(folder, sizeof folder, "%s", where);
    made = 0;
    first = n;
    last = calls < 0 ? 1L << 60 : n + calls - 1;
    failure = error;
}

long calls_made(void) { return made; }

static int fails(void) {
    long now = __sync_fetch_and_add(&made, 1);
    if (first < 0 || now < first || now > last) return 0;
    errno = failure;
    return 1;
}

static int below(int base, const char *path) {
    char of[64], open_folder[4096];
    if (!folder[0] || !path) return 0;
    if (path[0] == '/') return !strncmp(path, folder, strlen(folder));
    if (base == AT_FDCWD) return 0;
    snprintf(of, sizeof of, "/proc/self/fd/%d", base);
    ssize_t length = readlink(of, open_folder, sizeof open_folder - 1);
    return length > 0 && !strncmp(open_folder, folder, strlen(folder));
}

static int inside(int file) { return below(file, ""); }

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))
/* Removal needs no space, so it fails only on a disk that is broken or read-only. */
#define FREES (failure == ENOSPC)

ssize_t write(int file, const void *data, size_t size) {
    if (inside(file) && fails()) {
        if (size > 1) REAL(write)(file, data, size / 2);
        errno = failure;
        return -1;
    }
    return REAL(write)(file, data, size);
}

ssize_t sendfile64(int out, int in, off64_t *offset, size_t size) {
    static ssize_t (*real)(int, int, off64_t *, size_t);
    if (!real) real = dlsym(RTLD_NEXT, "sendfile64");
    return inside(out) && fails() ? -1 : real(out, in, offset, size);
}

#define OPENS(name, ...)                                                                \
    int mode = 0;                                                                        \
    if (flags & (O_CREAT | O_TMPFILE)) {                                                 \
        va_list rest;                                                                    \
        va_start(rest, flags);                                                           \
        mode = va_arg(rest, int);                                                        \
        va_end(rest);                                                                    \
    }                                                                                    \
    if ((flags & (O_CREAT | O_WRONLY | O_RDWR | O_TRUNC)) && below(base, path) && fails()) return -1; \
    return REAL(name)(__VA_ARGS__, flags, mode);

int open(const char *path, int flags, ...) { int base = AT_FDCWD; OPENS(open, path) }
int open64(const char *path, int flags, ...) { int base = AT_FDCWD; OPENS(open64, path) }
int openat(int base, const char *path, int flags, ...) { OPENS(openat, base, path) }
int openat64(int base, const char *path, int flags, ...) { OPENS(openat64, base, path) }

int fsync(int file) { return inside(file) && fails() ? -1 : REAL(fsync)(file); }
int ftruncate64(int file, off64_t length) {
    return inside(file) && !FREES && fails() ? -1 : REAL(ftruncate64)(file, length);
}
int mkdir(const char *path, mode_t mode) {
    return below(AT_FDCWD, path) && fails() ? -1 : REAL(mkdir)(path, mode);
}
int rename(const char *from, const char *to) {
    return below(AT_FDCWD, to) && fails() ? -1 : REAL(rename)(from, to);
}
int unlink(const char *path) {
    return below(AT_FDCWD, path) && !FREES && fails() ? -1 : REAL(unlink)(path);
}
int unlinkat(int base, const char *path, int flags) {
    return below(base, path) && !FREES && fails() ? -1 : REAL(unlinkat)(base, path, flags);
}
int rmdir(const char *path) {
    return below(AT_FDCWD, path) && !FREES && fails() ? -1 : REAL(rmdir)(path);
}
