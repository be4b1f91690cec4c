/* Lets the n-th call of a kind fail, in a process that preloads this library. Linux with glibc.
 *
 * FAULT_KIND   which calls: write, stdout, stderr, read, open, create, name, sync, seek, mode, thread, memory
 *              (names are given; that they can be taken away is needed to clean up, so it never fails)
 * FAULT_AT     the number of the first call that fails, from 1; 0 lets none fail
 * FAULT_LAST   the number of the last call that fails
 * FAULT_BYTES  requests of memory from this size on are calls of the kind memory
 * FAULT_NOTE   a file that gets a line for every failure, and at the end of the process the number of calls
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static const char *kind;
static long first, last;
static size_t bytes = 1 << 12;
static const char *note;
static atomic_long calls;

__attribute__((constructor)) static void begin(void) {
    const char *text = getenv("FAULT_AT");
    first = text ? atol(text) : 0;
    text = getenv("FAULT_LAST");
    last = text ? atol(text) : first;
    text = getenv("FAULT_BYTES");
    if (text) bytes = (size_t)atol(text);
    note = getenv("FAULT_NOTE");
    /* Last, because calls are counted from here on. */
    kind = getenv("FAULT_KIND");
}

static void tell(const char *text) {
    if (!note) return;
    int saved = errno;
    long fd = syscall(SYS_openat, AT_FDCWD, note, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (fd >= 0) {
        syscall(SYS_write, fd, text, strlen(text));
        syscall(SYS_close, fd);
    }
    errno = saved;
}

__attribute__((destructor)) static void end(void) {
    char text[64];
    snprintf(text, sizeof text, "calls %ld\n", atomic_load(&calls));
    tell(text);
}

/* Whether this call of kind `which` fails. */
static int fails(const char *which, int error) {
    if (!kind || strcmp(kind, which)) return 0;
    long number = atomic_fetch_add(&calls, 1) + 1;
    if (first == 0 || number < first || number > last) return 0;
    tell("failed\n");
    errno = error;
    return 1;
}

static const char *written(int fd) {
    return fd == 1 ? "stdout" : fd == 2 ? "stderr" : "write";
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int fd, const void *from, size_t n) {
    return fails(written(fd), fd > 2 ? ENOSPC : EPIPE) ? -1 : syscall(SYS_write, fd, from, n);
}

ssize_t writev(int fd, const struct iovec *from, int n) {
    return fails(written(fd), fd > 2 ? ENOSPC : EPIPE) ? -1 : syscall(SYS_writev, fd, from, n);
}

ssize_t pwrite64(int fd, const void *from, size_t n, off64_t at) {
    return fails("write", ENOSPC) ? -1 : NEXT(pwrite64)(fd, from, n, at);
}

ssize_t copy_file_range(int in, off64_t *from, int out, off64_t *to, size_t n, unsigned flags) {
    return fails("write", ENOSPC) ? -1 : syscall(SYS_copy_file_range, in, from, out, to, n, flags);
}

ssize_t sendfile64(int out, int in, off64_t *from, size_t n) {
    return fails("write", ENOSPC) ? -1 : NEXT(sendfile64)(out, in, from, n);
}

ssize_t read(int fd, void *to, size_t n) {
    return fails("read", EIO) ? -1 : syscall(SYS_read, fd, to, n);
}

ssize_t pread64(int fd, void *to, size_t n, off64_t at) {
    return fails("read", EIO) ? -1 : NEXT(pread64)(fd, to, n, at);
}

static int opened(int folder, const char *path, int flags, va_list rest) {
    mode_t mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(rest, mode_t) : 0;
    int changes = (flags & (O_CREAT | __O_TMPFILE)) || (flags & O_ACCMODE) != O_RDONLY;
    if (fails(changes ? "create" : "open", changes ? ENOSPC : EIO)) return -1;
    return (int)syscall(SYS_openat, folder, path, flags, mode);
}

#define OPEN(name)                                  \
    int name(const char *path, int flags, ...) {    \
        va_list rest;                               \
        va_start(rest, flags);                      \
        int fd = opened(AT_FDCWD, path, flags, rest); \
        va_end(rest);                               \
        return fd;                                  \
    }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                          \
    int name(int folder, const char *path, int flags, ...) {  \
        va_list rest;                                         \
        va_start(rest, flags);                                \
        int fd = opened(folder, path, flags, rest);           \
        va_end(rest);                                         \
        return fd;                                            \
    }
OPENAT(openat)
OPENAT(openat64)

int rename(const char *from, const char *to) {
    return fails("name", EIO) ? -1 : NEXT(rename)(from, to);
}

int renameat(int a, const char *from, int b, const char *to) {
    return fails("name", EIO) ? -1 : NEXT(renameat)(a, from, b, to);
}

int linkat(int a, const char *from, int b, const char *to, int flags) {
    return fails("name", EIO) ? -1 : NEXT(linkat)(a, from, b, to, flags);
}

int fsync(int fd) {
    return fails("sync", EIO) ? -1 : (int)syscall(SYS_fsync, fd);
}

int fdatasync(int fd) {
    return fails("sync", EIO) ? -1 : (int)syscall(SYS_fdatasync, fd);
}

off64_t lseek64(int fd, off64_t at, int whence) {
    return fails("seek", EIO) ? -1 : NEXT(lseek64)(fd, at, whence);
}

int fchmod(int fd, mode_t mode) {
    return fails("mode", EPERM) ? -1 : NEXT(fchmod)(fd, mode);
}

int pthread_create(pthread_t *thread, const pthread_attr_t *with, void *(*run)(void *), void *given) {
    return fails("thread", EAGAIN) ? EAGAIN : NEXT(pthread_create)(thread, with, run, given);
}

/* glibc's own names, because a lookup of others would allocate memory. */
void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void *__libc_memalign(size_t, size_t);

static int refused(size_t n) {
    return kind && n >= bytes && fails("memory", ENOMEM);
}

void *malloc(size_t n) {
    return refused(n) ? NULL : __libc_malloc(n);
}

void *calloc(size_t n, size_t size) {
    return refused(n * size) ? NULL : __libc_calloc(n, size);
}

void *realloc(void *old, size_t n) {
    return refused(n) ? NULL : __libc_realloc(old, n);
}

void *memalign(size_t align, size_t n) {
    return refused(n) ? NULL : __libc_memalign(align, n);
}

void *aligned_alloc(size_t align, size_t n) {
    return refused(n) ? NULL : __libc_memalign(align, n);
}

int posix_memalign(void **to, size_t align, size_t n) {
    if (refused(n)) return ENOMEM;
    *to = __libc_memalign(align, n);
    return *to ? 0 : ENOMEM;
}
