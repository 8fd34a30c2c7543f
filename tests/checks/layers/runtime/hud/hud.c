#include "platform/platform.h" /* expect: rooms name their public headers */
