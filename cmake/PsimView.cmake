# psim-view: SDL2, Dear ImGui and OpenGL 3.3. psim itself knows nothing of them.
set(PSIM_VIEW AUTO CACHE STRING
    "Build psim-view: ON, OFF, or AUTO: if SDL2 and Dear ImGui are found and no sanitizer is on")
set_property(CACHE PSIM_VIEW PROPERTY STRINGS AUTO ON OFF)

if(NOT PSIM_VIEW OR (PSIM_VIEW STREQUAL "AUTO" AND PSIM_SANITIZE))
  return()
endif()

find_package(SDL2 QUIET CONFIG)
find_path(PSIM_IMGUI_INCLUDE imgui.h PATH_SUFFIXES imgui)
find_library(PSIM_IMGUI_LIBRARY imgui)
find_library(PSIM_STB_LIBRARY stb)
find_library(PSIM_FREETYPE_LIBRARY freetype)
if(NOT TARGET SDL2::SDL2 OR NOT PSIM_IMGUI_INCLUDE OR NOT PSIM_IMGUI_LIBRARY)
  if(PSIM_VIEW STREQUAL "AUTO")
    message(STATUS "psim-view is left out; for it: apt install libsdl2-dev libimgui-dev")
    return()
  endif()
  message(FATAL_ERROR "psim: SDL2 or Dear ImGui is missing: apt install libsdl2-dev libimgui-dev")
endif()

# What needs no window, and what is psim's own: for the program and its tests.
file(GLOB _view_model CONFIGURE_DEPENDS src/view/model/*.cpp)
add_library(psim_view_model STATIC ${_view_model})
psim_target_defaults(psim_view_model)
target_include_directories(psim_view_model PUBLIC src/view)
target_link_libraries(psim_view_model PUBLIC psim_parts)
psim_rooms(psim_view_model)

file(GLOB _view_sources CONFIGURE_DEPENDS src/view/window/*.cpp)
add_executable(psim-view src/view/main.cpp ${_view_sources})
psim_target_defaults(psim-view)
psim_rooms(psim-view)
# The headers of others are not ours to keep free of warnings.
target_include_directories(psim-view SYSTEM PRIVATE "${PSIM_IMGUI_INCLUDE}")
target_link_libraries(psim-view PRIVATE psim_view_model
  "${PSIM_IMGUI_LIBRARY}" SDL2::SDL2 ${CMAKE_DL_LIBS})
foreach(_library PSIM_STB_LIBRARY PSIM_FREETYPE_LIBRARY)
  if(${_library})  # what Debian's Dear ImGui needs
    target_link_libraries(psim-view PRIVATE "${${_library}}")
  endif()
endforeach()
if(PSIM_INSTALL)
  install(TARGETS psim-view RUNTIME COMPONENT psim_view)
endif()
