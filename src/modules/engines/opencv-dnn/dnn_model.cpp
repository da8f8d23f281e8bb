// Opens a network. The user's options complete what the files do not declare, and override sizes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "opencv-dnn/dnn_model.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "dry_run.hpp"
#include "opencv-dnn/dnn_files.hpp"
#include "tensor_check.hpp"
#include "usable_cores.hpp"
#include "weir/engine_tools.hpp"
#include "weir/join.hpp"

namespace weir::engine {
namespace {

std::string list(const std::vector<std::string>& names) {
  constexpr size_t kMost = 12;
  const std::string out = join(std::span(names).first(std::min(names.size(), kMost)), ", ");
  return names.size() > kMost ? out + " and " + std::to_string(names.size() - kMost) + " more"
                              : out;
}

Error no_such_name(const char* property, const std::string& name,
                   const std::vector<std::string>& known) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = std::string(property) + " names a layer that the network lacks",
               .offered = name,
               .needed = "one of: " + list(known),
               .fix = known.empty() ? "" : std::string(property) + "=" + known.back()};
}

// The tensor "input:0" of TensorFlow's own interface is the node "input".
std::string node_name(const std::string& name) {
  return dnn_engine.format == DnnFormat::Tensorflow ? name.substr(0, name.find(':')) : name;
}

weir_tensor_info info_of(const DeclaredTensor& tensor) {
  weir_tensor_info info = open_tensor_info();
  info.type = tensor.type == WEIR_TYPE_END ? uint32_t{WEIR_FLOAT32} : tensor.type;
  if (tensor.has_shape) set_shape(&info, tensor.shape.begin(), tensor.shape.size());
  return info;
}

}  // namespace

Status DnnModel::read_options(const weir_open& request) {
  constexpr int kThreadLimit = 1024;
  threads_ = request.threads > 0 ? std::min<int>(request.threads, kThreadLimit) : usable_cores();
  for (uint32_t i = 0; request.options && i < request.n_options; ++i) {
    const auto key = text_or_empty(request.options[i].key);
    const auto value = text_or_empty(request.options[i].value);
    if (equals_ignoring_case(key, "NumThreads")) {
      const auto threads = number_option(key, value, 1);
      if (!threads) return threads.error();
      threads_ = std::min(*threads, kThreadLimit);
      continue;
    }
    const auto taken = declared_.take(key, value);
    if (!taken) return taken.error();
    if (!*taken) warn_unknown_option(key, "NumThreads");
  }
  return ok();
}

Result<std::unique_ptr<DnnModel>> DnnModel::open(const weir_open& request) {
  std::unique_ptr<DnnModel> model(new DnnModel);
  if (auto status = model->read_options(request); !status) return status.error();
  auto source = read_dnn_files(request);
  if (!source) return source.error();
  auto net = DnnNet::read(source->files);
  if (!net) return net.error();
  model->net_ = *std::move(net);
  model->weight_bytes_ = source->files.weights.size();
  model->nhwc_ = source->description.nhwc;
  if (auto status = model->read_inputs(source->description); !status) return status.error();
  if (auto status = model->read_outputs(source->description); !status) return status.error();
  const nlohmann::json metadata{{"operators", source->description.operators},
                                {"opencv", DnnNet::version()}};
  model->metadata_ = metadata.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return model;
}

// The network's inputs, in the order and with the sizes that the user gives.
Status DnnModel::read_inputs(const DnnDescription& description) {
  std::vector<DeclaredTensor> found = description.inputs;
  const auto& declared = declared_.inputs();
  std::vector<std::string> known;
  for (const auto& input : found) known.push_back(input.name);
  std::vector<DeclaredTensor> chosen;
  for (size_t i = 0; i < declared.size(); ++i) {
    if (declared[i].name.empty()) continue;
    const auto name = node_name(declared[i].name);
    const auto at = std::find_if(found.begin(), found.end(),
                                 [&](const auto& input) { return input.name == name; });
    if (at == found.end()) return no_such_name("inputname", name, known);
    chosen.push_back(*at);
    found.erase(at);
  }
  chosen.insert(chosen.end(), found.begin(), found.end());
  if (chosen.empty() || chosen.size() > WEIR_TENSOR_LIMIT || declared.size() > chosen.size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the network has a different number of inputs",
                 .offered = std::to_string(chosen.size()) + ": " + list(known),
                 .needed = std::to_string(std::max<size_t>(declared.size(), 1)),
                 .difference = "number of tensors"};
  for (size_t i = 0; i < chosen.size(); ++i) {
    if (i < declared.size()) {
      if (declared[i].type != WEIR_TYPE_END) chosen[i].type = declared[i].type;
      if (declared[i].has_shape) chosen[i].shape = declared[i].shape, chosen[i].has_shape = true;
    }
    input_names_.push_back(chosen[i].name);
    inputs_.push_back(info_of(chosen[i]));
    if (inputs_[i].rank == 4) inputs_[i].layout = nhwc_ ? WEIR_LAYOUT_NHWC : WEIR_LAYOUT_NCHW;
  }
  for (size_t i = 0; i < inputs_.size(); ++i) inputs_[i].name = input_names_[i].c_str();
  return ok();
}

Status DnnModel::read_outputs(const DnnDescription& description) {
  const auto layers = net_->layers();
  for (const auto& output : declared_.outputs()) {
    if (output.name.empty()) continue;
    auto name = node_name(output.name);
    const auto is_layer = [&] {
      return std::find(layers.begin(), layers.end(), name) != layers.end();
    };
    for (size_t steps = description.passed.size(); steps > 0 && !is_layer(); --steps)
      if (const auto to = description.passed.find(name); to != description.passed.end())
        name = to->second;
    if (!is_layer()) return no_such_name("outputname", node_name(output.name), layers);
    output_names_.push_back(name);
  }
  // Layers that OpenCV inserts are not in TensorFlow's graph.
  if (output_names_.empty())
    for (const auto& name : net_->ends())
      if (description.nodes.empty() || description.nodes.contains(name))
        output_names_.push_back(name);
  if (output_names_.empty() || output_names_.size() > WEIR_TENSOR_LIMIT)
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the network's outputs cannot be found",
                 .offered = list(net_->ends()),
                 .needed = "their names",
                 .fix = "outputname=" + (layers.empty() ? std::string("NAME") : layers.back())};
  pictures_ = std::make_unique<bool[]>(output_names_.size());
  outputs_.assign(output_names_.size(), open_tensor_info());
  for (size_t i = 0; i < outputs_.size(); ++i) {
    pictures_[i] = description.pictures.contains(output_names_[i]);
    outputs_[i].name = output_names_[i].c_str();
  }
  if (!std::all_of(inputs_.begin(), inputs_.end(), is_fixed)) return ok();
  auto infos = dry_run(inputs_);
  if (!infos) return infos.error();
  outputs_ = *std::move(infos);
  return ok();
}

Result<std::vector<DnnOutput>> DnnModel::run(std::span<const weir_tensor> in) const {
  std::vector<DnnInput> inputs(in.size());
  for (size_t i = 0; i < in.size(); ++i) {
    // OpenCV has no name for Darknet's only input.
    inputs[i].name = in.size() == 1 ? "" : input_names_[i];
    inputs[i].data = in[i].data;
    inputs[i].info = in[i].info;
    inputs[i].nhwc = nhwc_;
  }
  return net_->run(inputs, output_names_, {pictures_.get(), output_names_.size()}, threads_);
}

Result<std::vector<weir_tensor_info>> DnnModel::dry_run(
    std::span<const weir_tensor_info> in) const {
  auto inputs = DryRunInputs::create(in);
  if (!inputs) return inputs.error();
  const auto made = run(inputs->tensors());
  if (!made) {
    if (made.error().code != Code::INVOKE_FAILED) return made.error();
    return Error{
        .code = Code::SPEC_MISMATCH,
        .what = "the network does not accept inputs of these shapes",
        .offered = engine::describe(in),
        .difference = made.error().offered +
                      (made.error().difference.empty() ? "" : " at " + made.error().difference),
        .fix = "set input= to the sizes that the network was built for"};
  }
  std::vector<weir_tensor_info> out;
  for (size_t i = 0; i < made->size(); ++i) {
    out.push_back((*made)[i].info);
    out.back().name = output_names_[i].c_str();
  }
  return out;
}

void DnnModel::describe(weir_model_info* info) const {
  info->flags = WEIR_MODEL_FORK_UNSAFE;
  info->n_inputs = static_cast<uint32_t>(inputs_.size());
  info->n_outputs = static_cast<uint32_t>(outputs_.size());
  info->inputs = inputs_.data();
  info->outputs = outputs_.data();
  info->alignment = info->input_padding = 0;  // inputs are copied
  info->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
  info->max_sessions = 1;  // the network has one set of layer memory
  info->max_in_flight = 1;
  info->preferred_batch = 1;
  info->weight_bytes = weight_bytes_;
  info->metadata_json = metadata_.c_str();
}

}  // namespace weir::engine
