// The scenes, what is watched in them, and one run of one of them.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engines.h"
#include "engines/model.h"

namespace psim::peers {

using accuracy::Model;

enum class Size { quick, normal, full };

/// What can be wrong; a scene has those that mean something in it.
struct Errors {
  std::optional<double> deepest;       ///< m, overlap, the largest of all looks
  std::optional<double> overlap_p99;   ///< m, of the overlaps at the end
  std::optional<double> passed_walls;  ///< bodies beyond the walls at the end
  std::optional<double> energy_drift;  ///< (E - E0) / E0 at the end
  std::optional<double> rest_speed;    ///< m/s, root mean square at the end
  std::optional<double> sway;          ///< m, the body moved furthest sideways since the start
  std::optional<double> sink;          ///< m, the body that came down most
  std::optional<double> joint_gap;     ///< m, the largest of all looks
};

/// A column of the table and of the CSV.
struct ErrorColumn {
  const char* name;  ///< with its unit
  const char* head;
  std::optional<double> Errors::*value;
};
const std::vector<ErrorColumn>& error_columns();

struct Comparison {
  std::string name;
  std::string shows;
  std::function<Scene(Size)> scene;
  bool overlaps = true;
  bool energy = false;  ///< must hold
  bool rests = false;
  bool stands = false;  ///< nothing may move
  bool sleeping = false;
  int settle = 0;  ///< frames before the clock runs
  int frames = 0;  ///< that are timed and looked at
};

std::vector<Comparison> all_comparisons();

/// A scene file of the user's, watched for overlaps and joints.
Comparison comparison_of_file(const std::string& path);
/// A built-in scene of psim, "psim:NAME" or "psim:NAME:BODIES", watched likewise. Throws std::invalid_argument.
Comparison comparison_of_builtin(const std::string& words);

/// What one run gives. `failed` says why it did not get through.
struct Result {
  std::vector<double> frame_ms;
  Errors errors;
  std::string failed;
};

/// Settles, then runs and times the scene; one thread by the time that the process used, more by the
/// clock on the wall. `look`: reads the state every so often, too, between frames that are timed.
Result run(const Comparison& of, const Model& model, int frames, const Engine& engine, const Setting& setting,
           bool look);

}  // namespace psim::peers
