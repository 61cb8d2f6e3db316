#include "evaluation/plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "evaluation/table.h"

namespace predictive_stereo {
namespace {

enum class Anchor { kStart, kMiddle, kEnd };

/// Output of a plot: SVG or a picture.
class Canvas {
 public:
  virtual ~Canvas() = default;
  virtual void line(const std::vector<cv::Point2d>& points, cv::Vec3b rgb, double width) = 0;
  virtual void marker(cv::Point2d centre, cv::Vec3b rgb) = 0;
  virtual void text(cv::Point2d position, const std::string& text, Anchor anchor,
                    bool upright = false) = 0;
};

class SvgCanvas : public Canvas {
 public:
  void line(const std::vector<cv::Point2d>& points, cv::Vec3b rgb, double width) override {
    svg_ << "<polyline fill='none' stroke='" << colour(rgb) << "' stroke-width='" << width
         << "' points='";
    for (const cv::Point2d& point : points) svg_ << round(point.x) << ',' << round(point.y) << ' ';
    svg_ << "'/>\n";
  }
  void marker(cv::Point2d centre, cv::Vec3b rgb) override {
    svg_ << "<circle cx='" << round(centre.x) << "' cy='" << round(centre.y) << "' r='3.5' fill='"
         << colour(rgb) << "'/>\n";
  }
  void text(cv::Point2d position, const std::string& text, Anchor anchor, bool upright) override {
    const char* anchors[] = {"start", "middle", "end"};
    svg_ << "<text x='" << round(position.x) << "' y='" << round(position.y) << "' text-anchor='"
         << anchors[static_cast<int>(anchor)] << "'";
    if (upright)
      svg_ << " transform='rotate(-90 " << round(position.x) << ' ' << round(position.y) << ")'";
    svg_ << ">" << escapedHtml(text) << "</text>\n";
  }
  std::string finish(cv::Size size) const {
    std::ostringstream out;
    out << "<svg xmlns='http://www.w3.org/2000/svg' width='" << size.width << "' height='"
        << size.height << "' viewBox='0 0 " << size.width << ' ' << size.height
        << "' font-family='sans-serif' font-size='12'>\n<rect width='100%' height='100%' "
           "fill='white'/>\n"
        << svg_.str() << "</svg>\n";
    return out.str();
  }

 private:
  static double round(double value) { return std::round(10 * value) / 10; }
  static std::string colour(cv::Vec3b rgb) {
    std::ostringstream text;
    text << "rgb(" << +rgb[0] << ',' << +rgb[1] << ',' << +rgb[2] << ')';
    return text.str();
  }
  std::ostringstream svg_;
};

class PictureCanvas : public Canvas {
 public:
  explicit PictureCanvas(cv::Size size) : image_(size, cv::Vec3b(255, 255, 255)) {}
  void line(const std::vector<cv::Point2d>& points, cv::Vec3b rgb, double width) override {
    std::vector<cv::Point> shifted;
    for (const cv::Point2d& point : points)
      shifted.emplace_back(cvRound(16 * point.x), cvRound(16 * point.y));
    cv::polylines(image_, shifted, false, bgr(rgb), std::max(1, cvRound(width)), cv::LINE_AA, 4);
  }
  void marker(cv::Point2d centre, cv::Vec3b rgb) override {
    cv::circle(image_, centre, 3, bgr(rgb), cv::FILLED, cv::LINE_AA);
  }
  void text(cv::Point2d position, const std::string& text, Anchor anchor, bool upright) override {
    constexpr double kScale = 0.4;
    int baseline = 0;
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kScale, 1, &baseline);
    cv::Mat3b label(size.height + baseline + 4, size.width + 4, cv::Vec3b(255, 255, 255));
    cv::putText(label, text, {2, size.height + 2}, cv::FONT_HERSHEY_SIMPLEX, kScale, {0, 0, 0}, 1,
                cv::LINE_AA);
    const double along = static_cast<double>(anchor) / 2 * label.cols;
    cv::Point corner(cvRound(position.x - along), cvRound(position.y) - size.height - 2);
    if (upright) {
      cv::rotate(label, label, cv::ROTATE_90_COUNTERCLOCKWISE);
      corner = {cvRound(position.x) - size.height - 2, cvRound(position.y - label.rows + along)};
    }
    const cv::Rect target = cv::Rect(corner, label.size()) & cv::Rect({0, 0}, image_.size());
    if (!target.empty()) label(target - corner).copyTo(image_(target));
  }
  cv::Mat3b finish() const { return image_; }

 private:
  static cv::Scalar bgr(cv::Vec3b rgb) { return {1.0 * rgb[2], 1.0 * rgb[1], 1.0 * rgb[0]}; }
  cv::Mat3b image_;
};

/// One axis: maps data values to positions on the canvas.
struct Axis {
  double first = 0, last = 1;  ///< values at the ends
  double first_px = 0, last_px = 1;
  double at(double value) const {
    return first_px + (value - first) / (last - first) * (last_px - first_px);
  }
};

Axis axisOver(double low, double high) {
  if (!(low <= high)) return {};
  if (high - low < 1e-12 * std::max(1.0, std::abs(high))) high = low + 1;
  Axis axis;
  axis.first = low;
  axis.last = high;
  return axis;
}

/// About `wanted` round values between the ends.
std::vector<double> ticks(const Axis& axis, int wanted) {
  const double rough = (axis.last - axis.first) / wanted;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= rough) {
      step = factor * power;
      break;
    }
  std::vector<double> values;
  for (double value = std::ceil(axis.first / step - 1e-9) * step; value <= axis.last + 1e-9 * step;
       value += step)
    values.push_back(std::abs(value) < 1e-9 * step ? 0 : value);
  return values;
}

std::string shortText(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

/// The line of a series; for steps, their outline.
std::vector<cv::Point2d> outline(const PlotSeries& series) {
  if (series.style != PlotSeries::Style::kSteps) return series.points;
  std::vector<cv::Point2d> line;
  for (size_t i = 0; i + 1 < series.points.size(); ++i) {
    line.push_back(series.points[i]);
    line.emplace_back(series.points[i + 1].x, series.points[i].y);
  }
  return line;
}

void draw(const Plot& plot, Canvas& canvas) {
  constexpr double kLeft = 62, kRight = 14, kTop = 28, kBottom = 44;
  // Okabe and Ito's palette, which colour-blind readers can distinguish.
  const std::vector<cv::Vec3b> colours = {{0, 114, 178},   {213, 94, 0},   {0, 158, 115},
                                          {204, 121, 167}, {86, 180, 233}, {230, 159, 0},
                                          {120, 120, 120}, {0, 0, 0}};
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  cv::Point2d low(kInfinity, plot.from_zero ? 0 : kInfinity), high(-kInfinity, -kInfinity);
  for (const PlotSeries& series : plot.series)
    for (const cv::Point2d& point : series.points) {
      low = {std::min(low.x, point.x), std::min(low.y, point.y)};
      high = {std::max(high.x, point.x), std::max(high.y, point.y)};
    }
  Axis x = axisOver(low.x, high.x), y = axisOver(low.y, high.y + 0.05 * (high.y - low.y));
  const double width = plot.size.width - kLeft - kRight, height = plot.size.height - kTop - kBottom;
  if (plot.equal_axes) {
    const double units = 1.05 * std::max((x.last - x.first) / width, (y.last - y.first) / height);
    const double middle_x = (x.first + x.last) / 2, middle_y = (y.first + y.last) / 2;
    x.first = middle_x - units * width / 2, x.last = middle_x + units * width / 2;
    y.first = middle_y - units * height / 2, y.last = middle_y + units * height / 2;
  }
  x.first_px = kLeft, x.last_px = kLeft + width;
  y.first_px = kTop + height, y.last_px = kTop;

  const cv::Vec3b grid(225, 225, 225), frame(90, 90, 90);
  for (const double tick : ticks(x, 8)) {
    canvas.line({{x.at(tick), y.first_px}, {x.at(tick), y.last_px}}, grid, 1);
    canvas.text({x.at(tick), y.first_px + 16}, shortText(tick), Anchor::kMiddle);
  }
  for (const double tick : ticks(y, 6)) {
    canvas.line({{x.first_px, y.at(tick)}, {x.last_px, y.at(tick)}}, grid, 1);
    canvas.text({x.first_px - 6, y.at(tick) + 4}, shortText(tick), Anchor::kEnd);
  }
  canvas.line({{x.first_px, y.last_px}, {x.first_px, y.first_px}, {x.last_px, y.first_px}}, frame,
              1);
  canvas.text({x.first_px + width / 2, kTop - 12}, plot.title, Anchor::kMiddle);
  canvas.text({x.first_px + width / 2, y.first_px + 36}, plot.x_label, Anchor::kMiddle);
  canvas.text({14, kTop + height / 2}, plot.y_label, Anchor::kMiddle, true);

  double legend = kTop + 14;
  for (size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& series = plot.series[i];
    const cv::Vec3b colour = colours[i % colours.size()];
    std::vector<cv::Point2d> points = outline(series);
    for (cv::Point2d& point : points) point = {x.at(point.x), y.at(point.y)};
    if (series.style == PlotSeries::Style::kMarkers)
      for (const cv::Point2d& point : points) canvas.marker(point, colour);
    else if (!points.empty())
      canvas.line(points, colour, 1.8);
    if (series.name.empty()) continue;
    const double legend_x = x.last_px - 10;
    canvas.text({legend_x - 22, legend + 4}, series.name, Anchor::kEnd);
    canvas.line({{legend_x - 16, legend}, {legend_x, legend}}, colour, 3);
    legend += 17;
  }
}

}  // namespace

std::string svg(const Plot& plot) {
  SvgCanvas canvas;
  draw(plot, canvas);
  return canvas.finish(plot.size);
}

cv::Mat3b picture(const Plot& plot) {
  PictureCanvas canvas(plot.size);
  draw(plot, canvas);
  return canvas.finish();
}

}  // namespace predictive_stereo
