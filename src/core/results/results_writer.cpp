// Writes rows and tables after tensor headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/results_writer.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/tensor/tensor_header.hpp"
#include "weir/join.hpp"
#include "weir/module.hpp"

namespace weir::results {
namespace {

// The columns before the key points; rows without boxes lack the first four and the rotation.
constexpr char kBoxColumns[] = "x1,y1,x2,y2,score,class,track,parent,rotation";
constexpr char kPlainColumns[] = "score,class,track,parent";
constexpr size_t kBoxNumbers = 9, kPlainNumbers = 4, kPointNumbers = 3;

size_t row_length(const Features& features) {
  return (features.has_boxes ? kBoxNumbers : kPlainNumbers) +
         kPointNumbers * features.points_per_object;
}

// Calls `visit` with the name of each table.
template <class Visit>
void for_each_table(const Features& features, Visit visit) {
  if (features.has_masks) visit("masks");
  if (features.has_class_scores) visit("scores");
  if (features.has_texts) visit("text");
  if (features.has_class_map) visit("class-map");
  if (features.has_depth) visit("depth");
}

// Reserves a tensor and writes its header; returns the payload.
std::span<std::byte> begin_tensor(ElementType type, const Shape& shape, size_t element,
                                  const Reserve& reserve) {
  TensorHeader header;
  header.format = Format::Flexible;
  header.spec = {.type = type, .shape = shape, .name = {}};
  const auto bytes =
      reserve(kTensorHeaderBytes + static_cast<size_t>(shape.count().value_or(0)) * element);
  write_tensor_header(header, bytes.first<kTensorHeaderBytes>());
  return bytes.subspan(kTensorHeaderBytes);
}

template <class T>
void write_values(ElementType type, const Shape& shape, std::span<const T> values,
                  const Reserve& reserve) {
  const auto to = begin_tensor(type, shape, sizeof(T), reserve);
  const size_t bytes = std::min(to.size(), values.size_bytes());
  if (bytes > 0) std::memcpy(to.data(), values.data(), bytes);
  std::fill(to.begin() + static_cast<ptrdiff_t>(bytes), to.end(), std::byte{});
}

uint32_t narrow(size_t number) {
  return static_cast<uint32_t>(number);
}

void write_row(const Object& object, const Features& features, const KeyPoint* points,
               std::byte* to) {
  const auto put = [&](float number) {
    std::memcpy(to, &number, sizeof number);
    to += sizeof number;
  };
  if (features.has_boxes)
    for (const float edge : {object.box.x1, object.box.y1, object.box.x2, object.box.y2}) put(edge);
  put(object.score);
  put(static_cast<float>(object.class_index));
  put(static_cast<float>(object.track));
  put(static_cast<float>(object.parent));
  if (features.has_boxes) put(object.rotation);
  for (size_t i = 0; i < features.points_per_object; ++i)
    for (const float number : {points[i].x, points[i].y, points[i].score}) put(number);
}

void write_rows(const FrameResults& results, const Features& features, const Reserve& reserve) {
  const size_t length = row_length(features), rows = std::max<size_t>(1, results.objects.size());
  const auto to =
      begin_tensor(ElementType::Float32, {narrow(length), narrow(rows)}, sizeof(float), reserve);
  if (results.objects.empty()) std::fill(to.begin(), to.end(), std::byte{});
  for (size_t i = 0; i < results.objects.size(); ++i)
    write_row(results.objects[i], features, results.points.data() + i * features.points_per_object,
              to.data() + i * length * sizeof(float));
}

void write_texts(const FrameResults& results, uint32_t rows, const Reserve& reserve) {
  size_t longest = 1;
  for (const auto& text : results.texts) longest = std::max(longest, text.size());
  const auto to = begin_tensor(ElementType::UInt8, {narrow(longest), rows}, 1, reserve);
  std::fill(to.begin(), to.end(), std::byte{});
  for (size_t i = 0; i < results.texts.size(); ++i)
    std::memcpy(to.data() + i * longest, results.texts[i].data(), results.texts[i].size());
}

template <class T>
void move_to(std::vector<T>* from, std::vector<T>* to) {
  if (to->empty())
    std::swap(*from, *to);
  else
    to->insert(to->end(), std::make_move_iterator(from->begin()),
               std::make_move_iterator(from->end()));
}

// Nearest neighbour, by the centres of pixels.
std::vector<uint8_t> resampled(const std::vector<uint8_t>& masks, uint32_t width, uint32_t height,
                               uint32_t to_width, uint32_t to_height) {
  const size_t from_size = size_t{width} * height, count = masks.size() / from_size;
  std::vector<uint8_t> out;
  out.reserve(count * to_width * to_height);
  for (size_t i = 0; i < count; ++i)
    for (uint32_t y = 0; y < to_height; ++y)
      for (uint32_t x = 0; x < to_width; ++x) {
        const size_t from_x = (2 * size_t{x} + 1) * width / (2 * size_t{to_width});
        const size_t from_y = (2 * size_t{y} + 1) * height / (2 * size_t{to_height});
        out.push_back(masks[i * from_size + from_y * width + from_x]);
      }
  return out;
}

void append_masks(FrameResults* part, FrameResults* all) {
  if (part->masks.empty()) return;
  const uint32_t width = std::max(part->mask_width, all->masks.empty() ? 0 : all->mask_width);
  const uint32_t height = std::max(part->mask_height, all->masks.empty() ? 0 : all->mask_height);
  for (FrameResults* results : {part, all}) {
    const bool fits = results->mask_width == width && results->mask_height == height;
    if (!fits && !results->masks.empty())
      results->masks =
          resampled(results->masks, results->mask_width, results->mask_height, width, height);
    results->mask_width = width, results->mask_height = height;
  }
  move_to(&part->masks, &all->masks);
}

}  // namespace

void FrameResults::clear() noexcept {
  objects.clear();
  points.clear();
  masks.clear();
  class_scores.clear();
  texts.clear();
  class_map.clear();
  depth.clear();
}

std::string make_columns(const Features& features) {
  std::string out = features.has_boxes ? kBoxColumns : kPlainColumns;
  if (features.points_per_object > 0) out += ",xys:" + std::to_string(features.points_per_object);
  for_each_table(features, [&](const char* name) { out += std::string(";") + name; });
  return out;
}

size_t tensor_count(const Features& features) {
  size_t count = 1;
  for_each_table(features, [&](const char*) { ++count; });
  return count;
}

std::string make_caps(const Features& features, const std::string& source) {
  std::string name = source;
  // The separator of the list, and what ends a quoted text.
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == ';' || c == '"' || c == '\\'; }, '_');
  const std::string sources = join(std::vector(tensor_count(features), name), ";");
  return "other/tensors,format=(string)flexible,weir-columns=(string)\"" + make_columns(features) +
         "\",weir-source=(string)\"" + sources + "\"";
}

void write(const FrameResults& results, const Features& features, const Reserve& reserve) {
  const uint32_t rows = narrow(std::max<size_t>(1, results.objects.size()));
  write_rows(results, features, reserve);
  if (features.has_masks)
    write_values<uint8_t>(
        ElementType::UInt8,
        {std::max(1u, results.mask_width), std::max(1u, results.mask_height), rows}, results.masks,
        reserve);
  if (features.has_class_scores)
    write_values<float>(ElementType::Float32,
                        {narrow(std::max<size_t>(1, results.n_classes)), rows},
                        results.class_scores, reserve);
  if (features.has_texts) write_texts(results, rows, reserve);
  const Shape map{std::max(1u, results.map_width), std::max(1u, results.map_height)};
  if (features.has_class_map)
    write_values<uint16_t>(ElementType::UInt16, map, results.class_map, reserve);
  if (features.has_depth) write_values<float>(ElementType::Float32, map, results.depth, reserve);
}

void append(FrameResults* part, const Features& features, FrameResults* all) {
  const bool has_map = !all->class_map.empty() || !all->depth.empty();
  if ((features.has_class_map || features.has_depth) && has_map)
    throw Failure({.code = Code::SPEC_MISMATCH,
                   .what = "a frame has one map, not one for each region",
                   .offered = "a batch of regions",
                   .needed = "one picture in each frame",
                   .fix = "tensor_preprocess max-regions=1"});
  append_masks(part, all);
  all->points_per_object = features.points_per_object;
  all->n_classes = part->n_classes;
  move_to(&part->objects, &all->objects);
  move_to(&part->points, &all->points);
  move_to(&part->class_scores, &all->class_scores);
  move_to(&part->texts, &all->texts);
  if (features.has_class_map || features.has_depth)
    all->map_width = part->map_width, all->map_height = part->map_height;
  move_to(&part->class_map, &all->class_map);
  move_to(&part->depth, &all->depth);
}

}  // namespace weir::results
