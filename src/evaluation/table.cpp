#include "evaluation/table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace predictive_stereo {

std::string Table::text() const {
  std::vector<size_t> widths;
  const auto measure = [&](const std::vector<std::string>& row) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  };
  measure(header);
  for (const auto& row : rows) measure(row);
  std::ostringstream out;
  const auto print = [&](const std::vector<std::string>& row) {
    out << " ";
    for (size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - row[i].size() + 1, ' ');
      out << (i == 0 ? " " + row[i] + space.substr(1) : " " + space + row[i]);
    }
    out << "\n";
  };
  out << title << "\n";
  print(header);
  for (const auto& row : rows) print(row);
  return out.str();
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  char text[48];
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

}  // namespace predictive_stereo
