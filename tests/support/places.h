#pragma once

// Where the build put its programs and where the sources lie. One file knows the absolute paths, so that every other test compiles to the
// same object in any folder and a compiler cache serves them all.

namespace coppice::test {

extern const char* const kTool;                 ///< `coppice`
extern const char* const kForest;               ///< `coppice-forest`; empty where the demo is not built
extern const char* const kHelloPlant;           ///< demo/examples/01_hello_plant; empty likewise
extern const char* const kNoGpu;                ///< demo/examples/02_no_gpu; empty likewise
extern const char* const kEngineHost;           ///< demo/hosts/engine; empty where it is not built
extern const char* const kGlslang;              ///< glslangValidator
extern const char* const kFailMallocLibrary;    ///< support/fail_malloc.c, to be preloaded
extern const char* const kNoVulkanLibrary;      ///< support/no_vulkan.c, likewise
extern const char* const kSourceFolder;         ///< the repository
extern const char* const kTestFolder;           ///< tests/
extern const char* const kTestData;             ///< tests/data/
extern const char* const kOutputFolder;         ///< for what tests leave behind: pictures of failures, plants baked once
extern const char* const kSwiftShader;          ///< the JSON file of a second Vulkan driver; ends with NOTFOUND without one
extern const char* const kDeviceLayer;          ///< where the loader finds device/limits_layer, for XDG_DATA_DIRS
extern const char* const kDefaultPlants;        ///< where plants are looked for if COPPICE_PLANTS is not set
extern const char* const kFaultyDeviceLibrary;  ///< support/faulty_device.c, a Vulkan layer

}  // namespace coppice::test
