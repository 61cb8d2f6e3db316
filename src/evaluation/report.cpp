#include "evaluation/report.h"

#include <yaml-cpp/yaml.h>

#include <cstdio>
#include <iostream>
#include <utility>

#include "tools/output_file.h"

namespace predictive_stereo {
namespace {

void write(YAML::Emitter& out, const Table& table) {
  out << YAML::Key << "table" << YAML::Value << table.title << YAML::Key << "header" << YAML::Value
      << YAML::Flow << table.header << YAML::Key << "rows" << YAML::Value << YAML::BeginSeq;
  for (const auto& row : table.rows) out << YAML::Flow << row;
  out << YAML::EndSeq;
}

const char* nameOf(PlotSeries::Style style) {
  switch (style) {
    case PlotSeries::Style::kLine:
      return "line";
    case PlotSeries::Style::kMarkers:
      return "markers";
    case PlotSeries::Style::kSteps:
      return "steps";
  }
  return "";
}

void write(YAML::Emitter& out, const Plot& plot) {
  out << YAML::Key << "plot" << YAML::Value << plot.title << YAML::Key << "x_label" << YAML::Value
      << plot.x_label << YAML::Key << "y_label" << YAML::Value << plot.y_label << YAML::Key
      << "equal_axes" << YAML::Value << plot.equal_axes << YAML::Key << "series" << YAML::Value
      << YAML::BeginSeq;
  for (const PlotSeries& series : plot.series) {
    std::vector<double> x, y;
    for (const cv::Point2d& point : series.points) {
      x.push_back(point.x);
      y.push_back(point.y);
    }
    out << YAML::BeginMap << YAML::Key << "name" << YAML::Value << series.name << YAML::Key
        << "style" << YAML::Value << nameOf(series.style) << YAML::Key << "x" << YAML::Value
        << YAML::Flow << x << YAML::Key << "y" << YAML::Value << YAML::Flow << y << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

}  // namespace

Report::Report(std::filesystem::path dir, std::string title, std::string provenance)
    : dir_(std::move(dir)), title_(std::move(title)), provenance_(std::move(provenance)) {
  makeFolder(dir_);
}

void Report::addHeading(const std::string& text) { items_.emplace_back(Heading{text}); }
void Report::addText(const std::string& text) { items_.emplace_back(Text{text}); }
void Report::add(const Table& table) {
  if (!table.rows.empty()) items_.emplace_back(table);
}
void Report::add(const Plot& plot) { items_.emplace_back(plot); }

void Report::add(const Panel& panel) {
  char file[32];
  std::snprintf(file, sizeof(file), "pictures/%04zu.png", items_.size());
  writePicture(dir_ / file, panel.image);
  addPicture(file, panel.caption);
}

void Report::addPicture(const std::string& file, const std::string& caption) {
  items_.emplace_back(Picture{file, caption});
}

void Report::finish() const {
  struct Writer {
    YAML::Emitter& out;
    void operator()(const Heading& item) {
      out << YAML::Key << "heading" << YAML::Value << item.text;
    }
    void operator()(const Text& item) { out << YAML::Key << "text" << YAML::Value << item.text; }
    void operator()(const Table& item) { write(out, item); }
    void operator()(const Plot& item) { write(out, item); }
    void operator()(const Picture& item) {
      out << YAML::Key << "picture" << YAML::Value << item.file << YAML::Key << "caption"
          << YAML::Value << item.caption;
    }
  };
  YAML::Emitter out;
  out.SetStringFormat(YAML::DoubleQuoted);
  out.SetDoublePrecision(7);
  out << YAML::BeginMap << YAML::Key << "title" << YAML::Value << title_ << YAML::Key
      << "provenance" << YAML::Value << provenance_ << YAML::Key << "items" << YAML::Value
      << YAML::BeginSeq;
  for (const Item& item : items_) {
    out << YAML::BeginMap;
    std::visit(Writer{out}, item);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  writeText(dir_ / "report.yaml", std::string(out.c_str()) + "\n");
  std::cout << "scripts/report " << dir_.string() << " makes a page of it\n";
}

}  // namespace predictive_stereo
