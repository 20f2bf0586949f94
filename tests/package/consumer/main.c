/* Uses the library as an engine's C code would, as far as that goes without a Vulkan device. */
#include <coppice/format.h>
#include <coppice/vulkan.h>
#include <stdio.h>

int main(void) {
  coppice_context_desc desc;
  coppice_vulkan_desc vulkan;
  coppice_context_desc_init(&desc);
  coppice_vulkan_desc_init(&vulkan);
  if (coppice_version() != COPPICE_HEADER_VERSION) {
    fprintf(stderr, "coppice_version: the library is not of the header's version\n");
    return 1;
  }
  if (desc.struct_size != sizeof desc) {
    fprintf(stderr, "coppice_context_desc_init: struct_size is %u, not %zu\n", desc.struct_size, sizeof desc);
    return 1;
  }
  coppice_context* context = NULL;
  /* No device: refused, not crashed. Pulls in the whole library, so that a symbol missing from the package fails to link. */
  const coppice_status status = coppice_vulkan_context_create(&desc, &vulkan, &context);
  if (status != COPPICE_ERROR_INVALID_ARGUMENT || context != NULL) {
    fprintf(stderr, "coppice_vulkan_context_create without a device: %s\n", coppice_status_text(status));
    return 1;
  }
  printf("coppice %d.%d.%d, format %u: %s\n", COPPICE_VERSION_MAJOR, COPPICE_VERSION_MINOR, COPPICE_VERSION_PATCH, COPPICE_FORMAT_VERSION,
         coppice_status_text(status));
  return 0;
}
