# The oracles of the tests and of the accuracy laboratory. No code that they judge is on their include path, so that
# a look at it does not compile; tools/rooms checks that no path leads there by another way.
file(GLOB _reference_sources CONFIGURE_DEPENDS tests/reference/*.cpp)
add_library(psim_reference STATIC EXCLUDE_FROM_ALL ${_reference_sources})
psim_target_defaults(psim_reference)
target_include_directories(psim_reference PUBLIC tests/reference)
