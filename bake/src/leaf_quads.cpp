#include "leaf_quads.h"
