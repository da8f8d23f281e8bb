// SPDX-License-Identifier: LGPL-2.1-or-later
#include "compat/builtin_model.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "compat/builtin_engine.hpp"
#include "compat/guard.hpp"
#include "compat/tensors.hpp"
#include "core/infer/module/accelerator.hpp"
#include "core/infer/module/custom_options.hpp"
#include "core/infer/module/module_library.hpp"
#include "nnstreamer_plugin_api_util.h"
#include "weir/model.h"

namespace weir::compat {
namespace {

using Infos = std::vector<weir_tensor_info>;
using Pairs = std::vector<std::pair<std::string, std::string>>;

// Declares tensors as tensor_filter's properties would.
void declare(const char* role, const GstTensorsInfo& meta, Pairs* out) {
  const auto tensors = to_spec(meta).tensors;
  if (tensors.empty()) return;
  out->emplace_back(role, join_shapes(tensors));
  out->emplace_back(std::string(role) + "type", join_types(tensors));
  const auto names = join_names(tensors);
  if (names.find_first_not_of(',') != std::string::npos)
    out->emplace_back(std::string(role) + "name", names);
}

infer::OpenOptions make_request(const weir_engine& engine, const GstTensorFilterProperties& prop) {
  infer::OpenOptions request;
  request.paths = file_paths(prop.model_files, prop.num_models);
  const std::string custom = prop.custom_properties ? prop.custom_properties : "";
  const std::string accelerator = prop.accl_str ? prop.accl_str : "";
  request.options = infer::custom_options(custom);
  declare("input", prop.input_meta, &request.declared);
  declare("output", prop.output_meta, &request.declared);
  if (!custom.empty()) request.declared.emplace_back("custom", custom);
  if (!accelerator.empty()) request.declared.emplace_back("accelerator", accelerator);
  if (prop.invoke_dynamic) request.declared.emplace_back("invoke-dynamic", "true");
  request.accelerator = infer::choose_accelerator(infer::parse_accelerator(accelerator),
                                                  infer::list_accelerators(engine));
  return request;
}

bool is_known(const weir_tensor_info& info) {
  return info.type < WEIR_TYPE_END && info.rank <= WEIR_RANK_LIMIT &&
         std::all_of(info.shape, info.shape + info.rank, [](int64_t n) { return n > 0; });
}
bool are_known(const Infos& infos) {
  return !infos.empty() && std::all_of(infos.begin(), infos.end(), is_known);
}

// The caller may have left it uninitialised.
void write(const Infos& infos, GstTensorsInfo* to) {
  gst_tensors_info_init(to);
  assign(infos, to);
}

// Returns the caller's description with the model's rank, if only 1s are added or removed.
weir_tensor_info to_info(const GstTensorInfo& tensor, const Infos& model, size_t index) {
  const Shape shape = to_shape(tensor.dimension);
  weir_tensor_info info{};
  info.type = static_cast<uint32_t>(tensor.type);
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  info.rank = static_cast<uint32_t>(shape.rank());
  if (index < model.size() && model[index].rank <= WEIR_RANK_LIMIT &&
      shape.min_rank() <= model[index].rank)
    info.rank = model[index].rank;
  for (uint32_t i = 0; i < info.rank; ++i)
    info.shape[i] = std::max<int64_t>(1, shape[info.rank - 1 - i]);
  return info;
}

int no(const char* function, const Error& error) {
  warn(function, error);
  return -EINVAL;
}

Infos wanted_infos(const GstTensorsInfo& in, const Infos& model) {
  Infos wanted;
  for (size_t i = 0; i < in.num_tensors; ++i)
    if (const auto* tensor = tensor_at(in, i)) wanted.push_back(to_info(*tensor, model, i));
  return wanted;
}

// Returns the shapes in their least rank and `more` 1s.
Infos with_more_ones(Infos infos, uint32_t more) {
  for (auto& info : infos) {
    const auto* first =
        std::find_if(info.shape, info.shape + info.rank, [](int64_t n) { return n != 1; });
    const auto leading =
        std::min<uint32_t>(static_cast<uint32_t>(first - info.shape), info.rank - 1);
    const uint32_t rank = std::min<uint32_t>(info.rank - leading + more, WEIR_RANK_LIMIT);
    const uint32_t ones = rank - (info.rank - leading);
    if (ones <= leading)
      std::copy(info.shape + leading, info.shape + info.rank, info.shape + ones);
    else
      std::copy_backward(info.shape + leading, info.shape + info.rank, info.shape + rank);
    std::fill(info.shape, info.shape + ones, 1);
    info.rank = rank;
  }
  return infos;
}

// Returns the model's type if it is known, else that of the stream; bytes where neither is.
uint32_t type_of_input(const Infos& model, size_t i, const GstTensorInfo* meta) {
  if (i < model.size() && model[i].type < WEIR_TYPE_END) return model[i].type;
  return meta ? static_cast<uint32_t>(meta->type) : uint32_t{WEIR_UINT8};
}

std::vector<weir_tensor> input_tensors(const Infos& model, const GstTensorsInfo& metas,
                                       const GstTensorMemory* input) {
  const size_t count = model.empty() ? metas.num_tensors : model.size();
  std::vector<weir_tensor> out;
  for (size_t i = 0; i < count; ++i) {
    const auto* meta = i < metas.num_tensors ? tensor_at(metas, i) : nullptr;
    out.push_back(weir_tensor_of(input[i].data, input[i].size, type_of_input(model, i, meta)));
    if (meta && gst_tensor_info_validate(meta) && gst_tensor_info_get_size(meta) == input[i].size)
      out.back().info = to_info(*meta, model, i);
  }
  return out;
}

// Copies into the caller's memory; allocates where it has none.
int hand_over(const direct::Results& results, GstTensorFilterProperties* prop,
              GstTensorMemory* output) {
  Infos infos;
  for (size_t i = 0; i < results.tensors().size(); ++i) {
    const weir_tensor& tensor = results.tensors()[i];
    infos.push_back(tensor.info);
    if (!output[i].data) {
      output[i].data = g_memdup2(tensor.data, tensor.bytes);
      output[i].size = tensor.bytes;
    } else if (output[i].size == tensor.bytes) {
      std::memcpy(output[i].data, tensor.data, tensor.bytes);
    } else {
      return no("invoke",
                {.code = Code::FRAME_SIZE,
                 .what = "the memory for output " + std::to_string(i) + " has the wrong size",
                 .offered = std::to_string(output[i].size) + " bytes",
                 .needed = std::to_string(tensor.bytes) + " bytes"});
    }
  }
  if (prop && prop->invoke_dynamic) assign(infos, &prop->output_meta);
  return 0;
}

}  // namespace

std::unique_ptr<BuiltinModel> BuiltinModel::open(const weir_engine& engine,
                                                 const GstTensorFilterProperties& prop) {
  if (!can_be("open", prop.input_meta) || !can_be("open", prop.output_meta)) return nullptr;
  return open(engine, make_request(engine, prop));
}

std::unique_ptr<BuiltinModel> BuiltinModel::open(const weir_engine& engine,
                                                 infer::OpenOptions options) {
  if (options.paths.empty() && !(engine.flags & WEIR_ENGINE_NEEDS_NO_MODEL)) {
    no("open", {.code = Code::MODEL_NOT_FOUND,
                .what = "no model is set",
                .offered = "no model_files",
                .needed = "the path of a model file"});
    return nullptr;
  }
  auto model = direct::DirectModel::open(engine, options);
  if (!model) return no("open", model.error()), nullptr;
  return std::unique_ptr<BuiltinModel>(
      new BuiltinModel(engine, std::move(options), *std::move(model)));
}

std::unique_ptr<BuiltinModel> BuiltinModel::open_other(std::vector<std::string> paths) const {
  auto options = options_;
  options.paths = std::move(paths);
  return open(*engine_, std::move(options));
}

int BuiltinModel::get_inputs(GstTensorsInfo* in) {
  auto inputs = model_->inputs();
  if (!are_known(inputs)) {
    for (auto& info : inputs) {
      if (info.rank > WEIR_RANK_LIMIT || info.type >= WEIR_TYPE_END) return -ENOENT;
      std::replace_if(
          info.shape, info.shape + info.rank, [](int64_t n) { return n <= 0; }, 1);
    }
    if (inputs.empty() || !model_->reshape(inputs)) return -ENOENT;
  }
  if (in) write(model_->inputs(), in);
  return 0;
}

int BuiltinModel::get_outputs(GstTensorsInfo* out) {
  const auto outputs = model_->outputs();
  if (!are_known(outputs)) return -ENOENT;
  write(outputs, out);
  return 0;
}

int BuiltinModel::set_inputs(const GstTensorsInfo& in, GstTensorsInfo* out) {
  if (!can_be("set_inputs", in)) return -EINVAL;
  if (auto status = model_->reshape(wanted_infos(in, model_->inputs())); !status)
    return no("set_inputs", status.error());
  return get_outputs(out);
}

namespace {

// 0 if inputs of these descriptions may be resized to the wanted ones.
int check_sizes(const Infos& now, const Infos& wanted) {
  if (wanted.size() != now.size()) return -EINVAL;
  for (size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i].type != now[i].type || wanted[i].rank == 0) return -EINVAL;
    for (uint32_t k = 0; k < wanted[i].rank; ++k)
      if (wanted[i].shape[k] > std::numeric_limits<int>::max()) return -ERANGE;
  }
  return 0;
}

}  // namespace

int BuiltinModel::resize_inputs(const GstTensorsInfo& in, GstTensorsInfo* out) {
  if (!can_be("resize_inputs", in)) return -EINVAL;
  const auto now = model_->inputs();
  const auto wanted = wanted_infos(in, now);
  if (const int refused = check_sizes(now, wanted); refused != 0) return refused;
  if (model_->reshape(wanted)) return get_outputs(out);
  auto options = options_;
  options.options.emplace_back("Resize", "rank");
  auto resizable = open(*engine_, std::move(options));
  for (uint32_t more = 0; resizable && more < WEIR_RANK_LIMIT; ++more) {
    if (!resizable->model_->reshape(with_more_ones(wanted, more))) continue;
    model_ = std::move(resizable->model_);
    return get_outputs(out);
  }
  return -EPERM;
}

int BuiltinModel::invoke(GstTensorFilterProperties* prop, const GstTensorMemory* input,
                         GstTensorMemory* output) {
  static const GstTensorsInfo kNone{};
  const auto& metas = prop ? prop->input_meta : kNone;
  if (!can_be("invoke", metas)) return -EINVAL;
  const auto outcome = model_->invoke(input_tensors(model_->inputs(), metas, input));
  if (!outcome) return no("invoke", outcome.error());
  return outcome->dropped ? 1 : hand_over(outcome->results, prop, output);
}

}  // namespace weir::compat
