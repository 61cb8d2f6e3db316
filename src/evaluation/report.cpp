#include "evaluation/report.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <utility>

#include "tools/output_file.h"

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

Report::Report(std::filesystem::path dir, const std::string& title, const std::string& provenance)
    : dir_(std::move(dir)) {
  makeFolder(dir_);
  yaml_.SetStringFormat(YAML::DoubleQuoted);
  yaml_.SetDoublePrecision(7);
  yaml_ << YAML::BeginMap;
  write("title", title);
  write("provenance", provenance);
  write("items", YAML::BeginSeq);
}

template <class Value>
void Report::write(const char* key, const Value& value) {
  yaml_ << YAML::Key << key << YAML::Value << value;
}

void Report::beginItem(const char* kind, const std::string& value) {
  ++items_;
  yaml_ << YAML::BeginMap;
  write(kind, value);
}

void Report::addHeading(const std::string& text) {
  beginItem("heading", text);
  yaml_ << YAML::EndMap;
}

void Report::addText(const std::string& text) {
  beginItem("text", text);
  yaml_ << YAML::EndMap;
}

void Report::add(const Table& table) {
  if (table.rows.empty()) return;
  beginItem("table", table.title);
  yaml_ << YAML::Key << "header" << YAML::Value << YAML::Flow << table.header;
  write("rows", YAML::BeginSeq);
  for (const auto& row : table.rows) yaml_ << YAML::Flow << row;
  yaml_ << YAML::EndSeq << YAML::EndMap;
}

void Report::add(const Plot& plot) {
  beginItem("plot", plot.title);
  write("x_label", plot.x_label);
  write("y_label", plot.y_label);
  write("equal_axes", plot.equal_axes);
  write("series", YAML::BeginSeq);
  for (const PlotSeries& series : plot.series) {
    std::vector<double> x, y;
    for (const cv::Point2d& point : series.points) {
      x.push_back(point.x);
      y.push_back(point.y);
    }
    yaml_ << YAML::BeginMap;
    write("name", series.name);
    write("style", series.style);
    yaml_ << YAML::Key << "x" << YAML::Value << YAML::Flow << x;
    yaml_ << YAML::Key << "y" << YAML::Value << YAML::Flow << y << YAML::EndMap;
  }
  yaml_ << YAML::EndSeq << YAML::EndMap;
}

void Report::add(const Panel& panel) {
  char file[32];
  std::snprintf(file, sizeof(file), "pictures/%04zu.png", items_);
  writePicture(dir_ / file, panel.image);
  addPicture(file, panel.caption);
}

void Report::addPicture(const std::string& file, const std::string& caption) {
  beginItem("picture", file);
  write("caption", caption);
  yaml_ << YAML::EndMap;
}

void Report::finish() {
  yaml_ << YAML::EndSeq << YAML::EndMap;
  writeText(dir_ / "report.yaml", std::string(yaml_.c_str()) + "\n");
  std::cout << "scripts/report " << dir_.string() << " makes a page of it\n";
}

}  // namespace predictive_stereo
