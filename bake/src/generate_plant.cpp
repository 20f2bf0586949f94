#include "generate_plant.h"
