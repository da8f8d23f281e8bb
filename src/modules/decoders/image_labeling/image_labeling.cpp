// image_labeling: the label of the highest score, as text.
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "weir/decoder.hpp"

namespace {

using weir::Code;
using weir::Failure;

constexpr char kOptions[] =
    R"([{"name":"option1","type":"file","default":"","help":"Label file: one label a line"}])";

// Lines of the file; one line end at the end of the file does not begin another label.
std::vector<std::string> read_labels(const std::string& path) {
  std::error_code ignored;
  std::ifstream file(path, std::ios::binary);
  if (!file.is_open() || !std::filesystem::is_regular_file(path, ignored))
    throw Failure({Code::FILE_NOT_FOUND, "the label file cannot be read", "option1=" + path,
                   "a text file with one label a line", "", "option1=/path/to/labels.txt"});
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (text.ends_with('\n')) text.pop_back();
  if (text.empty())
    throw Failure({Code::LABELS_INVALID, "the label file is empty", "option1=" + path,
                   "one label a line", "", "option1=/path/to/labels.txt"});
  std::vector<std::string> labels;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    labels.push_back(text.substr(begin, end - begin));
    if (labels.back().ends_with('\r')) labels.back().pop_back();
    begin = end + 1;
  }
  return labels;
}

// IEEE 754 binary16 keeps its order when read as a sign and a magnitude; NaN loses every
// comparison.
struct Half {
  uint16_t bits;
  bool nan() const { return (bits & 0x7FFF) > 0x7C00; }
  int order() const { return bits & 0x8000 ? -(bits & 0x7FFF) : bits; }
  bool operator>(const Half& other) const {
    return !nan() && (other.nan() || order() > other.order());
  }
};

// Index of the first greatest element; the memory may have any alignment.
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

size_t first_maximum_of(uint32_t type, const void* data, size_t count) {
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
      throw Failure({Code::FILE_NOT_FOUND, "mode=image_labeling has no label file", "no option1",
                     "a text file with one label a line", "",
                     "tensor_decoder mode=image_labeling option1=/path/to/labels.txt"});
    path_ = *path;
    labels_ = read_labels(path_);
  }

  void configure(std::span<const weir_tensor_info> inputs, weir::DecoderOutput& output) {
    if (!inputs.empty() && !one_score_a_class(inputs[0]))
      throw Failure({Code::SPEC_MISMATCH, "mode=image_labeling takes one score for each class",
                     weir::describe(inputs[0]), "a first tensor of N:1 or N:1:1:1", "",
                     "tensor_filter input-combination, or another mode"});
    output.set_caps("text/x-raw,format=(string)utf8");
  }

  bool decode(const weir_frame& frame, weir::DecoderOutput& output) {
    const weir_tensor& scores = frame.tensors[0];
    const size_t size = weir::element_bytes(scores.info.type);
    const size_t count = size ? scores.bytes / size : 0;
    if (frame.n_tensors == 0 || count == 0 || !one_score_a_class(scores.info))
      throw Failure({Code::SPEC_MISMATCH, "mode=image_labeling takes one score for each class",
                     weir::describe(scores.info), "a first tensor of N:1 or N:1:1:1", "", ""});
    const size_t index = first_maximum_of(scores.info.type, scores.data, count);
    if (index >= labels_.size() || labels_[index].empty())
      throw Failure(
          {Code::LABELS_INVALID, "class " + std::to_string(index) + " has no label",
           path_ + ", " + std::to_string(labels_.size()) + " lines",
           "a label in line " + std::to_string(index + 1) + " of at least " + std::to_string(count),
           "", "option1=the label file of this model"});
    const std::string& label = labels_[index];
    std::memcpy(output.reserve(label.size() + 1).data(), label.c_str(), label.size() + 1);
    return true;
  }

 private:
  static bool one_score_a_class(const weir_tensor_info& info) {
    for (uint32_t i = 1; i < WEIR_RANK_LIMIT; ++i)
      if (weir::dimension(info, i) != 1) return false;
    return weir::dimension(info, 0) > 0;
  }

  std::string path_;
  std::vector<std::string> labels_;
};

}  // namespace

WEIR_DECODER(ImageLabeling, "image_labeling", "", kOptions)
