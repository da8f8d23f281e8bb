// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/model_fit.hpp"

#include "weir/join.hpp"

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string_view>

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

// Whether the tensor has the dimensions of the model in this order.
bool has_order(const TensorSpec& offered, const std::vector<size_t>& order,
               const ModelTensor& needed) {
  for (size_t i = 0; i < order.size(); ++i) {
    const int64_t wanted = needed.inner(i);
    const int64_t have = order[i] < offered.shape.rank() ? offered.shape[order[i]] : 1;
    if (wanted >= 0 && wanted != have) return false;
  }
  return true;
}

// The dimensions in the order in which `from` has moved to `to`.
std::vector<size_t> moved(size_t rank, size_t from, size_t to) {
  std::vector<size_t> order;
  for (size_t i = 0; i < rank; ++i)
    if (i != from) order.push_back(i);
  order.insert(order.begin() + static_cast<std::ptrdiff_t>(to), from);
  return order;
}

// The transposition of `offered` that the model takes, in which one dimension moves and the others
// keep their order; "" if there is none.
std::string transposition(const TensorSpec& offered, const ModelTensor& needed) {
  constexpr size_t kShort = 4;  // dimensions of an option whose last one stays
  const size_t rank = std::max({offered.shape.rank(), needed.shape.size(), kShort});
  for (size_t from = 0; from < rank; ++from)
    for (size_t to = 0; to < rank; ++to) {
      auto order = moved(rank, from, to);
      if (!has_order(offered, order, needed)) continue;
      if (rank == kShort && order.back() != kShort - 1) order.push_back(kShort);
      return "tensor_transform mode=transpose option=" +
             join(order, ":", [](size_t i) { return std::to_string(i); });
    }
  return "";
}

// Whether both are pictures with the colours in the innermost dimension, so that another order of
// dimensions would be a picture that lies on its side.
bool are_packed_pictures(const TensorSpec& offered, const ModelTensor& needed) {
  return looks_like_picture(offered) && is_picture(needed, 0) &&
         needed.inner(0) == int64_t{offered.shape[0]};
}

// The element that collects frames until dimension `i` of the stream has `extent`, and what comes
// then; "" if the window does not fit either.
std::string window(TensorSpec offered, const ModelTensor& needed, size_t i, int64_t extent) {
  const int64_t have = offered.shape[i];
  if (extent <= have || extent > UINT32_MAX || extent % have != 0) return "";
  offered.shape[i] = static_cast<uint32_t>(extent);
  std::string collected = "tensor_aggregator frames-out=" + std::to_string(extent / have) +
                          " frames-dim=" + std::to_string(i);
  if (dimensions_fit(needed, offered.shape)) return collected;
  const std::string turned = transposition(offered, needed);
  return turned.empty() ? "" : collected + " ! " + turned;
}

// The same for each dimension of the stream, the outermost one first; "" if there is none.
std::string find_window(const TensorSpec& offered, const ModelTensor& needed) {
  for (size_t i = offered.shape.rank(); i-- > 0;)
    for (size_t k = 0; k < needed.shape.size(); ++k)
      if (auto out = window(offered, needed, i, needed.inner(k)); !out.empty()) return out;
  return "";
}

// Elements that read the same values as the model's dimensions, of which open ones are 1; "" if the
// numbers of values differ.
std::string reading_elements(const TensorSpec& offered, const ModelTensor& needed) {
  TensorSpec out{needed.type == ElementType::End ? offered.type : needed.type, {}, ""};
  for (size_t i = 0; i < needed.shape.size(); ++i)
    out.shape[i] = static_cast<uint32_t>(std::max<int64_t>(needed.inner(i), 1));
  if (needed.shape.empty() || needed.shape.size() > kRankLimit ||
      out.shape.count() != offered.shape.count())
    return "";
  return "tensor_decoder mode=octet_stream ! tensor_converter input-dim=" + out.shape.to_string() +
         " input-type=" + std::string(to_string(out.type));
}

// The elements that give the tensor the dimensions of the model; "" if there are none.
std::string shaping_elements(const TensorSpec& offered, const ModelTensor& needed) {
  if (!needed.rank_known) return "";
  const bool are_pictures = are_packed_pictures(offered, needed);
  if (auto out = are_pictures ? "" : transposition(offered, needed); !out.empty()) return out;
  if (auto out = reading_elements(offered, needed); !out.empty()) return out;
  return are_pictures ? "" : find_window(offered, needed);
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

// For each input of the model the first tensor that fits and that no input before it has; nullopt
// where there is none.
std::vector<std::optional<size_t>> match_inputs(const std::vector<ModelTensor>& model,
                                                const std::vector<TensorSpec>& stream) {
  std::vector<std::optional<size_t>> out(model.size());
  std::vector<bool> is_used(stream.size());
  for (size_t i = 0; i < model.size(); ++i)
    for (size_t k = 0; k < stream.size() && !out[i]; ++k) {
      if (is_used[k] || !difference(i, stream[k], model[i]).empty()) continue;
      out[i] = k;
      is_used[k] = true;
    }
  return out;
}

Error other_number(const std::vector<ModelTensor>& model, const std::vector<TensorSpec>& stream) {
  const auto matches = match_inputs(model, stream);
  Error out{.code = Code::SPEC_MISMATCH,
            .what = "the stream and the model have different numbers of tensors",
            .offered = list(stream),
            .needed = list_tensors(model),
            .difference = "number of tensors"};
  if (stream.size() > model.size()) {
    const bool is_complete = std::all_of(matches.begin(), matches.end(),
                                         [](const auto& match) { return match.has_value(); });
    if (is_complete)
      out.fix = "tensor_filter input-combination=" +
                join(matches, ",", [](const auto& k) { return std::to_string(*k); });
    return out;
  }
  std::vector<std::string> missing;
  for (size_t i = 0; i < model.size(); ++i)
    if (!matches[i])
      missing.push_back(model[i].name.empty() ? "input " + std::to_string(i) : model[i].name);
  out.difference = "no tensor for " + join(missing, ", ");
  out.needed +=
      ": a stream for each input, joined by tensor_mux in their order; for a constant, a "
      "stream of one frame, and sync-mode=refresh";
  return out;
}

// The parts that are not empty, each followed by a link, and tensor_filter; "" without any.
std::string link_to_filter(std::initializer_list<std::string_view> parts) {
  std::string out;
  for (const auto part : parts)
    if (!part.empty()) out += std::string(part) + " ! ";
  return out.empty() ? "" : out + "tensor_filter";
}

// The cast of values of `type` to those of the model, "" where none is needed; nullopt if there is
// none.
std::optional<std::string> find_cast(ElementType type, const ModelTensor& needed) {
  if (needed.type == ElementType::End || needed.type == type) return "";
  auto cast = cast_elements(type, needed);
  return cast.empty() ? std::nullopt : std::optional(std::move(cast));
}

std::string elements_before(const TensorSpec& offered, const ModelTensor& needed, bool is_video) {
  const bool fits = dimensions_fit(needed, offered.shape);
  const std::string picture = fits || !is_video ? "" : picture_elements(needed);
  const auto cast = find_cast(picture.empty() ? offered.type : ElementType::UInt8, needed);
  if (!cast) return "";
  if (!picture.empty()) return link_to_filter({picture, *cast});
  const std::string shaped = fits ? "" : shaping_elements(offered, needed);
  // The type of a shape that is read from bytes is that of the cast.
  return fits || !shaped.empty() ? link_to_filter({*cast, shaped}) : "";
}

}  // namespace

bool looks_like_picture(const TensorSpec& tensor) {
  constexpr uint32_t kMinSide = 8;  // a smaller "picture" is more likely a table
  const auto at = [&tensor](size_t i) { return i < tensor.shape.rank() ? tensor.shape[i] : 1; };
  const auto are_channels = [](uint32_t extent) {
    return extent == 1 || extent == 3 || extent == 4;
  };
  const bool is_packed = are_channels(at(0)) && at(1) >= kMinSide && at(2) >= kMinSide;
  const bool is_planar = are_channels(at(2)) && at(0) >= kMinSide && at(1) >= kMinSide;
  return (is_packed || is_planar) && tensor.shape.rank() <= 4;
}

std::string suggested_fix(const TensorSpec& offered, const ModelTensor& needed, bool is_video) {
  if (offered.shape.is_empty()) return "";
  if (is_only_longer(offered, needed)) return "tensor_filter invoke-rows=1";
  return elements_before(offered, needed, is_video);
}

Result<std::vector<ModelTensor>> fit(const std::vector<ModelTensor>& model,
                                     const std::vector<TensorSpec>& stream) {
  if (model.empty()) return fit(std::vector<ModelTensor>(stream.size()), stream);
  if (model.size() != stream.size()) return other_number(model, stream);
  std::vector<ModelTensor> out;
  for (size_t i = 0; i < model.size(); ++i) {
    const std::string diff = difference(i, stream[i], model[i]);
    if (!diff.empty())
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the stream does not fit the model",
                   .offered = list(stream),
                   .needed = list_tensors(model),
                   .difference = diff,
                   .fix = suggested_fix(stream[i], model[i], looks_like_picture(stream[i]))};
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
