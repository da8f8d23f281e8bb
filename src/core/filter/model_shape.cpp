// Matches streams with models.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/model_shape.hpp"

#include "weir/join.hpp"

#include <algorithm>

namespace weir {
namespace {

std::string list(const std::vector<TensorSpec>& specs) {
  return std::to_string(specs.size()) + (specs.size() == 1 ? " tensor: " : " tensors: ") +
         join(specs, ", ", [](const TensorSpec& spec) { return spec.to_string(); });
}

// Dimension i of a model's shape, counted from the innermost; 1 beyond its rank.
int64_t inner(const ModelShape& shape, size_t i) {
  return i < shape.shape.size() ? shape.shape[shape.shape.size() - 1 - i] : 1;
}

bool dimensions_fit(const ModelShape& model, const Shape& stream) {
  if (!model.rank_known) return true;
  const size_t rank = std::max(model.shape.size(), stream.rank());
  for (size_t i = 0; i < rank; ++i) {
    const int64_t offered = i < stream.rank() ? stream[i] : 1;
    if (inner(model, i) >= 0 && inner(model, i) != offered) return false;
  }
  return true;
}

// Describes the first mismatch of a tensor; "" if it fits.
std::string difference(size_t index, const TensorSpec& offered, const ModelShape& needed) {
  const std::string who = "tensor " + std::to_string(index) +
                          (needed.name.empty() ? "" : " (" + needed.name + ")") + ": ";
  if (needed.type != ElementType::End && offered.type != needed.type)
    return who + "type is " + std::string(name_of(offered.type)) + ", needed is " +
           std::string(name_of(needed.type));
  const size_t rank = std::max(needed.shape.size(), offered.shape.rank());
  for (size_t i = 0; needed.rank_known && i < rank; ++i) {
    const int64_t have = i < offered.shape.rank() ? offered.shape[i] : 1;
    if (inner(needed, i) >= 0 && inner(needed, i) != have)
      return who + "dimension " + std::to_string(i) + " is " + std::to_string(have) +
             ", needed is " + std::to_string(inner(needed, i));
  }
  return "";
}

ModelShape filled(ModelShape model, const TensorSpec& stream) {
  model.type = stream.type;
  if (!model.rank_known) {
    model.rank_known = true;
    model.shape.clear();
    for (size_t i = stream.shape.rank(); i-- > 0;) model.shape.push_back(stream.shape[i]);
    return model;
  }
  for (size_t i = 0; i < model.shape.size(); ++i) {
    const size_t from_inside = model.shape.size() - 1 - i;
    if (model.shape[i] < 0)
      model.shape[i] = from_inside < stream.shape.rank() ? stream.shape[from_inside] : 1;
  }
  return model;
}

bool is_picture(const ModelShape& m, size_t channel_axis) {
  return m.rank_known && m.shape.size() >= 3 && m.shape.size() <= 4 &&
         (inner(m, channel_axis) == 1 || inner(m, channel_axis) == 3 ||
          inner(m, channel_axis) == 4);
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
                     ModelShape* shape) {
  ModelShape needed = *shape;
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

}  // namespace

bool ModelShape::fixed() const noexcept {
  return type != ElementType::End && rank_known &&
         std::all_of(shape.begin(), shape.end(), [](int64_t d) { return d > 0; });
}

std::string ModelShape::to_string() const {
  std::string out = type == ElementType::End ? "any type" : std::string(name_of(type));
  if (!rank_known) return out + " of any dimension";
  out += ' ';
  if (shape.empty()) return out + "1";
  for (size_t i = 0; i < shape.size(); ++i) {
    const int64_t d = inner(*this, i);
    out += (i ? ":" : "") + (d < 0 ? std::string("?") : std::to_string(d));
  }
  return out;
}

TensorSpec to_spec(const ModelShape& model) {
  TensorSpec spec{model.type, {}, model.name};
  if (model.shape.empty()) spec.shape[0] = 1;
  for (size_t i = 0; i < std::min(model.shape.size(), kRankLimit); ++i)
    spec.shape[i] = static_cast<uint32_t>(inner(model, i));
  return spec;
}

std::string list_shapes(const std::vector<ModelShape>& shapes) {
  return std::to_string(shapes.size()) + (shapes.size() == 1 ? " tensor: " : " tensors: ") +
         join(shapes, ", ", [](const ModelShape& shape) { return shape.to_string(); });
}

std::vector<TensorSpec> known_parts(const std::vector<ModelShape>& shapes) {
  std::vector<TensorSpec> out;
  for (const auto& shape : shapes) {
    if (shape.fixed())
      out.push_back(to_spec(shape));
    else
      out.push_back({shape.type, {}, shape.name});
  }
  return out;
}

namespace {

// Whether several pictures came for a model of one.
bool is_only_longer(const TensorSpec& offered, const ModelShape& needed) {
  if (!needed.rank_known || needed.shape.size() < 2 || needed.shape[0] != 1) return false;
  TensorSpec one = offered;
  one.shape[needed.shape.size() - 1] = 1;
  return offered.shape.rank() == needed.shape.size() && one.type == needed.type &&
         dimensions_fit(needed, one.shape);
}

}  // namespace

std::string suggested_fix(const TensorSpec& offered, const ModelShape& needed) {
  if (is_only_longer(offered, needed))
    return "tensor_filter invoke-rows=1, which runs the model for each of them";
  const bool outer = is_picture(needed, 0);
  const bool planar = !outer && is_picture(needed, 2);
  const int64_t channels = outer ? inner(needed, 0) : inner(needed, 2);
  const int64_t width = outer ? inner(needed, 1) : inner(needed, 0);
  const int64_t height = outer ? inner(needed, 2) : inner(needed, 1);
  std::string fix;
  const auto add = [&fix](const std::string& part) { fix += (fix.empty() ? "" : " ! ") + part; };
  if (!dimensions_fit(needed, offered.shape)) {
    if (outer) {
      add(scaled_video(channels, width, height));
    } else if (planar) {
      add(scaled_video(channels, width, height));
      add("tensor_transform mode=transpose option=1:2:0:3");
    } else {
      return "";
    }
  }
  if (needed.type != ElementType::End && needed.type != offered.type)
    add("tensor_transform mode=typecast option=" + std::string(name_of(needed.type)));
  return fix.empty() ? "" : fix + " ! tensor_filter";
}

Result<std::vector<ModelShape>> fit(const std::vector<ModelShape>& model,
                                    const std::vector<TensorSpec>& stream) {
  if (model.empty()) return fit(std::vector<ModelShape>(stream.size()), stream);
  if (model.size() != stream.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the stream and the model have different numbers of tensors",
                 .offered = list(stream),
                 .needed = list_shapes(model),
                 .difference = "number of tensors",
                 .fix = stream.size() > model.size() ? "choose tensors with input-combination=0"
                                                     : "join streams with tensor_mux"};
  std::vector<ModelShape> out;
  for (size_t i = 0; i < model.size(); ++i) {
    const std::string diff = difference(i, stream[i], model[i]);
    if (!diff.empty())
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "the stream does not fit the model",
                   .offered = list(stream),
                   .needed = list_shapes(model),
                   .difference = diff,
                   .fix = suggested_fix(stream[i], model[i])};
    out.push_back(filled(model[i], stream[i]));
  }
  return out;
}

Result<std::vector<ModelShape>> with_user_settings(std::vector<ModelShape> model,
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
                 .needed = list_shapes(model),
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
