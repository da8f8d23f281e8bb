// image_labeling decoder: outputs the label of the highest score as text.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cstring>

#include "weir/decoder.hpp"
#include "weir/label_file.hpp"

namespace {

using weir::Code;
using weir::Failure;

constexpr char kOptions[] =
    R"([{"name":"option1","type":"file","default":"","help":"Label file: one label per line"}])";

// An IEEE 754 binary16 value, compared as sign and magnitude; every number is greater than NaN.
struct Half {
  uint16_t bits;
  bool nan() const { return (bits & 0x7FFF) > 0x7C00; }
  int order() const { return bits & 0x8000 ? -(bits & 0x7FFF) : bits; }
  bool operator>(const Half& other) const {
    return !nan() && (other.nan() || order() > other.order());
  }
};

// Returns the index of the first greatest element. `data` may have any alignment.
template <class T>
size_t first_maximum(const void* data, size_t count) {
  size_t best = 0;
  T top{};
  for (size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, static_cast<const char*>(data) + i * sizeof value, sizeof value);
    if (i == 0 || value > top || (top != top && value == value)) best = i, top = value;
  }
  return best;
}
template <>
size_t first_maximum<Half>(const void* data, size_t count) {
  size_t best = 0;
  Half top{0x7E00};
  for (size_t i = 0; i < count; ++i) {
    Half value;
    std::memcpy(&value, static_cast<const char*>(data) + i * sizeof value, sizeof value);
    if (value > top) best = i, top = value;
  }
  return best;
}

size_t find_first_maximum(uint32_t type, const void* data, size_t count) {
  switch (type) {
    case WEIR_INT32:
      return first_maximum<int32_t>(data, count);
    case WEIR_UINT32:
      return first_maximum<uint32_t>(data, count);
    case WEIR_INT16:
      return first_maximum<int16_t>(data, count);
    case WEIR_UINT16:
      return first_maximum<uint16_t>(data, count);
    case WEIR_INT8:
      return first_maximum<int8_t>(data, count);
    case WEIR_UINT8:
      return first_maximum<uint8_t>(data, count);
    case WEIR_FLOAT64:
      return first_maximum<double>(data, count);
    case WEIR_FLOAT32:
      return first_maximum<float>(data, count);
    case WEIR_INT64:
      return first_maximum<int64_t>(data, count);
    case WEIR_UINT64:
      return first_maximum<uint64_t>(data, count);
    default:
      return first_maximum<Half>(data, count);
  }
}

class ImageLabeling {
 public:
  explicit ImageLabeling(const weir::Options& options) {
    const auto path = options.get("option1");
    if (!path || path->empty())
      throw Failure({.code = Code::FILE_NOT_FOUND,
                     .what = "mode=image_labeling has no label file",
                     .offered = "no option1",
                     .needed = "a text file with one label on each line",
                     .fix = "tensor_decoder mode=image_labeling option1=/path/to/labels.txt"});
    path_ = *path;
    labels_ = weir::read_label_file("option1", path_);
  }

  void configure(std::span<const weir_tensor_info> inputs, weir::DecoderOutput& output) {
    if (!inputs.empty()) check(inputs[0]);
    output.set_caps("text/x-raw,format=(string)utf8");
  }

  bool decode(const weir_frame& frame, weir::DecoderOutput& output) {
    if (frame.n_tensors == 0)
      throw Failure({.code = Code::FRAME_SIZE,
                     .what = "mode=image_labeling got a frame without tensors",
                     .needed = "a first tensor of N:1 or N:1:1:1"});
    const weir_tensor& scores = frame.tensors[0];
    check(scores.info);
    const size_t size = weir::element_bytes(scores.info.type);
    const size_t count = static_cast<size_t>(weir::dimension(scores.info, 0));
    if (scores.bytes / size != count || scores.bytes % size != 0)
      throw Failure({.code = Code::FRAME_SIZE,
                     .what = "the frame does not have the size of its shape",
                     .offered = std::to_string(scores.bytes) + " bytes",
                     .needed = weir::describe(scores.info)});
    const size_t index = find_first_maximum(scores.info.type, scores.data, count);
    if (index >= labels_.size() || labels_[index].empty())
      throw Failure({.code = Code::LABELS_INVALID,
                     .what = "class " + std::to_string(index) + " has no label",
                     .offered = path_ + ", " + std::to_string(labels_.size()) + " lines",
                     .needed = "a label in line " + std::to_string(index + 1) + " of at least " +
                               std::to_string(count),
                     .fix = "option1=/path/to/the/labels/of/this/model.txt"});
    const std::string& label = labels_[index];
    std::memcpy(output.reserve(label.size() + 1).data(), label.c_str(), label.size() + 1);
    return true;
  }

 private:
  static void check(const weir_tensor_info& info) {
    bool good = weir::element_bytes(info.type) > 0 && weir::dimension(info, 0) > 0;
    for (uint32_t i = 1; i < WEIR_RANK_LIMIT; ++i) good &= weir::dimension(info, i) == 1;
    if (good) return;
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "mode=image_labeling needs one score for each class",
                   .offered = weir::describe(info),
                   .needed = "a first tensor of N:1 or N:1:1:1",
                   .fix = "tensor_filter output-combination=o0, or another mode"});
  }

  std::string path_;
  std::vector<std::string> labels_;
};

}  // namespace

WEIR_DECODER(ImageLabeling, "image_labeling", "", kOptions)
