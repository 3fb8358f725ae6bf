// Tidy CSV, a row a point. Errors have six digits, costs four; a failed run has the error `inf`;
// the default setting's name ends in ` default`.
#pragma once

#include <ostream>
#include <vector>

#include "sweep.h"

namespace psim::accuracy {

void write_header(std::ostream& out);
void write_row(std::ostream& out, const Row& row);

}  // namespace psim::accuracy
