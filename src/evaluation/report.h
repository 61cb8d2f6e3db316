#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <variant>
#include <vector>

#include "evaluation/plot.h"
#include "evaluation/table.h"

namespace predictive_stereo {

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
  Report(std::filesystem::path dir, std::string title, std::string provenance);

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

  /// Writes report.yaml, and says on standard output how to make the page.
  /// @throws std::runtime_error if it cannot be written.
  void finish() const;

 private:
  struct Heading {
    std::string text;
  };
  struct Text {
    std::string text;
  };
  struct Picture {
    std::string file, caption;
  };
  using Item = std::variant<Heading, Text, Table, Plot, Picture>;

  std::filesystem::path dir_;
  std::string title_, provenance_;
  std::vector<Item> items_;
};

}  // namespace predictive_stereo
