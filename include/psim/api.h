/// @file
/// Which names a shared library shows. C and C++.
#pragma once

/// Marks what libpsim.so exports.
#define PSIM_API __attribute__((visibility("default")))
/// Marks what it does not, inside of what it does.
#define PSIM_LOCAL __attribute__((visibility("hidden")))
