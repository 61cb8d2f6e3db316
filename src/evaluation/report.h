/// Results as data: tables and diagrams, and a folder of them from which scripts/report makes a
/// page.
#pragma once

#include <yaml-cpp/emitter.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace predictive_stereo {

/// A table of texts, to print or for a page. The first column is aligned left.
struct Table {
  std::string title;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;

  std::string text() const;
};

/// A number with this many decimals; "-" if it is not finite.
std::string fixed(double value, int decimals);

struct PlotSeries {
  std::string name;                 ///< in the legend; empty: not in the legend
  std::vector<cv::Point2d> points;  ///< "steps": (left end, height) of bars; the last one ends them
  std::string style = "line";       ///< or "markers" or "steps"
};

/// A diagram with two axes, which scripts/report draws.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool equal_axes = false;  ///< one unit has the same length in x and y, for maps
};

/// A picture with its explanation.
struct Panel {
  std::string caption;
  cv::Mat3b image;
};

/// Results as data for a page: a folder with report.yaml and pictures. scripts/report makes
/// index.html of it.
class Report {
 public:
  /// Makes the folder.
  /// @param provenance  how the results were made; at the end of the page.
  /// @throws std::runtime_error if the folder cannot be made.
  Report(std::filesystem::path dir, const std::string& title, const std::string& provenance);

  const std::filesystem::path& dir() const { return dir_; }

  void addHeading(const std::string& text);
  void addText(const std::string& text);
  /// Nothing if it has no rows.
  void add(const Table& table);
  void add(const Plot& plot);
  /// Writes the picture at once, with a number as its name.
  /// @throws std::runtime_error if it cannot be written.
  void add(const Panel& panel);
  /// A picture that is there already.
  /// @param file  relative to the folder.
  void addPicture(const std::string& file, const std::string& caption);

  /// Writes report.yaml, and says on standard output how to make the page. Nothing may follow.
  /// @throws std::runtime_error if it cannot be written.
  void finish();

 private:
  template <class Value>
  void write(const char* key, const Value& value);
  void beginItem(const char* kind, const std::string& value);

  std::filesystem::path dir_;
  YAML::Emitter yaml_;
  size_t items_ = 0;
};

}  // namespace predictive_stereo
