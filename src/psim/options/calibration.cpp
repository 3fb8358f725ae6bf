#include "options/calibration.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace psim::cli {
namespace {

// kind,measure,integrator,rate,dt,substeps,error,bodies,pairs,ns_per_frame
constexpr std::size_t kColumns = 10;

std::array<std::string_view, kColumns> fields_of(std::string_view line) {
  std::array<std::string_view, kColumns> fields;
  for (std::size_t k = 0; k < kColumns; ++k) {
    const std::size_t comma = line.find(',');
    if ((comma == line.npos) != (k + 1 == kColumns)) {
      throw std::runtime_error("calibration: not 10 columns: " + std::string(line));
    }
    fields[k] = line.substr(0, comma);
    if (comma != line.npos) line.remove_prefix(comma + 1);
  }
  return fields;
}

double number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw std::runtime_error("calibration: no number: " + std::string(text));
  }
  return value;
}

CalibrationRow row_of(std::string_view line) {
  const auto f = fields_of(line);
  const auto kind = parse_scene_kind(f[0]);
  const auto integrator = parse_integrator(f[2]);
  if (!kind || !integrator) {
    throw std::runtime_error("calibration: unknown kind or integrator: " + std::string(line));
  }
  CalibrationRow row;
  row.kind = *kind;
  row.measure = f[1];
  row.integrator = *integrator;
  row.substeps = static_cast<int>(number(f[5]));
  row.rate_h = number(f[3]) * number(f[4]) / row.substeps;
  row.error = number(f[6]);
  row.bodies = number(f[7]);
  row.pairs = number(f[8]);
  row.ns_per_frame = number(f[9]);
  return row;
}

double items_of(const CalibrationRow& row) { return costs_by_body(row.kind) ? row.bodies : row.pairs; }

}  // namespace

Calibration::Calibration(std::string_view csv) {
  bool header = true;
  while (!csv.empty()) {
    const std::size_t end = std::min(csv.find('\n'), csv.size());
    const std::string_view line = csv.substr(0, end);
    csv.remove_prefix(std::min(end + 1, csv.size()));
    if (!header && !line.empty()) rows_.push_back(row_of(line));
    header = false;
  }
  std::ranges::sort(rows_, {}, &CalibrationRow::rate_h);
}

std::vector<CalibrationRow> Calibration::rows_of(SceneKind kind, Integrator integrator) const {
  std::vector<CalibrationRow> rows;
  std::ranges::copy_if(rows_, std::back_inserter(rows),
                       [&](const CalibrationRow& row) { return row.kind == kind && row.integrator == integrator; });
  return rows;
}

double Calibration::error(SceneKind kind, Integrator integrator, double rate_h) const {
  constexpr double kLeast = 1e-12;  // zero has no logarithm
  double x = 0, e = 0;              // the row before, and the largest error so far
  for (const CalibrationRow& row : rows_of(kind, integrator)) {
    const double here = std::max({e, row.error, kLeast});
    if (rate_h <= row.rate_h) {
      if (x == 0 || !std::isfinite(here)) return here;
      const double part = std::log(rate_h / x) / std::log(row.rate_h / x);
      return e * std::pow(here / e, part);
    }
    x = row.rate_h;
    e = here;
  }
  return std::numeric_limits<double>::infinity();
}

std::string_view Calibration::measure(SceneKind kind) const {
  const auto row = std::ranges::find(rows_, kind, &CalibrationRow::kind);
  return row == rows_.end() ? std::string_view("not measured") : row->measure;
}

std::vector<Integrator> Calibration::integrators(SceneKind kind) const {
  std::vector<Integrator> found;
  for (const Integrator integrator : kAllIntegrators) {
    if (!rows_of(kind, integrator).empty()) found.push_back(integrator);
  }
  return found;
}

// Least squares of relative errors: sum ((body bodies + item items substeps) / ns - 1)^2.
FrameCost Calibration::cost(SceneKind kind, Integrator integrator) const {
  double aa = 0, ab = 0, bb = 0, a1 = 0, b1 = 0, pairs = 0, bodies = 0;
  for (const CalibrationRow& row : rows_of(kind, integrator)) {
    const double a = row.bodies / row.ns_per_frame;
    const double b = items_of(row) * row.substeps / row.ns_per_frame;
    aa += a * a, ab += a * b, bb += b * b, a1 += a, b1 += b;
    pairs += row.pairs, bodies += row.bodies;
  }
  const double determinant = aa * bb - ab * ab;
  FrameCost cost;
  cost.body = std::max((a1 * bb - b1 * ab) / determinant, 0.0);
  cost.item = std::max((aa * b1 - ab * a1) / determinant, 0.0);
  cost.pairs_per_body = pairs / bodies;
  return cost;
}

}  // namespace psim::cli
