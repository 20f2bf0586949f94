#include "gltf_write.h"
