#include "page_codec.h"
