#include "evaluation/report.h"

#include <algorithm>
#include <boost/algorithm/string.hpp>
#include <cmath>
#include <iostream>
#include <utility>

#include "tools/output_file.h"

namespace predictive_stereo {

Table Table::ofCsv(const std::string& header) {
  Table table;
  boost::algorithm::split(table.header, header, [](char c) { return c == ','; });
  return table;
}

std::string Table::text() const {
  std::vector<Row> all = rows;
  all.insert(all.begin(), header);
  std::vector<size_t> widths;
  for (const Row& row : all) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text = title + "\n";
  for (const Row& row : all) {
    text += " ";
    for (size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - row[i].size(), ' ');
      text += i == 0 ? " " + row[i] + space : "  " + space + row[i];
    }
    text += "\n";
  }
  return text;
}

std::string Table::csv() const {
  std::string text = boost::algorithm::join(header, ",") + "\n";
  for (Row row : rows) {
    row.resize(header.size());
    std::transform(row.begin(), row.end(), row.begin(), csvCell);
    text += boost::algorithm::join(row, ",") + "\n";
  }
  return text;
}

std::string fixed(double value, int decimals, const char* otherwise) {
  return std::isfinite(value) ? cv::format("%.*f", decimals, value) : otherwise;
}

YAML::Node reportItem(const std::string& kind, const std::string& value,
                      const std::map<std::string, std::string>& more) {
  YAML::Node item;
  item[kind] = value;  // scripts/report takes the first key for the kind
  for (const auto& [key, text] : more) item[key] = text;
  return item;
}

Report::Report(std::filesystem::path dir, const std::string& title, const std::string& provenance)
    : dir_(std::move(dir)) {
  makeFolder(dir_);
  root_["title"] = title;
  root_["provenance"] = provenance;
  root_["items"] = YAML::Node(YAML::NodeType::Sequence);
}

void Report::add(const Table& table) {
  if (table.rows.empty()) return;
  YAML::Node item = reportItem("table", table.title);
  item["header"] = table.header;
  item["rows"] = table.rows;
  add(item);
}

std::string Report::writeMap(const cv::Mat& values, const cv::Mat1b& known) {
  cv::Mat1w coded;
  values.convertTo(coded, CV_16U, 256);
  coded = cv::max(coded, 1);
  coded.setTo(0, ~known);
  return write(coded);
}

std::string Report::write(const cv::Mat& picture) {
  const std::string file = cv::format("maps/%04d.png", maps_++);
  writePicture(dir_ / file, picture);
  return file;
}

void Report::finish() {
  YAML::Emitter yaml;
  yaml.SetStringFormat(YAML::DoubleQuoted);  // no text may look like a number
  yaml << root_;
  writeText(dir_ / "report.yaml", std::string(yaml.c_str()) + "\n");
  std::cout << "scripts/report " << dir_.string() << " makes a page of it\n";
}

}  // namespace predictive_stereo
