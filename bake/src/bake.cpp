#include "bake.h"
