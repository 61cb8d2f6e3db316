#pragma once

#include <string>

namespace predictive_stereo {

/// A complete HTML page in this package's style.
/// @param body  HTML.
/// @param provenance  plain text: how the page was made; shown at its end.
std::string htmlDocument(const std::string& title, const std::string& body,
                         const std::string& provenance);

}  // namespace predictive_stereo
