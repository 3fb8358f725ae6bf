# The accuracy laboratory: psim and, where they are installed, other engines on the same scenes.
# `accuracy --list` says which ones are in.

file(GLOB _accuracy_sources CONFIGURE_DEPENDS bench/accuracy/*.cpp bench/accuracy/*/*.cpp)
list(FILTER _accuracy_sources EXCLUDE REGEX "/(main|engine_(box2d24|box2d3|chipmunk))\\.cpp$")
add_library(psim_accuracy STATIC ${_accuracy_sources})
psim_target_defaults(psim_accuracy)
target_include_directories(psim_accuracy PUBLIC bench/accuracy PRIVATE src/scene)
target_link_libraries(psim_accuracy PUBLIC psim_scene psim_reference)

add_executable(accuracy bench/accuracy/main.cpp)
psim_target_defaults(accuracy)
target_link_libraries(accuracy PRIVATE psim_accuracy psim_parts)
# Where --calibrate writes, and what psim is built with.
target_compile_definitions(accuracy PRIVATE
  "PSIM_CALIBRATION_FILE=\"${PROJECT_SOURCE_DIR}/docs/data/calibration.csv\"")

# psim_engine(LIBRARY FILE MACRO INCLUDE LIBRARIES...): one engine's adapter, a part of LIBRARY. Each
# sees its own headers only: Box2D 2 and 3 use the same file names.
function(psim_engine library file macro include)
  get_filename_component(_name ${file} NAME_WE)
  set(_target psim_${_name})
  add_library(${_target} OBJECT ${file})
  psim_target_defaults(${_target})
  target_include_directories(${_target} PRIVATE include bench/accuracy bench/peers)
  target_include_directories(${_target} SYSTEM BEFORE PRIVATE ${include})
  target_sources(${library} PRIVATE $<TARGET_OBJECTS:${_target}>)
  target_compile_definitions(${library} PRIVATE ${macro})
  target_link_libraries(${library} PRIVATE ${ARGN})
endfunction()

# Debian's libbox2d-dev. Looked for by file, since Box2D 3 has the same package and target names.
find_path(PSIM_BOX2D24_INCLUDE box2d/b2_world.h)
find_library(PSIM_BOX2D24_LIBRARY NAMES libbox2d.so)
if(PSIM_BOX2D24_INCLUDE AND PSIM_BOX2D24_LIBRARY)
  psim_engine(psim_accuracy bench/accuracy/engines/engine_box2d24.cpp PSIM_WITH_BOX2D24
    "${PSIM_BOX2D24_INCLUDE}" "${PSIM_BOX2D24_LIBRARY}")
endif()

find_package(box2d 3 CONFIG QUIET)
if(box2d_FOUND AND TARGET box2d::box2d)
  psim_engine(psim_accuracy bench/accuracy/engines/engine_box2d3.cpp PSIM_WITH_BOX2D3
    "$<TARGET_PROPERTY:box2d::box2d,INTERFACE_INCLUDE_DIRECTORIES>" box2d::box2d)
endif()

find_path(PSIM_CHIPMUNK_INCLUDE chipmunk/chipmunk_structs.h)
find_library(PSIM_CHIPMUNK_LIBRARY NAMES chipmunk)
if(PSIM_CHIPMUNK_INCLUDE AND PSIM_CHIPMUNK_LIBRARY)
  psim_engine(psim_accuracy bench/accuracy/engines/engine_chipmunk.cpp PSIM_WITH_CHIPMUNK
    "${PSIM_CHIPMUNK_INCLUDE}" "${PSIM_CHIPMUNK_LIBRARY}")
endif()
