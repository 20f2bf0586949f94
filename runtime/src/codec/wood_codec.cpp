#include "wood_codec.h"
