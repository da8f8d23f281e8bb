// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/model_fit.hpp"

#include "weir/join.hpp"

#include <algorithm>

namespace weir {
namespace {

std::string list(const std::vector<TensorSpec>& specs) {
  return std::to_string(specs.size()) + (specs.size() == 1 ? " tensor: " : " tensors: ") +
         join(specs, ", ", [](const TensorSpec& spec) { return spec.to_string(); });
}

bool dimensions_fit(const ModelTensor& model, const Shape& stream) {
  if (!model.rank_known) return true;
  const size_t rank = std::max(model.shape.size(), stream.rank());
  for (size_t i = 0; i < rank; ++i) {
    const int64_t offered = i < stream.rank() ? stream[i] : 1;
    if (model.inner(i) >= 0 && model.inner(i) != offered) return false;
  }
  return true;
}

// Describes the first mismatch of a tensor; "" if it fits.
std::string difference(size_t index, const TensorSpec& offered, const ModelTensor& needed) {
  const std::string who = "tensor " + std::to_string(index) +
                          (needed.name.empty() ? "" : " (" + needed.name + ")") + ": ";
  if (needed.type != ElementType::End && offered.type != needed.type)
    return who + "type is " + std::string(to_string(offered.type)) + ", needed is " +
           std::string(to_string(needed.type));
  const size_t rank = std::max(needed.shape.size(), offered.shape.rank());
  for (size_t i = 0; needed.rank_known && i < rank; ++i) {
    const int64_t have = i < offered.shape.rank() ? offered.shape[i] : 1;
    if (needed.inner(i) >= 0 && needed.inner(i) != have)
      return who + "dimension " + std::to_string(i) + " is " + std::to_string(have) +
             ", needed is " + std::to_string(needed.inner(i));
  }
  return "";
}

ModelTensor filled(ModelTensor model, const TensorSpec& stream) {
  model.type = stream.type;
  if (!model.rank_known) {
    model.rank_known = true;
    model.shape = model_tensor(stream).shape;
    return model;
  }
  for (size_t i = 0; i < model.shape.size(); ++i) {
    const size_t from_inside = model.shape.size() - 1 - i;
    if (model.shape[i] < 0)
      model.shape[i] = from_inside < stream.shape.rank() ? stream.shape[from_inside] : 1;
  }
  return model;
}

bool is_picture(const ModelTensor& m, size_t channel_axis) {
  return m.rank_known && m.shape.size() >= 3 && m.shape.size() <= 4 &&
         (m.inner(channel_axis) == 1 || m.inner(channel_axis) == 3 || m.inner(channel_axis) == 4);
}

bool is_real(ElementType type) {
  return type == ElementType::Float16 || type == ElementType::Float32 ||
         type == ElementType::Float64;
}

const char* video_format(int64_t channels) {
  return channels == 1 ? "GRAY8" : channels == 4 ? "RGBA" : "RGB";
}

std::string scaled_video(int64_t channels, int64_t width, int64_t height) {
  std::string caps =
      std::string("videoconvert ! videoscale ! video/x-raw,format=") + video_format(channels);
  if (width > 0) caps += ",width=" + std::to_string(width);
  if (height > 0) caps += ",height=" + std::to_string(height);
  return caps + " ! tensor_converter";
}

// Sets type and shape of tensor `i` of the model, where they do not contradict it.
Status apply_setting(size_t i, const TensorSpec& requested, const std::string& property,
                     ModelTensor* shape) {
  ModelTensor needed = *shape;
  if (!requested.shape.valid()) needed.rank_known = false;
  const std::string diff = difference(i, requested, needed);
  if (!diff.empty())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = property + " contradicts the model",
                 .offered = requested.to_string(),
                 .needed = shape->to_string(),
                 .difference = diff,
                 .fix = "omit " + property + ": the model declares it"};
  if (requested.shape.valid()) *shape = filled(*shape, requested);
  shape->type = requested.type;
  return ok();
}

// Whether several pictures came for a model of one.
bool is_only_longer(const TensorSpec& offered, const ModelTensor& needed) {
  if (!needed.rank_known || needed.shape.size() < 2 || needed.shape[0] != 1) return false;
  TensorSpec one = offered;
  one.shape[needed.shape.size() - 1] = 1;
  return offered.shape.rank() == needed.shape.size() && one.type == needed.type &&
         dimensions_fit(needed, one.shape);
}

// The elements that make tensors of the dimensions of the model from video; "" if it takes no
// picture.
std::string picture_elements(const ModelTensor& needed) {
  if (is_picture(needed, 0)) return scaled_video(needed.inner(0), needed.inner(1), needed.inner(2));
  if (is_picture(needed, 2))
    return scaled_video(needed.inner(2), needed.inner(0), needed.inner(1)) +
           " ! tensor_transform mode=transpose option=1:2:0:3";
  return "";
}

// The elements that convert values of `type` to those of the model; "" if none do.
std::string cast_elements(ElementType type, const ModelTensor& needed) {
  // Real numbers, such as -1 to 1, would all become 0 or 1.
  if (is_real(type) && !is_real(needed.type)) return "";
  const std::string cast =
      "tensor_transform mode=typecast option=" + std::string(to_string(needed.type));
  // Pixels of a quantised model, which typecast would wrap from 128 on.
  const bool is_moved = type == ElementType::UInt8 && needed.type == ElementType::Int8 &&
                        needed.scale > 0 && needed.zero_point == -128;
  return is_moved ? "tensor_transform mode=arithmetic option=typecast:int16,add:-128 ! " + cast
                  : cast;
}

}  // namespace

std::string suggested_fix(const TensorSpec& offered, const ModelTensor& needed) {
  if (is_only_longer(offered, needed))
    return "tensor_filter invoke-rows=1, which runs the model for each of them";
  const bool fits = dimensions_fit(needed, offered.shape);
  const std::string picture = fits ? "" : picture_elements(needed);
  if (!fits && picture.empty()) return "";
  const ElementType type = fits ? offered.type : ElementType::UInt8;  // of video as a tensor
  const std::string begin = fits ? "" : picture + " ! ";
  if (needed.type == ElementType::End || needed.type == type)
    return fits ? "" : begin + "tensor_filter";
  const std::string cast = cast_elements(type, needed);
  return cast.empty() ? "" : begin + cast + " ! tensor_filter";
}

Result<std::vector<ModelTensor>> fit(const std::vector<ModelTensor>& model,
                                     const std::vector<TensorSpec>& stream) {
  if (model.empty()) return fit(std::vector<ModelTensor>(stream.size()), stream);
  if (model.size() != stream.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the stream and the model have different numbers of tensors",
                 .offered = list(stream),
                 .needed = list_tensors(model),
                 .difference = "number of tensors",
                 .fix = stream.size() > model.size() ? "choose tensors with input-combination=0"
                                                     : "join streams with tensor_mux"};
  std::vector<ModelTensor> out;
  for (size_t i = 0; i < model.size(); ++i) {
    const std::string diff = difference(i, stream[i], model[i]);
    if (!diff.empty())
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the stream does not fit the model",
                   .offered = list(stream),
                   .needed = list_tensors(model),
                   .difference = diff,
                   .fix = suggested_fix(stream[i], model[i])};
    out.push_back(filled(model[i], stream[i]));
  }
  return out;
}

Result<std::vector<ModelTensor>> with_user_settings(std::vector<ModelTensor> model,
                                                    const std::string& dimensions,
                                                    const std::string& types,
                                                    const std::string& property) {
  const auto set_shapes =
      dimensions.empty() ? Result(std::vector<Shape>()) : parse_shape_list(dimensions);
  if (!set_shapes) return set_shapes.error();
  const auto set_types =
      types.empty() ? Result(std::vector<ElementType>()) : parse_type_list(types);
  if (!set_types) return set_types.error();
  const size_t n = std::max(set_shapes->size(), set_types->size());
  if (n == 0) return model;
  if (model.empty()) model.resize(n);
  if (model.size() != n)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = property + " and the model have different numbers of tensors",
                 .offered = std::to_string(n),
                 .needed = list_tensors(model),
                 .difference = "number of tensors"};
  for (size_t i = 0; i < n; ++i) {
    TensorSpec requested;
    requested.type = i < set_types->size() ? (*set_types)[i] : model[i].type;
    if (i < set_shapes->size()) requested.shape = (*set_shapes)[i];
    if (auto status = apply_setting(i, requested, property, &model[i]); !status)
      return status.error();
  }
  return model;
}

}  // namespace weir
