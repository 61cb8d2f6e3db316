/// Results as data: tables to print, and a folder from which scripts/report makes a page.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

namespace predictive_stereo {

using Row = std::vector<std::string>;

/// A row of cells: texts, numbers (with six digits), and rows, of which each cell is added.
template <class... Cells>
Row row(const Cells&... cells) {
  Row row;
  const auto add = [&](const auto& cell) {
    using Cell = std::decay_t<decltype(cell)>;
    if constexpr (std::is_same_v<Cell, Row>) {
      row.insert(row.end(), cell.begin(), cell.end());
    } else if constexpr (std::is_arithmetic_v<Cell>) {
      std::ostringstream text;
      text << cell;
      row.push_back(text.str());
    } else {
      row.emplace_back(cell);
    }
  };
  (add(cells), ...);
  return row;
}

/// A number with this many decimals; `otherwise` if it is not finite.
std::string fixed(double value, int decimals, const char* otherwise = "-");

/// A table, to print, for a page, or to be written as CSV.
struct Table {
  std::string title;
  Row header;
  std::vector<Row> rows = {};

  /// @param header  its names, with commas between them.
  static Table ofCsv(const std::string& header);

  template <class... Cells>
  void add(const Cells&... cells) {
    rows.push_back(row(cells...));
  }
  /// In columns; the first one is aligned left.
  std::string text() const;
  /// Header and rows. Texts with a comma or a quotation mark are quoted; the cells that a row lacks
  /// are empty.
  std::string csv() const;
};

/// A part of a page: the data and where they are. scripts/report knows the kinds, says what the
/// figures mean, and draws them.
/// @param kind  e.g. "heading"; `value` is its text, or the file with its figures.
/// @param more  further values by their keys.
YAML::Node reportItem(const std::string& kind, const std::string& value,
                      const std::map<std::string, std::string>& more = {});

/// Results as data for a page: a folder with report.yaml, CSV and maps. scripts/report makes
/// index.html of it.
class Report {
 public:
  /// Makes the folder.
  /// @param provenance  how the results were made; at the end of the page.
  /// @throws std::runtime_error if the folder cannot be made.
  Report(std::filesystem::path dir, const std::string& title, const std::string& provenance);

  const std::filesystem::path& dir() const { return dir_; }

  void add(const YAML::Node& item) { root_["items"].push_back(item); }
  /// Nothing if it has no rows.
  void add(const Table& table);
  /// Writes a map as a 16-bit PNG, as KITTI does: 256 times the value, at least 1; 0 where it is
  /// not known. It is named by a number.
  /// @returns the file, relative to the folder.
  /// @throws std::runtime_error if it cannot be written.
  std::string writeMap(const cv::Mat& values, const cv::Mat1b& known);
  /// The same for a picture as it is.
  std::string write(const cv::Mat& picture);

  /// Writes report.yaml, and says on standard output how to make the page. Nothing may follow.
  /// @throws std::runtime_error if it cannot be written.
  void finish();

 private:
  std::filesystem::path dir_;
  YAML::Node root_;
  int maps_ = 0;
};

}  // namespace predictive_stereo
