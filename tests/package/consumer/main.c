/* Uses the library as an engine's C code would, as far as that goes without a Vulkan device. */
#include <coppice/coppice.h>
#include <coppice/format.h>
#include <stdio.h>

int main(void) {
  coppice_context_desc desc;
  coppice_context_desc_init(&desc);
  if (desc.struct_size != sizeof desc) {
    fprintf(stderr, "coppice_context_desc_init: struct_size is %u, not %zu\n", desc.struct_size, sizeof desc);
    return 1;
  }
  coppice_context* context = NULL;
  /* No device: refused, not crashed. Pulls in the whole library, so that a symbol missing from the package fails to link. */
  const coppice_status status = coppice_context_create(&desc, &context);
  if (status != COPPICE_ERROR_INVALID_ARGUMENT || context != NULL) {
    fprintf(stderr, "coppice_context_create without a device: %s\n", coppice_status_text(status));
    return 1;
  }
  printf("coppice %d.%d.%d, format %u: %s\n", COPPICE_VERSION_MAJOR, COPPICE_VERSION_MINOR, COPPICE_VERSION_PATCH, COPPICE_FORMAT_VERSION,
         coppice_status_text(status));
  return 0;
}
