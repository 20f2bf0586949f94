#include "wood_lods.h"
