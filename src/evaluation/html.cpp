#include "evaluation/html.h"

#include "evaluation/table.h"

namespace predictive_stereo {
namespace {

constexpr char kStyle[] = R"(
body { font-family: sans-serif; margin: 2em auto; max-width: 1300px; color: #222; }
table { border-collapse: collapse; margin: 1em 0; font-size: 14px; }
caption { text-align: left; font-weight: bold; padding: .3em 0; }
th, td { padding: .2em .7em; text-align: right; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child { text-align: left; }
tr:hover td { background: #f3f7fb; }
figure { display: inline-block; margin: .4em; }
figcaption { font-size: 13px; }
pre { background: #f5f5f5; padding: .8em; overflow-x: auto; }
)";

}  // namespace

std::string htmlDocument(const std::string& title, const std::string& body,
                         const std::string& provenance) {
  return "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'><title>predictive_stereo: " +
         escapedHtml(title) + "</title><style>" + kStyle + "</style></head><body>\n<h1>" +
         escapedHtml(title) + "</h1>\n" + body + "<h2>How this page was made</h2>\n<pre>" +
         escapedHtml(provenance) + "</pre>\n</body></html>\n";
}

}  // namespace predictive_stereo
