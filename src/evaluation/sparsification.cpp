#include "evaluation/sparsification.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace predictive_stereo {
namespace {

// Mean over n of the mean of the first n values, for n = 1 ... size.
double areaUnder(const std::vector<double>& values) {
  double sum = 0, area = 0;
  for (size_t n = 0; n < values.size(); ++n) {
    sum += values[n];
    area += sum / static_cast<double>(n + 1);
  }
  return values.empty() ? 0 : area / static_cast<double>(values.size());
}

}  // namespace

void Sparsification::add(double error_px, double doubt) {
  pixels_.push_back({static_cast<float>(doubt), static_cast<float>(std::abs(error_px))});
}

Sparsification& Sparsification::operator+=(const Sparsification& other) {
  pixels_.insert(pixels_.end(), other.pixels_.begin(), other.pixels_.end());
  return *this;
}

double Sparsification::meanError_px() const {
  double sum = 0;
  for (const Pixel& pixel : pixels_) sum += pixel.error_px;
  return pixels_.empty() ? 0 : sum / static_cast<double>(pixels_.size());
}

double Sparsification::ause_px() const {
  std::vector<Pixel> sorted = pixels_;
  std::sort(sorted.begin(), sorted.end(),
            [](const Pixel& a, const Pixel& b) { return a.doubt < b.doubt; });
  std::vector<double> errors_px;
  for (auto begin = sorted.begin(); begin != sorted.end();) {
    const auto end = std::find_if(begin, sorted.end(),
                                  [&](const Pixel& pixel) { return pixel.doubt > begin->doubt; });
    double sum = 0;
    for (auto pixel = begin; pixel != end; ++pixel) sum += pixel->error_px;
    errors_px.insert(errors_px.end(), static_cast<size_t>(end - begin),
                     sum / static_cast<double>(end - begin));
    begin = end;
  }
  return areaUnder(errors_px) - meanError_px() + auseOfNothing_px();
}

double Sparsification::auseOfNothing_px() const {
  std::vector<double> errors_px;
  for (const Pixel& pixel : pixels_) errors_px.push_back(pixel.error_px);
  std::sort(errors_px.begin(), errors_px.end());
  return meanError_px() - areaUnder(errors_px);
}

}  // namespace predictive_stereo
