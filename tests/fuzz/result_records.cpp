// Fuzz target: reads frames of results with any columns, tensors and bytes, and writes them in each
// text format. JSON parses, has no number that is not finite, and lists every object.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/records/record_writer.hpp"
#include "fuzz_input.hpp"

namespace {

using namespace weir;
using fuzz::FuzzInput;
using fuzz::require;

void check_json(const std::string& text, const records::ResultFrame& frame) {
  require(!text.empty() && text.find('\n') == text.size() - 1, "a frame is one line");
  const auto json = nlohmann::json::parse(text, nullptr, false);
  require(!json.is_discarded(), "JSON parses");
  size_t entries = 0;
  for (const char* list : {"labels", "detections", "text"})
    if (json.contains(list)) entries += json[list].size();
  require(entries == frame.objects.size(), "every object is listed");
  const size_t detections = json.contains("detections") ? json["detections"].size() : 0;
  for (const char* list : {"labels", "detections", "text"})
    for (const auto& entry : json.value(list, nlohmann::json::array()))
      require(!entry.contains("parent") || entry["parent"].get<size_t>() < detections,
              "a parent is a detection");
}

// Masks of large pictures take time, not code.
records::FrameFacts facts_from(FuzzInput* input) {
  records::FrameFacts out{.running_time = input->take<int64_t>(),
                          .duration = input->take<int64_t>(),
                          .unix_time = input->take<int64_t>(),
                          .width = input->byte(),
                          .height = input->byte()};
  if (!input->flag()) return out;
  SourceMap map;
  for (double* number : {&map.xx, &map.xy, &map.x0, &map.yx, &map.yy, &map.y0})
    *number = input->take<float>();
  out.maps.push_back(map);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzInput input(data, size);
  const std::string columns(input.line()), sources(input.line());
  const auto reader = records::ResultReader::make(columns, sources);
  if (!reader) {
    require(!reader.error().what.empty(), "an error has a text");
    return 0;
  }
  const auto facts = facts_from(&input);
  std::vector<records::ResultTensor> tensors;
  const uint32_t count = input.below(6);
  for (uint32_t i = 0; i < count; ++i) {
    records::ResultTensor tensor;
    tensor.spec.type = static_cast<ElementType>(input.below(11));
    tensor.spec.shape = Shape{input.byte(), input.byte(), input.byte(), input.rarely() ? 3u : 1u};
    const size_t bytes = input.rarely() ? input.byte() : tensor.spec.bytes().value_or(0);
    tensor.bytes = input.bytes(bytes);
    tensors.push_back(std::move(tensor));
  }
  records::ResultFrame frame;
  if (!reader->read(tensors, &frame)) return 0;
  const records::WriterSettings settings{.has_masks = true, .has_coco_ids = true};
  for (const auto make :
       {records::json_writer, records::coco_writer, records::mot_writer, records::webvtt_writer}) {
    const auto writer = make(settings);
    std::string text;
    const bool is_written = writer->write(*reader, frame, facts, &text);
    require(is_written != text.empty(), "what is written is not empty");
    if (make == records::json_writer) check_json(text, frame);
  }
  return 0;
}
