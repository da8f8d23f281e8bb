// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/families.hpp"

#include <algorithm>

#include "core/heads/output_shapes.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"

namespace weir::heads {
namespace {

// clang-format off
constexpr const Family* kFamilies[] = {
    &kBlazeface,
    &kBlazepose,
    &kBlazeposeDetection,
    &kClassMap,
    &kClassifier,
    &kCtc,
    &kDb,
    &kDeepLab,
    &kDepthMap,
    &kDetectionOutput,
    &kDetr,
    &kFaceLandmarks,
    &kFastestDet,
    &kHandLandmarks,
    &kHeatMaps,
    &kLabelsBoxesScores,
    &kMovenet,
    &kMovenetMultipose,
    &kNanoDet,
    &kPalmDetection,
    &kPosenet,
    &kRtDetr,
    &kSsd,
    &kSsdPostprocess,
    &kUltraface,
    &kUltrafaceRaw,
    &kYoloNas,
    &kYolov10,
    &kYolov3Grids,
    &kYolov5,
    &kYolov5Grids,
    &kYolov5Segmentation,
    &kYolov7EndToEnd,
    &kYolov7Grids,
    &kYolov8,
    &kYolov8Obb,
    &kYolov8Pose,
    &kYolov8Segmentation,
    &kYolox,
    &kYunet,
};
// clang-format on

std::vector<std::string> get_names(const Family& family) {
  std::vector<std::string> out{std::string(family.name)};
  for (const auto& alias : parse_name_list(family.aliases)) out.push_back(alias);
  return out;
}

std::vector<const Family*> list_families(uint32_t tasks) {
  std::vector<const Family*> out;
  for (const Family* family : kFamilies)
    if (family->tasks & tasks) out.push_back(family);
  return out;
}

std::string list_names(const std::vector<const Family*>& families, const char* before,
                       const char* between) {
  return join(families, between,
              [before](const Family* family) { return before + std::string(family->name); });
}

void check_sizes(const ModelSignature& model) {
  constexpr uint64_t kMaxElements = uint64_t{1} << 31;
  for (const OutputSignature& output : model.outputs) {
    const auto count = output.shape.valid() ? output.shape.count() : std::optional<uint64_t>(0);
    if (count && *count > 0 && *count <= kMaxElements) continue;
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "an output of the model has no usable size",
                   .offered = model.describe_outputs(),
                   .needed = "extents above 0, at most 2147483648 elements"});
  }
}

// The families that read the outputs if the user names them: rows for a picture of another size,
// for example.
std::vector<const Family*> list_openable(const ModelSignature& model,
                                         std::vector<const Family*> families) {
  std::erase_if(families, [&](const Family* family) {
    try {
      family->open(model, {});
      return false;
    } catch (const Failure&) {
      return true;
    }
  });
  return families;
}

std::string describe_input(const ModelSignature& model) {
  return model.input.width == 0 ? ""
                                : " of an input of " + std::to_string(model.input.width) + " x " +
                                      std::to_string(model.input.height);
}

}  // namespace

std::string ModelSignature::describe_outputs() const {
  return join(outputs, ", ", [](const OutputSignature& output) {
    const auto text = output.to_string();
    return output.name.empty() ? text : text + " '" + output.name + "'";
  });
}

std::span<const Family* const> all_families() {
  return kFamilies;
}

const Family& family_named(std::string_view name, uint32_t tasks, const std::string& option) {
  const auto families = list_families(tasks);
  std::vector<std::string> words;
  for (const Family* family : families)
    for (const auto& word : get_names(*family)) {
      if (equal_ignoring_case(word, name)) return *family;
      words.push_back(word);
    }
  const std::string close = nearest(std::string(name), words);
  throw Failure({.code = Code::OPTION_VALUE,
                 .what = "this mode has no such head",
                 .offered = option + std::string(name),
                 .needed = "one of: " + join(words, ", "),
                 .difference = close.empty() ? "" : "did you mean " + close + "?",
                 .fix = close.empty() ? "" : option + close});
}

std::unique_ptr<Head> open_head(const Family& family, const ModelSignature& model,
                                const HeadOptions& options) {
  check_sizes(model);
  return family.open(model, options);
}

std::vector<const Family*> fitting(const ModelSignature& model, uint32_t tasks) {
  check_sizes(model);
  std::vector<const Family*> possible, certain;
  for (const Family* family : list_families(tasks)) {
    const Match fit = family->fit(model);
    if (fit != Match::No) possible.push_back(family);
    if (fit == Match::Certain) certain.push_back(family);
  }
  return certain.empty() ? possible : certain;
}

Error nothing_fits(const ModelSignature& model, uint32_t tasks, const std::string& option) {
  constexpr size_t kMaxDescribed = 8, kMaxNamed = 10;
  if (looks_like_picture(model)) return picture_instead_of_results(model, option + "deeplab");
  const auto families = list_families(tasks);
  const auto openable = list_openable(model, families);
  auto described = openable.empty() ? families : openable;
  std::string needed = join(described, "; ", [](const Family* family) {
    return std::string(family->name) + ": " + std::string(family->outputs);
  });
  if (const size_t count = described.size(); count > kMaxDescribed) {
    described.resize(std::min(count, kMaxNamed));
    needed = "the outputs of a head of docs/heads.md: " + list_names(described, "", ", ");
    if (count > kMaxNamed) needed += " and " + std::to_string(count - kMaxNamed) + " others";
  } else if (openable.empty()) {
    needed += " (docs/heads.md)";
  }
  return {.code = Code::SPEC_MISMATCH,
          .what = "no head of this mode fits these outputs",
          .offered = model.describe_outputs() + describe_input(model),
          .needed = std::move(needed),
          .fix = model.input.width == 0
                     ? "tensor_decoder custom=input:640:640, the size of the model's input"
                     : list_names(openable, option.c_str(), " or ")};
}

const Family& recognise(const ModelSignature& model, uint32_t tasks) {
  const auto found = fitting(model, tasks);
  if (found.empty()) throw Failure(nothing_fits(model, tasks, "tensor_decoder custom=head:"));
  if (found.size() == 1) return *found[0];
  throw Failure({.code = Code::SPEC_MISMATCH,
                 .what = "the outputs fit several heads: " + list_names(found, "", ", "),
                 .offered = model.describe_outputs(),
                 .needed = "the name of the head",
                 .fix = list_names(found, "tensor_decoder custom=head:", " or ")});
}

}  // namespace weir::heads
