// Compilers have different words for the same thing. g++, clang++ and clang-cl have the left ones, MSVC the right ones.
#pragma once

#if defined(__GNUC__) || defined(__clang__)
/// Before a function: each call becomes its body.
#define PSIM_INLINE [[gnu::always_inline]]
/// After the parameters of a lambda.
#define PSIM_INLINE_LAMBDA __attribute__((always_inline))
/// Before a function that seldom runs, to keep it out of loops.
#define PSIM_COLD [[gnu::cold, gnu::noinline]]
/// Asks for the cache line at p: to read, or to write.
#define PSIM_PREFETCH(p) __builtin_prefetch(p)
#define PSIM_PREFETCH_TO_WRITE(p) __builtin_prefetch(p, 1)
#else
#define PSIM_INLINE [[msvc::forceinline]]
#define PSIM_INLINE_LAMBDA [[msvc::forceinline]]
#define PSIM_COLD __declspec(noinline)
#define PSIM_PREFETCH(p) static_cast<void>(p)
#define PSIM_PREFETCH_TO_WRITE(p) static_cast<void>(p)
#endif
