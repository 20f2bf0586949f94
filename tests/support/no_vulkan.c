/* Preloaded into a program: there is no Vulkan loader to be found. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

void* dlopen(const char* file, int mode) {
  if (file != NULL && strstr(file, "vulkan") != NULL) return NULL;
  void* (*next)(const char*, int) = NULL;
  void* found = dlsym(RTLD_NEXT, "dlopen");
  memcpy(&next, &found, sizeof next);
  return next(file, mode);
}
