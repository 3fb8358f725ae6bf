#include "report.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <iomanip>
#include <numeric>

#include "run.h"

namespace psim::peers {
namespace {

std::string rounded(double value, int digits) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits).ptr;
  return {text.data(), end};
}

std::string quoted(const std::string& text) { return text.find(',') == std::string::npos ? text : '"' + text + '"'; }

}  // namespace

double quantile_ms(const Row& row, double q) {
  std::vector<double> sorted = row.frame_ms;
  std::ranges::sort(sorted);
  return accuracy::quantile(sorted, q);
}

double mean_ms(const Row& row) {
  const double sum = std::accumulate(row.frame_ms.begin(), row.frame_ms.end(), 0.0);
  return row.frame_ms.empty() ? 0 : sum / static_cast<double>(row.frame_ms.size());
}

void write_header(std::ostream& out) {
  out << "engine,version,setting,recommended,threads,scene,bodies,frames,repeats,ms_mean,ms_p50,"
         "ms_p99";
  for (const ErrorColumn& column : error_columns()) out << ',' << column.name;
  out << ",note\n";
}

void write_row(std::ostream& out, const Row& row) {
  out << row.engine << ',' << row.version << ',' << quoted(row.setting) << ',' << (row.recommended ? "yes" : "no")
      << ',' << row.threads << ',' << row.scene << ',' << row.bodies << ',' << row.frame_ms.size() << ',' << row.repeats
      << ',';
  if (!row.frame_ms.empty()) {
    out << rounded(mean_ms(row), 4) << ',' << rounded(quantile_ms(row, 0.5), 4) << ','
        << rounded(quantile_ms(row, 0.99), 4);
  } else {
    out << ",,";
  }
  for (const ErrorColumn& column : error_columns()) {
    out << ',';
    if (row.errors.*column.value) out << rounded(*(row.errors.*column.value), 4);
  }
  out << ',' << quoted(row.note) << '\n';
}

void write_times_header(std::ostream& out) { out << "engine,setting,threads,scene,bodies,frame,ms\n"; }

void write_times(std::ostream& out, const Row& row) {
  for (std::size_t frame = 0; frame < row.frame_ms.size(); ++frame) {
    out << row.engine << ',' << quoted(row.setting) << ',' << row.threads << ',' << row.scene << ',' << row.bodies
        << ',' << frame << ',' << rounded(row.frame_ms[frame], 4) << '\n';
  }
}

void print_scene(std::ostream& out, const std::vector<Row>& rows) {
  if (rows.empty()) return;
  std::vector<const ErrorColumn*> columns;
  for (const ErrorColumn& column : error_columns()) {
    if (std::ranges::any_of(rows, [&](const Row& r) { return (r.errors.*column.value).has_value(); }))
      columns.push_back(&column);
  }
  constexpr int kEngine = 9, kSetting = 35, kFigure = 11;
  out << rows[0].scene << ", " << rows[0].bodies << " bodies\n"
      << std::left << std::setw(kEngine) << "engine" << std::setw(kSetting) << "setting" << std::right;
  for (const char* head : {"mean ms", "p50 ms", "p99 ms"}) out << std::setw(kFigure) << head;
  for (const ErrorColumn* column : columns) out << std::setw(kFigure + 1) << column->head;
  out << '\n';
  for (const Row& row : rows) {
    out << std::left << std::setw(kEngine) << row.engine << std::setw(kSetting)
        << row.setting + (row.recommended ? " *" : "") << std::right;
    if (!row.note.empty()) {
      out << "   " << row.note << '\n';
      continue;
    }
    for (const double ms : {mean_ms(row), quantile_ms(row, 0.5), quantile_ms(row, 0.99)}) {
      out << std::setw(kFigure) << rounded(ms, 3);
    }
    for (const ErrorColumn* column : columns) {
      const auto& value = row.errors.*column->value;
      out << std::setw(kFigure + 1) << (value ? rounded(*value, 2) : "");
    }
    out << '\n';
  }
  out << '\n';
}

}  // namespace psim::peers
