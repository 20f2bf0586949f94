/* A host that draws itself, as far as that goes without a plant. */
#include <coppice/coppice.h>
#include <coppice/format.h>
#include <stdio.h>

#ifdef VULKAN_CORE_H_
#error "coppice.h includes Vulkan"
#endif

int main(void) {
  coppice_context_desc desc;
  coppice_context* context = NULL;
  coppice_view_desc view_desc;
  coppice_view view = 0;
  coppice_camera camera;
  coppice_frame frame;
  coppice_status status;
  coppice_context_desc_init(&desc);
  status = coppice_context_create(&desc, &context);
  if (status != COPPICE_OK) {
    fprintf(stderr, "%s\n", coppice_last_error(NULL));
    return 1;
  }
  coppice_view_desc_init(&view_desc);
  status = coppice_view_create(context, &view_desc, &view);
  coppice_camera_init(&camera);
  camera.view = view;
  camera.width_px = camera.height_px = 64;
  camera.clip_from_view[10] = camera.clip_from_view[15] = 0.0f;
  camera.clip_from_view[11] = -1.0f;
  camera.clip_from_view[14] = 0.1f;
  coppice_frame_init(&frame);
  frame.frame_number = 1;
  frame.cameras = &camera;
  frame.camera_count = 1;
  if (status == COPPICE_OK) status = coppice_frame_begin(context, &frame);
  if (status != COPPICE_OK) fprintf(stderr, "%s\n", coppice_last_error(context));
  coppice_context_destroy(context);
  printf("coppice without a graphics API: %s\n", coppice_status_text(status));
  return status == COPPICE_OK ? 0 : 1;
}
