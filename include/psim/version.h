/// @file
/// The version of these headers. C and C++.
#pragma once

#define PSIM_VERSION_MAJOR 0         ///< while it is 0, a new minor version may change the ABI
#define PSIM_VERSION_MINOR 1         ///< new names
#define PSIM_VERSION_PATCH 0         ///< fixes
#define PSIM_VERSION_STRING "0.1.0"  ///< the three of them
