// Own bugs stop the program at once; everything that the world can do wrong is a Result or a status instead.
#pragma once

#include <cstdio>
#include <cstdlib>

/// Aborts with file, line and condition if `condition` is false. For broken invariants of our own code only.
#define ADIT_REQUIRE(condition)                                                              \
  do {                                                                                       \
    if (!(condition)) [[unlikely]] {                                                         \
      std::fprintf(stderr, "%s:%d: broken invariant: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                          \
    }                                                                                        \
  } while (false)
