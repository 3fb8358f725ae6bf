#include "csv.h"

#include <array>
#include <charconv>
#include <string>

namespace psim::accuracy {
namespace {

std::string shortest(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string rounded(double value, int digits) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits).ptr;
  return {text.data(), end};
}

std::string quoted(std::string text) {
  if (text.find(',') == std::string::npos) return text;
  text.insert(0, 1, '"');
  text += '"';
  return text;
}

}  // namespace

void write_header(std::ostream& out) {
  out << "case,engine,setting,h,iterations,seconds_per_sim_second,row_visits,error,unit,"
         "reference\n";
}

void write_row(std::ostream& out, const Row& row) {
  const Setting& s = row.setting;
  out << row.quantity->name << ',' << row.engine->name << ',' << quoted(s.curve + (s.is_default ? " default" : ""))
      << ',' << shortest(s.h()) << ',' << s.iterations << ',' << rounded(row.seconds_per_sim_second, 4) << ','
      << rounded(row.row_visits, 4) << ',' << rounded(row.error, 6) << ',' << quoted(row.quantity->unit) << ','
      << quoted(row.quantity->reference) << '\n';
}

}  // namespace psim::accuracy
