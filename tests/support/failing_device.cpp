#include "failing_device.h"

#include <cstring>
#include <map>
#include <type_traits>
#include <utility>

#include "replaced_functions.h"

namespace coppice::test {
namespace {

/// Whether the call that is made now fails.
bool fails(const char* call) {
  DeviceFaults& faults = device_faults();
  const std::uint64_t index = faults.calls.size();
  faults.calls.emplace_back(call);
  const bool failing = index == faults.fail_at || (faults.for_good && index > faults.fail_at);
  if (failing && faults.failed_call.empty()) faults.failed_call = call;
  return failing;
}

/// What a call that failed leaves behind is undefined: here it is something that must not be touched.
template <class Out>
void poison(Out* out) {
  std::memset(static_cast<void*>(out), 0xcd, sizeof(Out));
}

/// A call that returns a VkResult; `real` is volk's pointer.
template <auto& real, class Function>
struct Call;
template <auto& real, class... Arguments>
struct Call<real, VkResult(VKAPI_PTR*)(Arguments...)> {
  static inline const char* name = "";

  /// Creates what its last argument points to.
  static VKAPI_ATTR VkResult VKAPI_CALL create(Arguments... arguments) {
    auto* out = last(arguments...);
    if (fails(name)) {
      poison(out);
      return device_faults().result;
    }
    const VkResult result = real(arguments...);
    if (result == VK_SUCCESS) ++device_faults().live_objects;
    return result;
  }
  /// The same without a destruction of its own.
  static VKAPI_ATTR VkResult VKAPI_CALL fill(Arguments... arguments) {
    if (fails(name)) {
      poison(last(arguments...));
      return device_faults().result;
    }
    return real(arguments...);
  }
  static VKAPI_ATTR VkResult VKAPI_CALL plain(Arguments... arguments) { return fails(name) ? device_faults().result : real(arguments...); }

 private:
  template <class First, class... Rest>
  static auto last(First first, Rest... rest) {
    if constexpr (sizeof...(rest) == 0)
      return first;
    else
      return last(rest...);
  }
};

/// By what they are made of.
std::map<std::string, VkPipeline>& shared_pipelines() {
  static std::map<std::string, VkPipeline> shared;
  return shared;
}

/// SPIR-V of the modules that are alive.
std::map<VkShaderModule, std::string>& module_words() {
  static std::map<VkShaderModule, std::string> words;
  return words;
}

VKAPI_ATTR VkResult VKAPI_CALL create_module(VkDevice device, const VkShaderModuleCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                             VkShaderModule* out) {
  const VkResult result = Call<vkCreateShaderModule, decltype(vkCreateShaderModule)>::create(device, info, callbacks, out);
  if (result == VK_SUCCESS) module_words()[*out].assign(reinterpret_cast<const char*>(info->pCode), info->codeSize);
  return result;
}

void append_stage(std::string& key, const VkPipelineShaderStageCreateInfo& stage) {
  key += module_words().at(stage.module);
  if (const VkSpecializationInfo* constants = stage.pSpecializationInfo; constants != nullptr)
    key.append(static_cast<const char*>(constants->pData), constants->dataSize);
}

std::string key_of(const VkComputePipelineCreateInfo& info) {
  std::string key;
  append_stage(key, info.stage);
  return key;
}

std::string key_of(const VkGraphicsPipelineCreateInfo& info) {
  std::string key;
  for (std::uint32_t i = 0; i < info.stageCount; ++i) append_stage(key, info.pStages[i]);
  return key;
}

template <auto& real, class Info>
VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice device, VkPipelineCache cache, std::uint32_t count, const Info* infos,
                                                const VkAllocationCallbacks* callbacks, VkPipeline* out) {
  if (fails(std::is_same_v<Info, VkComputePipelineCreateInfo> ? "vkCreateComputePipelines" : "vkCreateGraphicsPipelines")) {
    poison(out);
    return device_faults().result;
  }
  VkPipeline& shared = shared_pipelines()[key_of(*infos)];
  if (shared == VK_NULL_HANDLE) {
    const VkResult result = real(device, cache, count, infos, callbacks, &shared);
    if (result != VK_SUCCESS) return result;
  }
  *out = shared;
  ++device_faults().live_objects;
  return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL destroy_pipeline(VkDevice, VkPipeline pipeline, const VkAllocationCallbacks*) {
  if (pipeline != VK_NULL_HANDLE) --device_faults().live_objects;
}

/// vkDestroy* and vkFreeMemory.
template <auto& real, class Function>
struct Destruction;
template <auto& real, class Object>
struct Destruction<real, void(VKAPI_PTR*)(VkDevice, Object, const VkAllocationCallbacks*)> {
  static VKAPI_ATTR void VKAPI_CALL call(VkDevice device, Object object, const VkAllocationCallbacks* callbacks) {
    if (object != VK_NULL_HANDLE) --device_faults().live_objects;
    real(device, object, callbacks);
  }
};

ReplacedFunctions replacements() {
  ReplacedFunctions functions{
      replacing("vkCreateComputePipelines", create_pipelines<vkCreateComputePipelines, VkComputePipelineCreateInfo>),
      replacing("vkCreateGraphicsPipelines", create_pipelines<vkCreateGraphicsPipelines, VkGraphicsPipelineCreateInfo>),
      replacing("vkDestroyPipeline", destroy_pipeline)};
#define COPPICE_CALL(function, how)                        \
  {                                                        \
    using Replaced = Call<function, decltype(function)>;   \
    Replaced::name = #function;                            \
    functions.insert(replacing(#function, Replaced::how)); \
  }
#define COPPICE_DESTRUCTION(function) functions.insert(replacing(#function, Destruction<function, decltype(function)>::call));
  COPPICE_CALL(vkAllocateMemory, create)
  COPPICE_CALL(vkCreateBuffer, create)
  COPPICE_CALL(vkCreateBufferView, create)
  COPPICE_CALL(vkCreateDescriptorPool, create)
  COPPICE_CALL(vkCreateDescriptorSetLayout, create)
  COPPICE_CALL(vkCreateImage, create)
  COPPICE_CALL(vkCreateImageView, create)
  COPPICE_CALL(vkCreatePipelineLayout, create)
  COPPICE_CALL(vkCreateQueryPool, create)
  COPPICE_CALL(vkCreateSampler, create)
  COPPICE_CALL(vkCreateShaderModule, create)
  COPPICE_CALL(vkAllocateDescriptorSets, fill)
  COPPICE_CALL(vkMapMemory, fill)
  COPPICE_CALL(vkBindBufferMemory, plain)
  COPPICE_CALL(vkBindImageMemory, plain)
  COPPICE_CALL(vkGetQueryPoolResults, plain)
  COPPICE_DESTRUCTION(vkDestroyBuffer)
  COPPICE_DESTRUCTION(vkDestroyBufferView)
  COPPICE_DESTRUCTION(vkDestroyDescriptorPool)
  COPPICE_DESTRUCTION(vkDestroyDescriptorSetLayout)
  COPPICE_DESTRUCTION(vkDestroyImage)
  COPPICE_DESTRUCTION(vkDestroyImageView)
  COPPICE_DESTRUCTION(vkDestroyPipelineLayout)
  COPPICE_DESTRUCTION(vkDestroyQueryPool)
  COPPICE_DESTRUCTION(vkDestroySampler)
  COPPICE_DESTRUCTION(vkDestroyShaderModule)
  COPPICE_DESTRUCTION(vkFreeMemory)
#undef COPPICE_CALL
#undef COPPICE_DESTRUCTION
  functions["vkCreateShaderModule"] = reinterpret_cast<PFN_vkVoidFunction>(create_module);
  if (!device_faults().missing.empty()) functions[device_faults().missing] = nullptr;
  return functions;
}

}  // namespace

DeviceFaults& device_faults() {
  static DeviceFaults faults;
  return faults;
}

void reset_device_faults() {
  device_faults() = {.live_objects = device_faults().live_objects};
}

void destroy_shared_pipelines() {
  for (const auto& [key, pipeline] : std::exchange(shared_pipelines(), {})) vkDestroyPipeline(vulkan_device().device, pipeline, nullptr);
}

void fail_with_device_faults(coppice_vulkan_desc& desc) {
  replace_functions(desc, replacements());
}

}  // namespace coppice::test
