// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/element/model_event.hpp"

#include <cmath>
#include <cstring>

namespace weir::gst {
namespace {

constexpr char kModelName[] = "weir-model";
constexpr guint kModelVersion = 1;
constexpr size_t kMaxTextBytes = size_t{16} << 20;  // labels of a model may be in its metadata
constexpr size_t kMaxNameLength = 4096;

class Array {
 public:
  Array() { g_value_init(&value_, GST_TYPE_ARRAY); }
  Array(const Array&) = delete;
  Array& operator=(const Array&) = delete;
  ~Array() { g_value_unset(&value_); }
  void add(GType type, auto&& set) {
    GValue item = G_VALUE_INIT;
    g_value_init(&item, type);
    set(&item);
    gst_value_array_append_and_take_value(&value_, &item);
  }
  void move_to(GstStructure* structure, const char* field) {
    gst_structure_take_value(structure, field, &value_);
    value_ = G_VALUE_INIT;
    g_value_init(&value_, GST_TYPE_ARRAY);
  }

 private:
  GValue value_ = G_VALUE_INIT;
};

GstStructure* make_structure(const ModelTensor& tensor) {
  const bool known = tensor.type != ElementType::End;
  GstStructure* out = gst_structure_new(
      "tensor", "type", G_TYPE_STRING, known ? std::string(to_string(tensor.type)).c_str() : "",
      "name", G_TYPE_STRING, tensor.name.c_str(), "scale", G_TYPE_DOUBLE, double{tensor.scale},
      "zero-point", G_TYPE_INT, int{tensor.zero_point}, nullptr);
  Array shape;
  for (const int64_t extent : tensor.shape)
    shape.add(G_TYPE_INT64, [extent](GValue* value) { g_value_set_int64(value, extent); });
  shape.move_to(out, "shape");
  return out;
}

void set_tensors(GstStructure* event, const char* field, const std::vector<ModelTensor>& tensors) {
  Array list;
  for (const ModelTensor& tensor : tensors)
    list.add(GST_TYPE_STRUCTURE,
             [&](GValue* value) { g_value_take_boxed(value, make_structure(tensor)); });
  list.move_to(event, field);
}

// The text of a field, which may be missing; nullopt if it is none or too long.
std::optional<std::string> get_string(const GstStructure* structure, const char* field,
                                      size_t max) {
  if (!gst_structure_has_field(structure, field)) return std::string();
  const char* text = gst_structure_get_string(structure, field);
  if (!text || strnlen(text, max + 1) > max) return std::nullopt;
  return std::string(text);
}

// The items of an array; null if the field is no array of at most `max`.
const GValue* get_array(const GstStructure* structure, const char* field, guint max) {
  const GValue* value = gst_structure_get_value(structure, field);
  const bool valid =
      value && GST_VALUE_HOLDS_ARRAY(value) && gst_value_array_get_size(value) <= max;
  return valid ? value : nullptr;
}

std::optional<ModelTensor> parse_tensor(const GstStructure* structure) {
  ModelTensor out;
  const auto type = get_string(structure, "type", kMaxNameLength);
  auto name = get_string(structure, "name", kMaxNameLength);
  const GValue* shape = get_array(structure, "shape", kRankLimit);
  double scale = 0;
  int zero_point = 0;
  if (!type || !name || !shape || !gst_structure_get_double(structure, "scale", &scale) ||
      !gst_structure_get_int(structure, "zero-point", &zero_point))
    return std::nullopt;
  out.type = type->empty() ? ElementType::End : parse_element_type(*type);
  if (!type->empty() && out.type == ElementType::End) return std::nullopt;
  for (guint i = 0; i < gst_value_array_get_size(shape); ++i) {
    const GValue* extent = gst_value_array_get_value(shape, i);
    if (!G_VALUE_HOLDS_INT64(extent)) return std::nullopt;
    out.shape.push_back(g_value_get_int64(extent));
    if (out.shape.back() < -1) return std::nullopt;
  }
  out.rank_known = out.type != ElementType::End || !out.shape.empty();
  out.scale = static_cast<float>(scale);
  if (!std::isfinite(out.scale)) return std::nullopt;
  out.name = *std::move(name);
  out.zero_point = zero_point;
  return out;
}

std::optional<std::vector<ModelTensor>> parse_tensors(const GstStructure* event,
                                                      const char* field) {
  const GValue* list = get_array(event, field, kTensorLimit);
  if (!list) return std::nullopt;
  std::vector<ModelTensor> out;
  for (guint i = 0; i < gst_value_array_get_size(list); ++i) {
    const GValue* item = gst_value_array_get_value(list, i);
    if (!GST_VALUE_HOLDS_STRUCTURE(item)) return std::nullopt;
    const GstStructure* structure = gst_value_get_structure(item);
    auto tensor = structure ? parse_tensor(structure) : std::nullopt;
    if (!tensor) return std::nullopt;
    out.push_back(*std::move(tensor));
  }
  return out;
}

}  // namespace

Ref<GstEvent> make_model_event(const DescribedModel& model) {
  GstStructure* out = gst_structure_new(kModelName, "version", G_TYPE_UINT, kModelVersion, "path",
                                        G_TYPE_STRING, model.path.c_str(), "metadata",
                                        G_TYPE_STRING, model.metadata_json.c_str(), nullptr);
  set_tensors(out, "inputs", model.inputs);
  set_tensors(out, "outputs", model.outputs);
  return Ref<GstEvent>::adopt(gst_event_new_custom(GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, out));
}

bool is_model_event(GstEvent* event) noexcept {
  return GST_EVENT_TYPE(event) == GST_EVENT_CUSTOM_DOWNSTREAM_STICKY &&
         gst_event_has_name(event, kModelName);
}

std::optional<DescribedModel> parse_model_event(GstEvent* event) {
  if (!is_model_event(event)) return std::nullopt;
  const GstStructure* structure = gst_event_get_structure(event);
  guint version = 0;
  if (!gst_structure_get_uint(structure, "version", &version) || version != kModelVersion)
    return std::nullopt;
  auto inputs = parse_tensors(structure, "inputs"), outputs = parse_tensors(structure, "outputs");
  auto path = get_string(structure, "path", kMaxTextBytes);
  auto metadata = get_string(structure, "metadata", kMaxTextBytes);
  if (!inputs || !outputs || !path || !metadata) return std::nullopt;
  return DescribedModel{*std::move(inputs), *std::move(outputs), *std::move(path),
                        *std::move(metadata)};
}

std::optional<DescribedModel> find_model(GstPad* pad) {
  for (guint i = 0;; ++i) {
    const auto event =
        Ref<GstEvent>::adopt(gst_pad_get_sticky_event(pad, GST_EVENT_CUSTOM_DOWNSTREAM_STICKY, i));
    if (!event) return std::nullopt;
    if (auto model = parse_model_event(event.get())) return model;
  }
}

}  // namespace weir::gst
