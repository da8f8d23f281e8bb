// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/box_scheme.hpp"

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"

namespace weir::decoders {
namespace {

struct NamedScheme {
  const char *name, *old_name;
  std::unique_ptr<BoxScheme> (*open)(const SchemeOptions& options);
};
constexpr NamedScheme kSchemes[] = {
    {"mobilenet-ssd", "tflite-ssd", open_mobilenet_ssd},
    {"mobilenet-ssd-postprocess", "tf-ssd", open_mobilenet_ssd_postprocess},
    {"ov-person-detection", nullptr, open_openvino},
    {"ov-face-detection", nullptr, open_openvino},
    {"yolov5", nullptr, open_yolov5},
    {"yolov8", nullptr, open_yolov8},
    {"yolov8-obb", nullptr, open_yolov8_obb},
    {"yolov10", nullptr, open_yolov10},
    {"mp-palm-detection", nullptr, open_palm},
};

const NamedScheme& find_scheme(const std::string& name) {
  std::vector<std::string> names;
  for (const NamedScheme& scheme : kSchemes) {
    if (name == scheme.name || (scheme.old_name && name == scheme.old_name)) return scheme;
    names.emplace_back(scheme.name);
  }
  Error error = not_one_of(name.empty() ? "mode=bounding_boxes needs the scheme of the model"
                                        : "mode=bounding_boxes has no such scheme",
                           name.empty() ? "no option1" : "option1=" + name, names);
  const std::string close = nearest(name, names);
  error.difference = close.empty() ? "" : "did you mean " + close + "?";
  error.fix = "option1=" + (close.empty() ? names.front() : close);
  throw Failure(std::move(error));
}

}  // namespace

void check_scheme(const std::string& name) {
  find_scheme(name);
}

std::unique_ptr<BoxScheme> open_scheme(const SchemeOptions& options) {
  return find_scheme(options.name).open(options);
}

}  // namespace weir::decoders
