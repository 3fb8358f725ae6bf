# The comparison with other engines: psim, those of the accuracy laboratory, Bullet and ODE, as far as
# they are installed. `peers --list` says which ones are in.

file(GLOB _peers_sources CONFIGURE_DEPENDS bench/peers/*.cpp)
list(FILTER _peers_sources EXCLUDE REGEX "/(main|engine_[a-z]+)\\.cpp$")
add_library(psim_peers STATIC ${_peers_sources})
psim_target_defaults(psim_peers)
target_include_directories(psim_peers PUBLIC bench/peers PRIVATE tests/support)
target_link_libraries(psim_peers PUBLIC psim_accuracy)

add_executable(peers bench/peers/main.cpp)
psim_target_defaults(peers)
target_link_libraries(peers PRIVATE psim_peers psim_parts)
target_compile_definitions(peers PRIVATE
  "PSIM_PEERS_PLOT=\"${PROJECT_SOURCE_DIR}/tools/plot-peers\"")

# Debian's libbullet-dev: single precision.
find_path(PSIM_BULLET_INCLUDE btBulletDynamicsCommon.h PATH_SUFFIXES bullet)
find_library(PSIM_BULLET_DYNAMICS NAMES BulletDynamics)
find_library(PSIM_BULLET_COLLISION NAMES BulletCollision)
find_library(PSIM_BULLET_MATH NAMES LinearMath)
if(PSIM_BULLET_INCLUDE AND PSIM_BULLET_DYNAMICS AND PSIM_BULLET_COLLISION AND PSIM_BULLET_MATH)
  psim_engine(psim_peers bench/peers/engine_bullet.cpp PSIM_WITH_BULLET "${PSIM_BULLET_INCLUDE}"
    "${PSIM_BULLET_DYNAMICS}" "${PSIM_BULLET_COLLISION}" "${PSIM_BULLET_MATH}")
endif()

# Debian's libode-dev: double precision.
find_path(PSIM_ODE_INCLUDE ode/ode.h)
find_library(PSIM_ODE_LIBRARY NAMES ode)
if(PSIM_ODE_INCLUDE AND PSIM_ODE_LIBRARY)
  psim_engine(psim_peers bench/peers/engine_ode.cpp PSIM_WITH_ODE "${PSIM_ODE_INCLUDE}"
    "${PSIM_ODE_LIBRARY}")
  # Its headers do not know.
  find_package(PkgConfig QUIET)
  if(PKG_CONFIG_FOUND)
    pkg_check_modules(PSIM_ODE QUIET ode)
  endif()
  target_compile_definitions(psim_engine_ode PRIVATE "PSIM_ODE_VERSION=\"${PSIM_ODE_VERSION}\"")
endif()

foreach(_engine box2d:libbox2d-dev:PSIM_BOX2D24_LIBRARY chipmunk:libchipmunk-dev:PSIM_CHIPMUNK_LIBRARY
                bullet:libbullet-dev:PSIM_BULLET_DYNAMICS ode:libode-dev:PSIM_ODE_LIBRARY)
  string(REPLACE ":" ";" _engine ${_engine})
  list(GET _engine 0 _name)
  list(GET _engine 1 _package)
  list(GET _engine 2 _library)
  if(NOT ${_library})
    message(STATUS "psim: peers is built without ${_name}: apt install ${_package}")
  endif()
endforeach()
