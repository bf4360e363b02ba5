// Functions compiled twice: for the baseline and, chosen at run time, for AVX2.
#pragma once

namespace adit::detect {

#if defined(__x86_64__)
#define ADIT_AVX2 __attribute__((target("avx2")))
inline bool HasAvx2() { return __builtin_cpu_supports("avx2") != 0; }
#else
#define ADIT_AVX2
inline bool HasAvx2() { return false; }
#endif

/// What is compiled into its caller, for the caller's processor.
#define ADIT_INLINE __attribute__((always_inline)) inline

}  // namespace adit::detect
