/* Preloaded into a program: makes one of its allocations fail, sends it a signal while it writes, or gives it another file to read.
 *
 *   COPPICE_FAIL_MALLOC=N     the N-th allocation of the process, from 1, returns null; a forked process goes on counting
 *   COPPICE_FAIL_MALLOC=N+    so do all after it
 *   COPPICE_COUNT_MALLOC=F    at its end the process appends its number of allocations to the file F
 *   COPPICE_FAIL_THREAD=N     the N-th thread and all after it cannot be started
 *   COPPICE_FAIL_REALPATH=N   the N-th path to be resolved finds no memory for that
 *   COPPICE_SIGNAL_IN_FSYNC=S the first fsync raises signal S
 *   COPPICE_OPEN_OTHER=N      the N-th time that the file COPPICE_OPENED is opened, COPPICE_OTHER is opened instead
 *
 * Only glibc: its allocator has second names for its functions. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): glibc's names
extern void* __libc_malloc(size_t bytes);
extern void* __libc_calloc(size_t count, size_t bytes);
extern void* __libc_realloc(void* block, size_t bytes);
extern void* __libc_memalign(size_t alignment, size_t bytes);
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

static atomic_ulong allocations, threads, paths, openings;

/* 0 where the variable is not set. */
static unsigned long number_in(const char* variable, int* and_after) {
  const char* text = environ == NULL ? NULL : getenv(variable);
  if (text == NULL) return 0;
  char* end = NULL;
  const unsigned long number = strtoul(text, &end, 10);
  *and_after = *end == '+';
  return number;
}

static int fails(void) {
  int and_after = 0;
  const unsigned long at = number_in("COPPICE_FAIL_MALLOC", &and_after);
  const unsigned long now = atomic_fetch_add(&allocations, 1) + 1;
  if (at == 0 || now < at || (now > at && !and_after)) return 0;
  errno = ENOMEM;
  return 1;
}

void* malloc(size_t bytes) {
  return fails() ? NULL : __libc_malloc(bytes);
}

void* calloc(size_t count, size_t bytes) {
  return fails() ? NULL : __libc_calloc(count, bytes);
}

void* realloc(void* block, size_t bytes) {
  return fails() ? NULL : __libc_realloc(block, bytes);
}

void* aligned_alloc(size_t alignment, size_t bytes) {
  return fails() ? NULL : __libc_memalign(alignment, bytes);
}

void* memalign(size_t alignment, size_t bytes) {
  return fails() ? NULL : __libc_memalign(alignment, bytes);
}

int posix_memalign(void** block, size_t alignment, size_t bytes) {
  void* const memory = fails() ? NULL : __libc_memalign(alignment, bytes);
  if (memory == NULL) return ENOMEM;
  *block = memory;
  return 0;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument) {
  typedef int (*Create)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  int and_after = 0;
  const unsigned long at = number_in("COPPICE_FAIL_THREAD", &and_after);
  if (at != 0 && atomic_fetch_add(&threads, 1) + 1 >= at) return EAGAIN;
  Create create = NULL;
  *(void**)&create = dlsym(RTLD_NEXT, "pthread_create");
  return create(thread, attributes, start, argument);
}

char* realpath(const char* restrict path, char* restrict resolved) {
  typedef char* (*Resolve)(const char*, char*);
  int and_after = 0;
  const unsigned long at = number_in("COPPICE_FAIL_REALPATH", &and_after);
  if (at != 0 && atomic_fetch_add(&paths, 1) + 1 == at) {
    errno = ENOMEM;
    return NULL;
  }
  Resolve resolve = NULL;
  *(void**)&resolve = dlsym(RTLD_NEXT, "realpath");
  return resolve(path, resolved);
}

int open(const char* path, int flags, ...) {
  int and_after = 0;
  const unsigned long at = number_in("COPPICE_OPEN_OTHER", &and_after);
  if (at != 0 && strcmp(path, getenv("COPPICE_OPENED")) == 0 && atomic_fetch_add(&openings, 1) + 1 == at) path = getenv("COPPICE_OTHER");
  va_list arguments;
  va_start(arguments, flags);
  const unsigned mode = (flags & O_CREAT) != 0 ? va_arg(arguments, unsigned) : 0;
  va_end(arguments);
  return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int fsync(int file) {
  int and_after = 0;
  const unsigned long signal_number = number_in("COPPICE_SIGNAL_IN_FSYNC", &and_after);
  if (signal_number != 0) raise((int)signal_number);
  return (int)syscall(SYS_fsync, file);
}

static __attribute__((destructor)) void write_count(void) {
  const char* path = getenv("COPPICE_COUNT_MALLOC");
  const int file = path == NULL ? -1 : open(path, O_WRONLY | O_CREAT | O_APPEND, 0600);
  if (file < 0) return;
  char line[32];
  const int length = snprintf(line, sizeof line, "%lu\n", atomic_load(&allocations));
  if (write(file, line, (size_t)length) != length) _exit(99);
  close(file);
}
