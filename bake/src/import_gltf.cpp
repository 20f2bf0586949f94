#include "import_gltf.h"
