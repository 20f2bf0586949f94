#include "tree_order.h"
