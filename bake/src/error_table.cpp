#include "error_table.h"
