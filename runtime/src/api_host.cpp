// The functions of coppice.h for hosts that draw themselves: checks arguments, translates, forwards. No logic.

#include <cstddef>
#include <cstdint>
#include <string>

#include "api_call.h"
#include "api_checks.h"
#include "host_backend.h"
#include "leaf_writer.h"

namespace {

using coppice::ContextOptions;

/// Refuses a context with a renderer.
std::string host_problem(const coppice_context& context) {
  return context.context->renderer() != nullptr ? "the context has a renderer: coppice_context_create makes one for a host that draws" : "";
}

std::string file_problem(const coppice_context& context, std::uint32_t file) {
  return context.context->is_file(file) ? "" : "file " + std::to_string(file) + " is not open";
}

std::string index_problem(std::uint32_t index, std::size_t count) {
  return index < count ? "" : "index is " + std::to_string(index) + ": there are " + std::to_string(count);
}

/// Checks an output that is large enough for the counts.
std::string output_problem(const coppice_leaf_layout& layout, const coppice_leaf_output& output) {
  if (output.vertices == nullptr || output.indices == nullptr)
    return output.vertices == nullptr ? "output.vertices is null" : "output.indices is null";
  constexpr std::uint32_t kMaxNarrow = 1u << 16;
  return layout.index_bytes == 2 && output.vertex_count > kMaxNarrow ? "layout.index_bytes is 2, and the cut has more than 65,536 vertices"
                                                                     : "";
}

}  // namespace

coppice_status coppice_context_create(const coppice_context_desc* desc, coppice_context** context) {
  if (context != nullptr) *context = nullptr;
  ContextOptions options;
  if (const std::string problem = coppice::read_options(desc, options); !problem.empty())
    return coppice::refuse(options, __func__, problem);
  if (context == nullptr) return coppice::refuse(options, __func__, "context is null");
  return coppice::create_context(options, coppice::HostBackend::create, __func__, context);
}

coppice_status coppice_view_create(coppice_context* context, const coppice_view_desc* desc, coppice_view* view) {
  if (view != nullptr) *view = 0;
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(context->context->renderer() != nullptr ? "the context has a renderer: coppice_vulkan_view_create makes its views"
                                                            : "");
  coppice_view_desc ours;
  COPPICE_REFUSE_IF(coppice::read_struct(desc, "desc", ours));
  if (view == nullptr) return call.refuse("view is null");
  COPPICE_REFUSE_IF(coppice::in_struct("desc", coppice::view_desc_problem(ours)));
  const auto created = context->context->create_view(ours, 0);
  if (!created) return call.finish(created.error());
  *view = *created;
  return COPPICE_OK;
}

coppice_status coppice_next_change(coppice_context* context, coppice_change* change) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(host_problem(*context));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(change, "change"));
  coppice::write_struct(context->context->next_change(), change);
  return COPPICE_OK;
}

coppice_status coppice_confirm(coppice_context* context, const coppice_change* change, coppice_outcome outcome) {
  COPPICE_BEGIN_CALL(exclusive);
  COPPICE_REFUSE_IF(host_problem(*context));
  coppice_change ours;
  COPPICE_REFUSE_IF(coppice::read_struct(change, "change", ours));
  COPPICE_REFUSE_IF(outcome < COPPICE_OUTCOME_TAKEN || outcome > COPPICE_OUTCOME_FREED ? "outcome is not a coppice_outcome" : "");
  if (ours.kind == COPPICE_CHANGE_PLANT_OPENED || ours.kind == COPPICE_CHANGE_PLANT_CLOSED) return COPPICE_OK;
  COPPICE_REFUSE_IF(ours.chunk < COPPICE_STREAMED_PAGES || ours.chunk >= COPPICE_STREAMED_ALL ? "change.chunk is no kind of chunk" : "");
  return call.finish(context->context->acknowledge({ours.file, static_cast<coppice::ChunkKind>(ours.chunk), ours.index}, outcome));
}

coppice_status coppice_file_get_info(const coppice_context* context, uint32_t file, coppice_file_info* info) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(file_problem(*context, file));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(info, "info"));
  coppice::write_struct(context->context->file_info(file), info);
  return COPPICE_OK;
}

coppice_status coppice_file_get_material(const coppice_context* context, uint32_t file, uint32_t index, coppice_material* material) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(file_problem(*context, file));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(material, "material"));
  COPPICE_REFUSE_IF(index_problem(index, context->context->file(file).materials.size()));
  coppice::write_struct(context->context->material(file, index), material);
  return COPPICE_OK;
}

coppice_status coppice_file_get_card(const coppice_context* context, uint32_t file, uint32_t index, coppice_card* card) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(file_problem(*context, file));
  COPPICE_REFUSE_IF(coppice::struct_size_problem(card, "card"));
  COPPICE_REFUSE_IF(index_problem(index, context->context->file(file).cards.size()));
  coppice::write_struct(context->context->card(file, index), card);
  return COPPICE_OK;
}

coppice_status coppice_get_draws(coppice_context* context, coppice_view view, coppice_draw* draws, uint32_t capacity, uint32_t draw_bytes,
                                 uint32_t* count) {
  if (count != nullptr) *count = 0;
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(coppice::view_problem(*context, view));
  COPPICE_REFUSE_IF(coppice::records_problem(draws, capacity, draw_bytes, "draws"));
  if (count == nullptr) return call.refuse("count is null");
  COPPICE_REFUSE_IF(context->context->is_shown(view) ? "" : "view has no camera in this frame");
  *count = context->context->draws(view, {draws, capacity, draw_bytes});
  return COPPICE_OK;
}

coppice_status coppice_write_leaves(const coppice_context* context, uint32_t file, float leaf_count, const coppice_leaf_layout* layout,
                                    coppice_leaf_output* output) {
  COPPICE_BEGIN_CALL(shared);
  COPPICE_REFUSE_IF(file_problem(*context, file));
  COPPICE_REFUSE_IF(leaf_count > 0.0f ? "" : "leaf_count is not above 0");
  coppice_leaf_layout of_vertices;
  COPPICE_REFUSE_IF(coppice::read_struct(layout, "layout", of_vertices));
  COPPICE_REFUSE_IF(coppice::in_struct("layout", coppice::layout_problem(of_vertices)));
  coppice_leaf_output ours;
  COPPICE_REFUSE_IF(coppice::read_struct(output, "output", ours));
  ours.leaf_count = context->context->whole_cut(file, leaf_count);
  ours.vertex_count = 4 * ours.leaf_count;
  ours.index_count = 6 * ours.leaf_count;
  const bool fits = ours.vertex_count <= ours.vertex_capacity && ours.index_count <= ours.index_capacity;
  COPPICE_REFUSE_IF(fits ? output_problem(of_vertices, ours) : "");
  if (fits) context->context->write_leaves(file, ours.leaf_count, of_vertices, ours);
  coppice::write_struct(ours, output);
  return COPPICE_OK;
}
