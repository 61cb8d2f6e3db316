#pragma once

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

}  // namespace predictive_stereo
