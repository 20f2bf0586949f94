#include "viewpoints.h"
