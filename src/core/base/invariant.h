// PSIM_ASSERT checks our own mistakes, never the user's. On in debug, sanitizer and test builds.
#pragma once

#ifdef PSIM_ENABLE_ASSERTS
#include <cstdio>
#include <cstdlib>
#define PSIM_ASSERT(condition) \
  ((condition) ? void(0)       \
               : (std::fprintf(stderr, "%s:%d: PSIM_ASSERT(%s)\n", __FILE__, __LINE__, #condition), std::abort()))
#else
#define PSIM_ASSERT(condition) void(0)
#endif
