// The functions of coppice.h for hosts that draw themselves: checks what they pass, translates, forwards. No logic.

#include <string>

#include "api_call.h"
#include "api_checks.h"
#include "api_options.h"
#include "host_backend.h"

namespace {

using coppice::ContextOptions;

/// Of a context that has a renderer.
std::string host_problem(const coppice_context& context) {
  return context.context->renderer() != nullptr ? "the context has a renderer: coppice_context_create makes one for a host that draws" : "";
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
  COPPICE_REFUSE_IF(host_problem(*context));
  coppice_view_desc ours;
  COPPICE_REFUSE_IF(coppice::read_struct(desc, "desc", ours));
  if (view == nullptr) return call.refuse("view is null");
  COPPICE_REFUSE_IF(coppice::in_struct("desc", coppice::view_desc_problem(ours)));
  const auto created = context->context->create_view(ours, 0);
  if (!created) return call.finish(created.error());
  *view = *created;
  return COPPICE_OK;
}
