/// Configuration files: any text; what it sets is within limits, and goes out and in again.
#include "bytes.h"
#include "nodelets/nodelet_params.h"
#include "params/param_table.h"
#include "params/yaml_params.h"

using namespace predictive_stereo;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  mayRefuse([&] {
    AllNodeletParams params;
    ParamTable table(params);
    setFromYaml(text, "fuzz", table);
    validate(params);
    const std::string yaml = toYaml(table);
    AllNodeletParams again;
    ParamTable other(again);
    try {
      setFromYaml(yaml, "its own yaml", other);
    } catch (const std::exception& error) {
      finding(error.what());
    }
    if (toYaml(other) != yaml) finding("what was written reads as something else: " + yaml);
  });
  mayRefuse([&] {
    AllNodeletParams params;
    ParamTable table(params);
    table.setAssignment(text.c_str());  // no argument holds a zero
    validate(params);
  });
  return 0;
}
