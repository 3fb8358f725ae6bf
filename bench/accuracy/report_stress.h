// `accuracy --stress`: what the engines stand, a row a figure, each held against a stated limit.
#pragma once

#include <ostream>
#include <vector>

#include "engines/engine.h"

namespace psim::accuracy {

/// Measures psim and whatever other engines are given, each with its default setting, in
/// about two minutes; `quick`: runs a tenth as long, no large crowds, 20 s. A table of it goes to
/// `table`, a row as soon as it is known, and CSV to `csv` if that is not null. Returns how many
/// limits psim missed.
int report_stress(const std::vector<Engine>& engines, Effort effort, std::ostream& table, std::ostream* csv);

}  // namespace psim::accuracy
