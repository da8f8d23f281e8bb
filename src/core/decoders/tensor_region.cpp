// Writes the best boxes of an SSD model as a flexible tensor (docs/compatibility/decoder.md 5.7).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/decoders/decoders.hpp"

#include <algorithm>
#include <cstring>

#include "core/decoders/box_scheme.hpp"
#include "core/decoders/option_text.hpp"
#include "core/decoders/stream_model.hpp"
#include "core/tensor/geometry.hpp"
#include "core/tensor/tensor_header.hpp"
#include "core/text/text.hpp"
#include "weir/decoder.hpp"
#include "weir/label_file.hpp"

namespace weir::decoders {
namespace {

constexpr char kRegionOptions[] =
    R"([{"name":"option1","type":"integer","default":"1","help":"Number of regions"},)"
    R"({"name":"option2","type":"file","default":"","help":"Label file: one label per line"},)"
    R"({"name":"option3","type":"string","default":"",)"
    R"("help":"File of prior boxes and thresholds, as for mobilenet-ssd of bounding_boxes"},)"
    R"({"name":"option4","type":"string","default":"300:300",)"
    R"("help":"Size of the model's input, W:H"}])";

constexpr uint64_t kMaxRegions = 2034;  // as many as the model has anchors
constexpr size_t kValues = 4;           // x, y, width and height of a region

size_t read_regions(const Options& options) {
  const std::string text(options.get("option1").value_or(""));
  if (text.empty()) return 1;
  const auto regions = parse_unsigned(strip(text));
  if (regions && *regions > 0 && *regions <= kMaxRegions) return *regions;
  throw Failure({.code = regions ? Code::OPTION_VALUE : Code::OPTION_SYNTAX,
                 .what = "option1 is not a number of regions",
                 .offered = "option1=" + text,
                 .needed = "a whole number from 1 to " + std::to_string(kMaxRegions),
                 .fix = "option1=1"});
}

size_t count_labels(const Options& options) {
  const std::string path(options.get("option2").value_or(""));
  if (!path.empty()) return read_label_file("option2", path).size();
  throw Failure({.code = Code::FILE_NOT_FOUND,
                 .what = "mode=tensor_region has no label file",
                 .offered = "no option2",
                 .needed = "a text file with one label on each line, for all classes",
                 .fix = "option2=/path/to/labels.txt"});
}

Size read_input_size(const Options& options) {
  if (options.get("option4").value_or("").empty()) return {300, 300};
  const auto size = read_size(options, "option4", "the size of the model's input");
  return {size.width, size.height};
}

class TensorRegion {
 public:
  explicit TensorRegion(const Options& options)
      : regions_(read_regions(options)),
        scheme_(open_mobilenet_ssd_of_first_class(
            {.name = "tensor_region",
             .parameters = std::string(options.get("option3").value_or("")),
             .labels = count_labels(options),
             .input = read_input_size(options),
             .selected_by = "mode"})) {
    header_.format = Format::Static;  // as NNStreamer writes it, although the stream is flexible
    header_.spec.type = ElementType::UInt32;
    header_.spec.shape = Shape::parse("4:" + std::to_string(regions_));
  }

  void set_model(const weir_stream_model* model) noexcept { model_.set(model); }

  void configure(std::span<const weir_tensor_info> inputs, DecoderOutput& output) {
    if (!inputs.empty()) {
      infos_.clear();
      for (const auto& info : inputs) infos_.push_back(&info);
      scheme_->check(infos_);
    }
    output.set_caps("other/tensors,format=(string)flexible");
  }

  bool decode(const weir_frame& frame, DecoderOutput& output) {
    const std::span<const weir_tensor> tensors(frame.tensors, frame.n_tensors);
    infos_.clear();
    for (const weir_tensor& tensor : tensors) infos_.push_back(&tensor.info);
    scheme_->check(infos_);
    const detection::PixelBoxes boxes = scheme_->find(model_.with_quantisation(tensors));
    const auto bytes = output.reserve(kTensorHeaderBytes + kValues * regions_ * sizeof(uint32_t));
    write_tensor_header(header_, bytes.first<kTensorHeaderBytes>());
    std::byte* to = bytes.data() + kTensorHeaderBytes;
    for (size_t i = 0; i < regions_; ++i, to += kValues * sizeof(uint32_t)) {
      // A region that is not used is zero.
      const detection::PixelBox box = i < boxes.size() ? boxes[i] : detection::PixelBox{};
      const auto value = [](int32_t number) { return static_cast<uint32_t>(std::max(number, 0)); };
      const uint32_t region[kValues] = {value(box.x), value(box.y), value(box.width),
                                        value(box.height)};
      std::memcpy(to, region, sizeof region);
    }
    return true;
  }

 private:
  size_t regions_;
  std::unique_ptr<BoxScheme> scheme_;
  StreamModel model_;
  TensorHeader header_;
  std::vector<const weir_tensor_info*> infos_;  // of the frame, kept for its memory
};

}  // namespace

const weir_decoder_type& tensor_region() {
  static const weir_decoder_type table =
      decoder_table<TensorRegion>("tensor_region", "", kRegionOptions);
  return table;
}

}  // namespace weir::decoders
