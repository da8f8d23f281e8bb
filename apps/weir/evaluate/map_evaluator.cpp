// Class maps: intersection over union.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <map>

#include "core/evaluate/segmentation.hpp"
#include "core/records/run_lengths.hpp"
#include "evaluate/evaluator.hpp"

namespace weir::app {
namespace {

constexpr uint32_t kIgnored = 255;  // as the masks of Pascal VOC mark borders

// Sets the pixels of the runs, which go down the columns, to the class.
void paint(const records::RunLengths& runs, uint32_t width, uint32_t height, uint32_t class_index,
           std::vector<uint32_t>* map) {
  uint64_t at = 0;
  bool is_set = false;
  for (const uint32_t run : runs) {
    for (uint64_t i = at; is_set && i < at + run; ++i)
      (*map)[i % height * width + i / height] = class_index;
    at += run;
    is_set = !is_set;
  }
}

class MapEvaluator final : public Evaluator {
 public:
  explicit MapEvaluator(const LabelledFolder& folder) : folder_(folder) {}

  Status accept(const LabelledPicture& picture, const DecodedPicture& decoded) override {
    auto mask = read_class_mask(picture.mask);
    if (!mask) return mask.error();
    const auto size = [](uint32_t width, uint32_t height) {
      return std::to_string(width) + " x " + std::to_string(height) + " pixels";
    };
    if (mask->width != decoded.width || mask->height != decoded.height)
      return Error{.code = Code::LABELS_INVALID,
                   .what = "a mask does not have the size of its picture",
                   .offered = picture.mask + ": " + size(mask->width, mask->height),
                   .needed = picture.path + ": " + size(decoded.width, decoded.height),
                   .fix = "create the mask of this picture again"};
    waiting_[picture.path] = *std::move(mask);
    return ok();
  }

  Status add(size_t, const LabelledPicture& picture, const Json& frame) override {
    const auto node = waiting_.extract(picture.path);
    const ClassMask& truth = node.mapped();
    const auto found = found_map(frame, truth, picture.path);
    if (!found) return found.error();
    auto pixels = evaluate::compare_class_maps(truth.classes, *found, kIgnored);
    for (const auto& one : pixels) classes_ = std::max(classes_, size_t{one.class_index} + 1);
    show(picture, truth, *found, pixels);
    pictures_.push_back(std::move(pixels));
    return ok();
  }

  Result<Evaluation> finish() override {
    const size_t classes = classes_;
    Evaluation out{.metric = "iou",
                   .scores = evaluate::segmentation_scores(pictures_, classes, {}),
                   .headline = 2,
                   .part_name = "class",
                   .part_score = "IoU",
                   .worst = worst_.take(),
                   .units = pictures_.size(),
                   .unit_name = "pictures"};
    const auto overlaps = evaluate::overlap_of_classes(pictures_, classes, {});
    for (size_t c = 0; c < classes; ++c)
      if (!std::isnan(overlaps[c])) out.parts.push_back({get_class_name(c), overlaps[c]});
    out.measure = [pictures = std::move(pictures_), classes](evaluate::Times times) {
      std::vector<double> values;
      for (const auto& score : evaluate::segmentation_scores(pictures, classes, times))
        values.push_back(score.value);
      return values;
    };
    return out;
  }

 private:
  std::string get_class_name(size_t class_index) const {
    const auto name = names_.find(class_index);
    return name == names_.end() ? "class " + std::to_string(class_index) : name->second;
  }

  Result<std::vector<uint32_t>> found_map(const Json& frame, const ClassMask& truth,
                                          const std::string& path) {
    const auto mismatch = [&](std::string what, const std::string& offered) {
      return Error{
          .code = Code::SPEC_MISMATCH,
          .what = std::move(what),
          .offered = path + ": " + offered,
          .needed = "a class map of the picture, because the truth has masks: " + folder_.truth,
          .fix = "a segmentation network, or --mode segmentation"};
    };
    if (!frame.contains("segments"))
      return mismatch("the results have no class map", "no list \"segments\"");
    std::vector<uint32_t> out(truth.classes.size(), evaluate::kNoPixelClass);
    for (const Json& segment : frame["segments"]) {
      const size_t index = segment.value("index", size_t{0});
      names_[index] = segment.value("label", "");
      if (names_[index] == std::to_string(index)) names_[index] = "class " + names_[index];
      if (!segment.contains("mask")) continue;
      const auto& size = segment["mask"]["size"];
      if (size[0] != truth.height || size[1] != truth.width)
        return mismatch("the size of the class map differs from that of the picture",
                        "size " + size.dump());
      const auto runs = records::runs_of_text(
          segment["mask"]["counts"].get_ref<const std::string&>(), truth.classes.size());
      if (!runs) return mismatch("the class map cannot be read", "damaged run lengths");
      paint(*runs, truth.width, truth.height, static_cast<uint32_t>(index), &out);
    }
    return out;
  }

  void show(const LabelledPicture& picture, const ClassMask& truth,
            const std::vector<uint32_t>& found, const std::vector<evaluate::ClassPixels>& pixels) {
    const std::vector<evaluate::ClassPixels> of_picture[]{pixels};
    const double overlap = evaluate::segmentation_scores(of_picture, classes_, {})[0].value;
    Example example{.path = picture.path, .errors = std::isnan(overlap) ? 0 : 1 - overlap};
    if (!worst_.would_keep(example.errors)) return;
    for (size_t i = 0; i < found.size(); ++i)
      example.wrong_pixels.push_back(truth.classes[i] != kIgnored && truth.classes[i] != found[i]);
    example.caption = "mean IoU " + std::to_string(std::lround(overlap * 100)) + " %";
    worst_.add(std::move(example));
  }

  const LabelledFolder& folder_;
  std::map<std::string, ClassMask> waiting_;  // of pictures in the pipeline
  std::map<size_t, std::string> names_;
  std::vector<std::vector<evaluate::ClassPixels>> pictures_;
  size_t classes_ = 0;
  WorstExamples worst_;
};

}  // namespace

std::unique_ptr<Evaluator> make_map_evaluator(const LabelledFolder& folder) {
  return std::make_unique<MapEvaluator>(folder);
}

}  // namespace weir::app
