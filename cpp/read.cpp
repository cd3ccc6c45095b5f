#include "grids.h"
