/// @file
/// Which names a shared library shows. C and C++.
#pragma once

/// Marks what libpsim.so or psim.dll exports. Whoever links psim.dll needs no mark: the import library has functions alone.
#if defined(_WIN32)
#ifdef PSIM_BUILDS_DLL  // psim's own build, for its own files
#define PSIM_API __declspec(dllexport)
#else
#define PSIM_API
#endif
#elif defined(__GNUC__)
#define PSIM_API __attribute__((visibility("default")))
#else
#define PSIM_API
#endif
/// Marks what it does not, inside of what it does.
#if defined(__GNUC__) && !defined(_WIN32)
#define PSIM_LOCAL __attribute__((visibility("hidden")))
#else
#define PSIM_LOCAL
#endif
